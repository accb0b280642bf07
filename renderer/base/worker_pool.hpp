// The CPU threads of the process, with two lanes: encodes go before decodes, so finished work leaves first.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace furnace {

enum class Lane { kEncode, kDecode };

// Threads: any may call. Owns: its threads; the destructor finishes what is queued and lets all callers leave.
class WorkerPool {
 public:
  explicit WorkerPool(int threads);  // >= 1
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const;
  std::size_t queued() const;  // pieces of work that wait for a thread

  // Runs `body` on a pool thread and waits; an exception comes back to the caller.
  // Called from a pool thread it runs in place, so nesting cannot deadlock.
  void run(Lane lane, const std::function<void()>& body);

  // Runs body(i) for i in [0, count), the caller taking part; the first exception is rethrown after all have
  // ended. Small totals (count * cost_us below about 200) run in place. Nested calls are allowed.
  void parallel_for(std::size_t count, double cost_us, const std::function<void(std::size_t)>& body);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furnace
