// Working memory that the tasks of one parallel loop hand on to each other.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace furnace {

// As many T as tasks run at once, each in the state in which the last task left it.
// Threads: any. Owns: its T.
template <class T>
class ScratchPool {
 public:
  class Lease {
   public:
    explicit Lease(ScratchPool& pool) : pool_(pool), value_(pool.take()) {}
    ~Lease() { pool_.put(std::move(value_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;

    T& operator*() { return *value_; }
    T* operator->() { return value_.get(); }

   private:
    ScratchPool& pool_;
    std::unique_ptr<T> value_;
  };

 private:
  std::unique_ptr<T> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<T>();
    std::unique_ptr<T> value = std::move(free_.back());
    free_.pop_back();
    return value;
  }
  void put(std::unique_ptr<T> value) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(value));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

}  // namespace furnace
