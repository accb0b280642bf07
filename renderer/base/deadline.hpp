// The end of a request's time, handed down by value; checked between stages and between sub-frames.
#pragma once

#include <chrono>
#include <stop_token>
#include <string_view>
#include <utility>

namespace furnace {

using Clock = std::chrono::steady_clock;

// Threads: any, a value.
class Deadline {
 public:
  Deadline() = default;  // never
  explicit Deadline(std::chrono::milliseconds from_now, std::stop_token cancel = {})
      : end_(Clock::now() + from_now), cancel_(std::move(cancel)) {}

  Clock::time_point end() const { return end_; }
  const std::stop_token& cancel_token() const { return cancel_; }
  bool cancelled() const { return cancel_.stop_requested(); }
  bool passed() const { return cancelled() || Clock::now() >= end_; }

 private:
  Clock::time_point end_ = Clock::time_point::max();
  std::stop_token cancel_;
};

// Fails with kDeadlineExceeded, naming the stage, when the time is over or the client has gone.
void check_deadline(const Deadline& deadline, std::string_view stage);
// For a wait that has ended without what it waited for.
[[noreturn]] void fail_deadline(const Deadline& deadline, std::string_view stage);

}  // namespace furnace
