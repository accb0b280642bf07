#include "renderer/decode/process_pool.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"

namespace furnace::decode {
namespace {

// A program starts within milliseconds; a machine that is busy beyond measure gets its time.
constexpr std::chrono::milliseconds kGreetingTime{10'000};

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

ProcessPool::ProcessPool(const PoolConfig& config)
    : config_(config), starter_("decoders", [] { return std::make_unique<Starter>(); }) {
  FURNACE_CHECK(config_.processes >= 1, "{} processes", config_.processes);
  WorkerPointer first = lease(Deadline());
  give_back(std::move(first));
}

ProcessPool::~ProcessPool() {
  const std::lock_guard lock(mutex_);
  FURNACE_CHECK(idle_.size() == std::size_t(alive_), "{} of {} children are at work", alive_, idle_.size());
  idle_.clear();
}

ProcessPool::WorkerPointer ProcessPool::start(const Deadline& deadline) {
  const Clock::time_point begun = Clock::now();
  WorkerPointer worker =
      starter_.call(deadline, [this](Starter&) { return std::make_unique<WorkerProcess>(config_.command); });
  const std::optional<std::string> problem = worker->greet(Clock::now() + kGreetingTime);
  const pid_t pid = worker->pid();
  if (!problem) {
    fail(ErrorCode::kInternal, "no decoder could be started; try again", {},
         fmt::format("the worker does not answer: {}", worker->end()));
  }
  if (!problem->empty() && config_.needs_whole_sandbox) {
    fail(ErrorCode::kInternal, "decoders cannot be sandboxed on this system", {},
         *problem + "; decoder-sandbox = prefer does without");
  }
  log::debug("decoder.started", {{"pid", pid}, {"ms", ms_since(begun)}, {"sandboxed", problem->empty()}});
  const std::lock_guard lock(mutex_);
  if (stats_.starts++ == 0 && !problem->empty()) {
    sandbox_problem_ = *problem;
    log::warning("decoder.unsandboxed", {{"problem", *problem}});
  }
  return worker;
}

ProcessPool::WorkerPointer ProcessPool::lease(const Deadline& deadline) {
  std::unique_lock lock(mutex_);
  const auto may_start = [&] { return alive_ < config_.processes && Clock::now() >= restarts_.next_start(); };
  while (idle_.empty() && !may_start()) {
    if (deadline.passed()) {
      lock.unlock();
      fail_deadline(deadline, "waiting for a decoder");
    }
    const auto until =
        alive_ < config_.processes ? std::min(deadline.end(), restarts_.next_start()) : deadline.end();
    changed_.wait_until(lock, deadline.cancel_token(), until, [&] { return !idle_.empty() || may_start(); });
  }
  if (!idle_.empty()) {
    WorkerPointer worker = std::move(idle_.back());
    idle_.pop_back();
    return worker;
  }
  ++alive_;
  lock.unlock();
  try {
    return start(deadline);
  } catch (...) {
    lock.lock();
    --alive_;
    restarts_.note_failure(Clock::now());
    changed_.notify_one();
    throw;
  }
}

void ProcessPool::give_back(WorkerPointer worker) {
  if (worker->jobs() >= config_.jobs_per_process || worker->bytes() >= config_.bytes_per_process) {
    log::debug("decoder.recycled", {{"pid", worker->pid()}, {"jobs", worker->jobs()}});
    retire(std::move(worker));
    return;
  }
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(worker));
  changed_.notify_one();
}

void ProcessPool::retire(WorkerPointer worker) {
  worker.reset();
  const std::lock_guard lock(mutex_);
  --alive_;
  changed_.notify_all();  // some wait for a child, some for the time when one may be started
}

std::string ProcessPool::bury(WorkerPointer worker) {
  std::string ending = worker->end();
  {
    const std::lock_guard lock(mutex_);
    restarts_.note_failure(Clock::now());
  }
  retire(std::move(worker));
  return ending;
}

void ProcessPool::fail_over(const Task& task, Outcome::Kind kind, WorkerPointer worker,
                            const Deadline& deadline) {
  const pid_t pid = worker->pid();
  const std::string ending = bury(std::move(worker));
  const bool timed_out = kind == Outcome::Kind::kOutOfTime;
  {
    const std::lock_guard lock(mutex_);
    ++(timed_out ? stats_.timeouts : stats_.crashes);
  }
  const auto tell = [&](const char* event, const std::string& reason) {
    log::warning(event,
                 {{"pid", pid}, {"job", task.name}, {"file_bytes", task.file.size()}, {"reason", reason}});
  };
  if (timed_out) {
    tell("decoder.timeout", deadline.passed() ? "the request's time" : "the file's time");
    if (deadline.passed()) fail_deadline(deadline, "decode");
    fail(ErrorCode::kUnprocessable,
         fmt::format("the decoder did not finish this file within {} ms", config_.timeout.count()));
  }
  const std::string reason = kind == Outcome::Kind::kGarbage ? "an answer that makes no sense" : ending;
  tell("decoder.crashed", reason);
  fail(ErrorCode::kUnprocessable, "the decoder failed on this file", {}, reason);
}

void ProcessPool::run(const Task& task, const Deadline& deadline) {
  // An idle child may have been ended from outside; several in a row are ours to explain.
  constexpr int kTries = 3;
  for (int attempt = 1;; ++attempt) {
    check_deadline(deadline, "decode");
    WorkerPointer worker = lease(deadline);
    Outcome outcome;
    try {
      outcome = worker->exchange(task, std::min(deadline.end(), Clock::now() + config_.timeout),
                                 deadline.cancel_token());
    } catch (...) {
      retire(std::move(worker));
      throw;
    }
    if (outcome.kind == Outcome::Kind::kUnsent && attempt < kTries) {
      const pid_t pid = worker->pid();
      log::warning("decoder.gone", {{"pid", pid}, {"reason", bury(std::move(worker))}});
      continue;
    }
    {
      const std::lock_guard lock(mutex_);
      ++stats_.jobs;
    }
    const bool usable = outcome.kind == Outcome::Kind::kTaken || outcome.kind == Outcome::Kind::kRefused;
    if (!usable) fail_over(task, outcome.kind, std::move(worker), deadline);
    give_back(std::move(worker));
    if (outcome.kind == Outcome::Kind::kRefused) throw std::move(outcome.error);
    return;
  }
}

PoolStats ProcessPool::stats() const {
  const std::lock_guard lock(mutex_);
  PoolStats stats = stats_;
  stats.processes = alive_;
  return stats;
}

}  // namespace furnace::decode
