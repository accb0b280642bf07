// The pool, the time that is left and how far a bake has come: what every long loop of the bake needs.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <string_view>
#include <thread>

#include "renderer/base/deadline.hpp"
#include "renderer/base/worker_pool.hpp"

namespace furnace {

// Called with fractions of a bake that never fall, from the thread that bakes alone.
using BakeProgress = std::function<void(double fraction)>;

// Threads: one caller, whose loops run on the pool. Owns: nothing; the pool must outlive it.
class BakeWork {
 public:
  BakeWork(WorkerPool& pool, Deadline deadline = {},
           BakeProgress report = {})  // NOLINT: a pool alone will do
      : pool_(pool), deadline_(std::move(deadline)), report_(std::move(report)) {}

  // What comes next, and which share of the whole it is (the shares add up to 1): kDeadlineExceeded ends it here.
  void begin(std::string_view stage, double share);
  // All is done: reports 1.
  void finish();

  // WorkerPool::parallel_for that looks at the clock before each piece and reports after each of the caller's own.
  void parallel_for(std::size_t count, double cost_us, const std::function<void(std::size_t)>& body);

 private:
  void report(double of_stage);

  WorkerPool& pool_;
  Deadline deadline_;
  BakeProgress report_;
  std::string_view stage_ = "environment";
  double before_ = 0;  // shares of the stages that are done
  double share_ = 0;   // of this one
  double reported_ = -1;
};

}  // namespace furnace
