// W3C Trace Context: which trace a request belongs to, across the services that it passes.
#pragma once

#include <string>
#include <string_view>

namespace furnace {

// Ids as OpenTelemetry has them: lower-case hexadecimal digits, never all zero.
// Threads: a value.
struct TraceContext {
  std::string trace_id;   // 32 digits; empty: no trace
  std::string span_id;    // 16 digits: our own work
  std::string parent_id;  // 16 digits: the caller's; empty when the trace begins here
  unsigned flags = 0;     // of kSampled and kRandom

  static constexpr unsigned kSampled = 1;  // the caller records this trace
  static constexpr unsigned kRandom = 2;   // level 2: the trace id is random

  // As the fields traceparent and traceresponse are written, with our own span.
  std::string text() const;
};

// A new span of the trace that a traceparent field names. What is no valid field begins a new trace, as the specification asks.
TraceContext trace_of(std::string_view traceparent);

}  // namespace furnace
