#include "renderer/base/worker_pool.hpp"

#include "renderer/base/check.hpp"
#include "renderer/base/log.hpp"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace furnace {

namespace {

constexpr double kWorthSharing_us = 200;  // below, waking a thread costs more than it saves
constexpr double kChunk_us = 50;          // work taken at once, so that the shared counter stays cheap

// Lives on the stack of the thread that waits for it; all members but `body` and `origin` belong to the
// pool's lock.
struct Job {
  const std::function<void()>& body;
  log::Origin origin = log::origin();
  int unfinished = 0;  // tickets queued or running
  std::condition_variable all_finished{};
};

}  // namespace

struct WorkerPool::State {
  std::mutex mutex;
  std::condition_variable work_arrived;
  std::deque<Job*> lanes[2];  // tickets, by Lane
  int callers = 0;            // inside of run or parallel_for, and therefore users of this state
  std::condition_variable callers_left;
  bool stopping = false;
  std::vector<std::thread> threads;

  // The pool and lane of the calling thread, when it is a pool thread.
  static thread_local State* own_pool;
  static thread_local Lane own_lane;

  void work();
  void submit(Lane lane, Job& job, std::size_t tickets);
  void withdraw(Lane lane, Job& job);
  void wait(Job& job);
};

thread_local WorkerPool::State* WorkerPool::State::own_pool = nullptr;
thread_local Lane WorkerPool::State::own_lane = Lane::kDecode;

void WorkerPool::State::work() {
  own_pool = this;
  std::unique_lock lock(mutex);
  for (;;) {
    work_arrived.wait(lock, [&] { return stopping || !lanes[0].empty() || !lanes[1].empty(); });
    const Lane lane = lanes[0].empty() ? Lane::kDecode : Lane::kEncode;
    std::deque<Job*>& queue = lanes[static_cast<int>(lane)];
    if (queue.empty()) return;  // stopping, and nothing is left
    Job& job = *queue.front();
    queue.pop_front();
    lock.unlock();
    own_lane = lane;
    {
      const log::RequestScope scope(job.origin);
      job.body();
    }
    lock.lock();
    // Under the lock: the job's owner may destroy it as soon as it can take the lock.
    if (--job.unfinished == 0) job.all_finished.notify_one();
  }
}

void WorkerPool::State::submit(Lane lane, Job& job, std::size_t tickets) {
  {
    const std::lock_guard lock(mutex);
    ++callers;
    job.unfinished = static_cast<int>(tickets);
    for (std::size_t i = 0; i < tickets; ++i) lanes[static_cast<int>(lane)].push_back(&job);
  }
  for (std::size_t i = 0; i < tickets; ++i) work_arrived.notify_one();
}

void WorkerPool::State::withdraw(Lane lane, Job& job) {
  const std::lock_guard lock(mutex);
  job.unfinished -= static_cast<int>(std::erase(lanes[static_cast<int>(lane)], &job));
}

void WorkerPool::State::wait(Job& job) {
  std::unique_lock lock(mutex);
  job.all_finished.wait(lock, [&] { return job.unfinished == 0; });
  if (--callers == 0) callers_left.notify_all();
}

WorkerPool::WorkerPool(int threads) : state_(std::make_unique<State>()) {
  FURNACE_CHECK(threads >= 1, "a pool of {} threads", threads);
  for (int i = 0; i < threads; ++i) {
    state_->threads.emplace_back([state = state_.get()] { state->work(); });
    pthread_setname_np(state_->threads.back().native_handle(), ("cpu-" + std::to_string(i)).c_str());
  }
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->work_arrived.notify_all();
  for (std::thread& thread : state_->threads) thread.join();
  std::unique_lock lock(state_->mutex);
  state_->callers_left.wait(lock, [&] { return state_->callers == 0; });
}

int WorkerPool::threads() const {
  return static_cast<int>(state_->threads.size());
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard lock(state_->mutex);
  return state_->lanes[0].size() + state_->lanes[1].size();
}

void WorkerPool::run(Lane lane, const std::function<void()>& body) {
  if (State::own_pool == state_.get()) return body();
  std::exception_ptr failure;
  const std::function<void()> guarded = [&] {
    try {
      body();
    } catch (...) {
      failure = std::current_exception();
    }
  };
  Job job{guarded};
  state_->submit(lane, job, 1);
  state_->wait(job);
  if (failure) std::rethrow_exception(std::move(failure));
}

void WorkerPool::parallel_for(std::size_t count, double cost_us,
                              const std::function<void(std::size_t)>& body) {
  const std::size_t helpers = std::min<std::size_t>(threads() - 1, count == 0 ? 0 : count - 1);
  if (helpers == 0 || static_cast<double>(count) * cost_us < kWorthSharing_us) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  const double worthwhile = kChunk_us / std::max(cost_us, 1e-3);
  const std::size_t fair = std::max<std::size_t>(1, count / (4 * (helpers + 1)));
  const std::size_t chunk = std::max<std::size_t>(1, std::min(fair, static_cast<std::size_t>(worthwhile)));

  std::atomic<std::size_t> next{0};
  std::mutex failure_mutex;
  std::exception_ptr failure;
  std::size_t failed_index = std::numeric_limits<std::size_t>::max();
  // Chunks are handed out in order and a chunk once begun is worked until its own first failure, so the
  // failure of the lowest index is always found: the same one in every run.
  const std::function<void()> take_chunks = [&] {
    for (;;) {
      const std::size_t begin = next.fetch_add(chunk);
      if (begin >= count) return;
      std::size_t i = begin;
      std::exception_ptr caught;
      try {
        for (; i < std::min(count, begin + chunk); ++i) body(i);
      } catch (...) {
        caught = std::current_exception();
      }
      if (!caught) continue;
      next = count;
      const std::lock_guard lock(failure_mutex);
      if (i < failed_index) {
        failed_index = i;
        failure.swap(caught);
      }
    }
  };

  const Lane lane = State::own_pool == state_.get() ? State::own_lane : Lane::kDecode;
  Job job{take_chunks};
  state_->submit(lane, job, helpers);
  take_chunks();
  state_->withdraw(lane, job);
  state_->wait(job);
  if (failure) std::rethrow_exception(std::move(failure));
}

}  // namespace furnace
