#include "server/job_runner.hpp"

#include <algorithm>
#include <utility>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "api/problem.hpp"
#include "server/even_time.hpp"

namespace furnace {

namespace {

// Also how soon a job is tried again for which there was no seat, and a disk that failed.
constexpr std::chrono::milliseconds kPause{500};
constexpr std::chrono::minutes kQuiet{1};  // between two lines about the disk

}  // namespace

std::int64_t unix_time_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(even_now().time_since_epoch()).count();
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
    const bool worked = tries([this] { return run_next(); });
    lock.lock();
    if (!worked) changed_.wait_for(lock, kPause, [this] { return stopping_ || woken_; });
  }
}

// Whether `step` was done; what hinders it is logged.
bool JobRunner::tries(const std::function<bool()>& step) {
  Error hindrance;
  try {
    return step();
  } catch (const Error& error) {
    hindrance = error;
  } catch (const std::exception& stray) {
    hindrance.detail = stray.what();
  }
  const std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  if (now >= quiet_until_)
    log::error("jobs.failed", {{"message", hindrance.message}, {"detail", hindrance.detail}});
  quiet_until_ = std::max(quiet_until_, now + kQuiet);
  return false;
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
    const std::string result = run(*work, stop.get_token());
    keep([&] { store_.succeed(work->id, result, unix_time_ms()); });
    log::info("job.done", {{"id", work->id}});
  } catch (const Error& error) {
    worked = error.code != ErrorCode::kOverloaded;  // interactive requests go first
    if (!worked || is_stopping()) {
      keep([&] { store_.put_back(work->id); });
    } else {
      keep([&] { store_.fail(work->id, api::problem_json(error, work->id), unix_time_ms()); });
    }
  }
  ended_();
  const std::lock_guard lock(mutex_);
  running_.erase(work->id);
  return worked;
}

// What a job has come to is not lost to a disk that is full for a while: until it is kept, the job runs. It is drawn again if
// the process ends first.
void JobRunner::keep(const std::function<void()>& write) {
  const auto step = [&] {
    write();
    return true;
  };
  while (!tries(step)) {
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, kPause, [this] { return stopping_; })) return;
  }
}

bool JobRunner::is_stopping() {
  const std::lock_guard lock(mutex_);
  return stopping_;
}

// Errors: kDeadlineExceeded when its time was over before its turn came.
std::chrono::milliseconds JobRunner::time_for(const std::string& id) {
  const std::optional<Job> job = store_.find(id);
  const std::int64_t created_ms = job ? job->created_ms : unix_time_ms();
  const auto left = config_.deadline - std::chrono::milliseconds(unix_time_ms() - created_ms);
  if (left.count() <= 0)
    furnace::fail(ErrorCode::kDeadlineExceeded, "The job's time was over before its turn came.");
  return std::min(config_.timeout, left);
}

// Errors: those of the work; what is thrown otherwise becomes one.
std::string JobRunner::run(const JobWork& work, std::stop_token cancel) {
  const log::RequestScope scope({work.id, {}, {}});
  log::info("job.begin", {{"id", work.id}});
  const auto progress = [&](const RenderProgress& now) { store_.tell_progress(work.id, now); };
  try {
    return work_(work.request, Deadline(time_for(work.id), std::move(cancel)), progress);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& stray) {
    furnace::fail(ErrorCode::kInternal,
                  "The server made a mistake; its log has the details under this job's id.", {},
                  stray.what());
  }
}

}  // namespace furnace
