// A thread that owns a World (for instance a GL context and all its objects). The only way to the World is
// call().
#pragma once

#include "renderer/base/check.hpp"
#include "renderer/base/deadline.hpp"
#include "renderer/base/log.hpp"

#include <pthread.h>

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>

namespace furnace {

// Threads: any may call, but not the confined one itself. Owns: the thread and, on it, the World.
// Closure, result and signal live on the caller's stack and the queue holds pointers: safe because a call
// either ends or is withdrawn while still queued; a running call is never abandoned.
template <class World>
class ConfinedThread {
 public:
  using Factory = std::function<std::unique_ptr<World>()>;

  // Runs `make_world` on the new thread and waits for it; its exception comes out here. `name` is shown by
  // debuggers (15 characters).
  ConfinedThread(const std::string& name, Factory make_world);
  // Ends what is queued, lets all callers leave, destroys the World on its thread. No call may begin any more.
  ~ConfinedThread();
  ConfinedThread(const ConfinedThread&) = delete;
  ConfinedThread& operator=(const ConfinedThread&) = delete;

  // Runs fn(World&) there, in order of arrival, and returns its result or rethrows its exception. When the
  // deadline passes before it has begun, it is withdrawn: kDeadlineExceeded. Once begun it has to look at the
  // deadline itself.
  template <class Fn>
  std::invoke_result_t<Fn&, World&> call(const Deadline& deadline, Fn&& fn);

  // Destroys the World and makes another (a lost GL context). When the factory fails its exception comes out
  // here, and the next call tries again.
  void rebuild(const Deadline& deadline);

  std::size_t load() const;  // calls queued and running
  // For how long the call that runs now has outlived its deadline, for a watchdog; 0 when it has not, or none runs.
  Clock::duration overdue() const;

 private:
  enum class Progress { kQueued, kRunning, kEnded };

  struct Call {
    void (*run)(void* closure);
    void* closure;
    Clock::time_point end;
    log::Origin origin = log::origin();
    Progress progress = Progress::kQueued;  // belongs to mutex_, like the signal
    std::condition_variable_any progressed{};
    std::exception_ptr failure{};
  };

  template <class Body>
  void submit_and_wait(const Deadline& deadline, Body& body);
  void work();
  World& world();  // makes it when there is none
  void stop();

  const Factory make_world_;
  std::unique_ptr<World> world_;  // touched on thread_ alone
  mutable std::mutex mutex_;
  std::condition_variable work_arrived_;
  std::deque<Call*> queue_;
  const Call* running_ = nullptr;
  int callers_ = 0;  // inside of a call, and therefore users of this object
  std::condition_variable callers_left_;
  bool stopping_ = false;
  std::thread thread_;
};

template <class World>
ConfinedThread<World>::ConfinedThread(const std::string& name, Factory make_world)
    : make_world_(std::move(make_world)), thread_([this] { work(); }) {
  pthread_setname_np(thread_.native_handle(), name.substr(0, 15).c_str());
  try {
    call(Deadline{}, [](World&) {});
  } catch (...) {
    stop();
    throw;
  }
}

template <class World>
ConfinedThread<World>::~ConfinedThread() {
  stop();
}

template <class World>
void ConfinedThread<World>::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_arrived_.notify_one();
  thread_.join();
  std::unique_lock lock(mutex_);
  callers_left_.wait(lock, [&] { return callers_ == 0; });
}

template <class World>
World& ConfinedThread<World>::world() {
  if (!world_) world_ = make_world_();
  FURNACE_CHECK(world_, "the factory made no world");
  return *world_;
}

template <class World>
template <class Fn>
std::invoke_result_t<Fn&, World&> ConfinedThread<World>::call(const Deadline& deadline, Fn&& fn) {
  using Result = std::invoke_result_t<Fn&, World&>;
  static_assert(!std::is_reference_v<Result>, "nothing of the World may be referred to from another thread");
  if constexpr (std::is_void_v<Result>) {
    auto body = [&] { fn(world()); };
    submit_and_wait(deadline, body);
  } else {
    std::optional<Result> result;
    auto body = [&] { result.emplace(fn(world())); };
    submit_and_wait(deadline, body);
    return std::move(*result);
  }
}

template <class World>
void ConfinedThread<World>::rebuild(const Deadline& deadline) {
  auto body = [&] {
    world_.reset();
    world();
  };
  submit_and_wait(deadline, body);
}

template <class World>
template <class Body>
void ConfinedThread<World>::submit_and_wait(const Deadline& deadline, Body& body) {
  FURNACE_CHECK(std::this_thread::get_id() != thread_.get_id(), "a confined thread would wait for itself");
  Call call{[](void* closure) { (*static_cast<Body*>(closure))(); }, &body, deadline.end()};

  std::unique_lock lock(mutex_);
  FURNACE_CHECK(!stopping_, "a call to a thread that is being stopped, {} before it", queue_.size());
  ++callers_;
  queue_.push_back(&call);
  work_arrived_.notify_one();
  const bool begun = call.progressed.wait_until(lock, deadline.cancel_token(), deadline.end(),
                                                [&] { return call.progress != Progress::kQueued; });
  if (begun) {
    call.progressed.wait(lock, [&] { return call.progress == Progress::kEnded; });
  } else {
    std::erase(queue_, &call);
  }
  if (--callers_ == 0) callers_left_.notify_all();
  lock.unlock();
  if (!begun) fail_deadline(deadline, "waiting for a confined thread");
  if (call.failure) std::rethrow_exception(std::move(call.failure));
}

template <class World>
void ConfinedThread<World>::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    work_arrived_.wait(lock, [&] { return stopping_ || !queue_.empty(); });
    if (queue_.empty()) break;
    Call& call = *queue_.front();
    queue_.pop_front();
    call.progress = Progress::kRunning;
    call.progressed.notify_one();  // the deadline binds the call no longer
    running_ = &call;
    lock.unlock();
    {
      const log::RequestScope scope(call.origin);
      try {
        call.run(call.closure);
      } catch (...) {
        call.failure = std::current_exception();
      }
    }
    lock.lock();
    running_ = nullptr;
    call.progress = Progress::kEnded;
    call.progressed.notify_one();  // under the lock: its owner destroys the call as soon as it has the lock
  }
  lock.unlock();
  world_.reset();
}

template <class World>
std::size_t ConfinedThread<World>::load() const {
  const std::lock_guard lock(mutex_);
  return queue_.size() + (running_ ? 1 : 0);
}

template <class World>
Clock::duration ConfinedThread<World>::overdue() const {
  const std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  return running_ && running_->end < now ? now - running_->end : Clock::duration::zero();
}

}  // namespace furnace
