// Children that decode: started as they are needed, replaced when they fail or have served long enough.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "renderer/base/confined_thread.hpp"
#include "renderer/base/deadline.hpp"
#include "renderer/decode/worker_process.hpp"

namespace furnace::decode {

struct PoolConfig {
  WorkerCommand command;
  int processes = 1;                          // at once, at most
  bool needs_whole_sandbox = false;           // else what it lacks is logged, once
  std::chrono::milliseconds timeout{20'000};  // of one file
  int jobs_per_process = 200;
  std::int64_t bytes_per_process = 4ll << 30;
};

// Counts since the start.
struct PoolStats {
  std::int64_t jobs = 0;      // done, with whatever outcome
  std::int64_t crashes = 0;   // children that ended or lied while at work
  std::int64_t timeouts = 0;  // children killed over a file, for its own time or the request's
  std::int64_t starts = 0;
  int processes = 0;  // now
};

// How soon after failures another child may be started: a burst at once, then at a steady rate.
// Threads: one.
class RestartBudget {
 public:
  static constexpr std::chrono::milliseconds kInterval{100};
  static constexpr int kBurst = 20;

  void note_failure(Clock::time_point now) { owed_until_ = std::max(owed_until_, now) + kInterval; }
  Clock::time_point next_start() const { return owed_until_ - kBurst * kInterval; }

 private:
  Clock::time_point owed_until_{};
};

// Threads: any. Owns: the children and the thread that starts them.
class ProcessPool {
 public:
  // Starts one child. Errors: kInternal, when it does not start, or is not sandboxed as it has to be.
  explicit ProcessPool(const PoolConfig& config);
  ~ProcessPool();
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  // Waits for a child, and for it. Errors: what the decoder reports; kUnprocessable when it fails on the file or takes longer
  // than a file may; kDeadlineExceeded; kInternal without memory or processes.
  void run(const Task& task, const Deadline& deadline);

  PoolStats stats() const;
  const std::string& sandbox_problem() const { return sandbox_problem_; }  // of the first child; empty: none

 private:
  using WorkerPointer = std::unique_ptr<WorkerProcess>;
  struct Starter {};  // what the starting thread owns: nothing

  WorkerPointer start(const Deadline& deadline);
  WorkerPointer lease(const Deadline& deadline);
  void give_back(WorkerPointer worker);
  void retire(WorkerPointer worker);  // without blame
  // Replaces it later; returns how it ended.
  std::string bury(WorkerPointer worker);
  [[noreturn]] void fail_over(const Task& task, Outcome::Kind kind, WorkerPointer worker,
                              const Deadline& deadline);

  const PoolConfig config_;
  std::string sandbox_problem_;
  // A child ends with the thread that started it, so that is one of its own.
  ConfinedThread<Starter> starter_;

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<WorkerPointer> idle_;
  int alive_ = 0;  // idle, at work, being started
  RestartBudget restarts_;
  PoolStats stats_;
};

}  // namespace furnace::decode
