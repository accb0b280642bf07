// Wall time of a scope, added to a sum.
#pragma once

#include <chrono>

#include "renderer/base/deadline.hpp"

namespace furnace {

// Threads: one. Owns: nothing; `total_ms` outlives it.
class Stopwatch {
 public:
  explicit Stopwatch(double& total_ms) : total_ms_(total_ms) {}
  ~Stopwatch() { total_ms_ += std::chrono::duration<double, std::milli>(Clock::now() - start_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_ms_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace furnace
