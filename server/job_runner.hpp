// The threads that work through the list of jobs.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "server/job_store.hpp"
#include "server/render_progress.hpp"

namespace furnace {

struct JobRunnerConfig {
  int threads = 1;
  std::chrono::milliseconds timeout{600'000};  // of one job, once it has begun
  std::chrono::milliseconds deadline{
      24ll * 3600'000};  // of one job, from when it was asked for, its turns in the queue included
};

std::int64_t unix_time_ms();  // as even_now

// Threads: any. Owns: its threads; the store outlives it. What runs when it ends waits again.
class JobRunner {
 public:
  // What is to be kept as the job's result. Hears how far it is; may throw an Error.
  using Work = std::function<std::string(const JobRequest& request, const Deadline& deadline,
                                         const TellProgress& progress)>;

  // `ended` is called after a job has ended, on the thread that ended it.
  JobRunner(JobStore& store, Work work, const JobRunnerConfig& config, std::function<void()> ended = {});
  ~JobRunner();

  // There may be something to do.
  void wake();
  // As JobStore::remove; work on it ends soon.
  bool remove(const std::string& id);

 private:
  void run_thread();
  bool tries(const std::function<bool()>& step);
  bool run_next();
  void keep(const std::function<void()>& write);
  bool is_stopping();
  std::chrono::milliseconds time_for(const std::string& id);
  std::string run(const JobWork& work, std::stop_token cancel);

  JobStore& store_;
  const Work work_;
  const JobRunnerConfig config_;
  const std::function<void()> ended_;
  std::mutex mutex_;  // of the members below
  std::condition_variable changed_;
  bool stopping_ = false;
  bool woken_ = false;               // since somebody looked for work last
  Clock::time_point quiet_until_{};  // of what hinders
  std::map<std::string, std::stop_source> running_;
  std::vector<std::thread> threads_;
};

}  // namespace furnace
