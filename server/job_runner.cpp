#include "server/job_runner.hpp"

#include <utility>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "api/problem.hpp"

namespace furnace {

namespace {

// Also how soon a job is tried again for which there was no seat, and a disk that failed.
constexpr std::chrono::milliseconds kPause{500};

}  // namespace

std::int64_t unix_time_ms() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
}

JobRunner::JobRunner(JobStore& store, Work work, const JobRunnerConfig& config, std::function<void()> ended)
    : store_(store), work_(std::move(work)), config_(config), ended_(ended ? std::move(ended) : [] {}) {
  for (int i = 0; i < config.threads; ++i) threads_.emplace_back([this] { run_thread(); });
}

JobRunner::~JobRunner() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (auto& [id, stop] : running_) stop.request_stop();
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void JobRunner::wake() {
  {
    const std::lock_guard lock(mutex_);
    woken_ = true;
  }
  changed_.notify_one();
}

bool JobRunner::remove(const std::string& id) {
  const bool known = store_.remove(id, unix_time_ms());
  ended_();
  const std::lock_guard lock(mutex_);
  if (const auto found = running_.find(id); found != running_.end()) found->second.request_stop();
  return known;
}

void JobRunner::run_thread() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    woken_ = false;
    lock.unlock();
    bool worked = false;
    try {
      worked = run_next();
    } catch (const Error& error) {
      log::error("jobs.failed", {{"message", error.message}, {"detail", error.detail}});
    } catch (const std::exception& error) {
      log::error("jobs.failed", {{"detail", error.what()}});
    }
    lock.lock();
    if (!worked) changed_.wait_for(lock, kPause, [this] { return stopping_ || woken_; });
  }
}

// False when there was nothing to do, or no room to do it.
bool JobRunner::run_next() {
  const std::optional<JobWork> work = store_.begin(unix_time_ms());
  if (!work) return false;
  std::stop_source stop;
  {
    const std::lock_guard lock(mutex_);
    running_.emplace(work->id, stop);
    if (stopping_) stop.request_stop();
  }
  bool worked = true;
  try {
    run(*work, stop.get_token());
  } catch (const Error& error) {
    bool ends = error.code == ErrorCode::kOverloaded;  // interactive requests go first
    worked = !ends;
    {
      const std::lock_guard lock(mutex_);
      ends = ends || stopping_;
    }
    if (ends) {
      store_.put_back(work->id);
    } else {
      store_.fail(work->id, api::problem_json(error, work->id), unix_time_ms());
    }
  }
  ended_();
  const std::lock_guard lock(mutex_);
  running_.erase(work->id);
  return worked;
}

void JobRunner::run(const JobWork& work, std::stop_token cancel) {
  const log::RequestScope scope(work.id);
  log::info("job.begin", {{"id", work.id}});
  const auto progress = [&](int done, int of) { store_.tell_progress(work.id, done, of); };
  try {
    const std::string result = work_(work.request, Deadline(config_.timeout, std::move(cancel)), progress);
    store_.succeed(work.id, result, unix_time_ms());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& stray) {
    furnace::fail(ErrorCode::kInternal,
                  "The server made a mistake; its log has the details under this job's id.", {},
                  stray.what());
  }
  log::info("job.done", {{"id", work.id}});
}

}  // namespace furnace
