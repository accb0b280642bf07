// A job that only the tests' worker knows: it does what a decoder that was taken over, or is broken, might do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/decode/jobs.hpp"

namespace furnace::decode::test {

enum class Deed : std::uint8_t {
  kReverse,          // the file backwards: an honest one
  kSpin,             // the same after `number` milliseconds
  kTellPid,          // the child's process id as text
  kTellEnvironment,  // its environment variables
  kTellDescriptors,  // the numbers of its open descriptors, but the socket's
  kRefuse,           // an Error that a file may earn
  kBlameUs,          // an Error that none may earn
  kThrowForeign,     // an exception of a library
  kSegfault,
  kAbort,
  kOverflowStack,
  kExit,
  kAllocate,        // without bound
  kAllocateShared,  // memory that no limit counts
  kOpenFile,
  kOpenSocket,
  kFork,
  kStartThread,
  kExec,
  kMapCode,
  kMakeCode,
  kSignalParent,
  kRaiseLimits,
  kWriteElsewhere,  // to a descriptor other than the socket
  kSayNothingMore,  // closes the socket and goes on
  kSayNoise,        // an answer that is none
  kSayOtherSerial,  // the answer to another question
  kClaimHugeArray,
  kClaimLongText,
  kUnsound,  // a result that `accepts` does not take
  kLast = kUnsound
};

struct Echo {
  std::vector<std::byte> bytes;
};

struct HostileJob {
  using Result = Echo;
  static constexpr JobKind kKind = JobKind::kFirstOfTests;
  static constexpr std::string_view kName = "hostile";

  Deed deed = Deed::kReverse;
  std::int64_t number = 0;

  Result run(Bytes file) const;
  std::int64_t largest_result_bytes() const { return 1 << 20; }
  bool accepts(const Result& result) const { return result.bytes.size() < (1 << 20); }
};

template <class Wire>
void fields(Wire& wire, WireValue<Wire, HostileJob>& job) {
  wire.choice(job.deed, Deed::kLast);
  wire.number(job.number);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, Echo>& echo) {
  wire.array(echo.bytes);
}

}  // namespace furnace::decode::test
