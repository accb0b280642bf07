// How many renders work at once, and how many may wait. Everyone else is told so at once.
#pragma once

#include <deque>
#include <mutex>
#include <utility>

#include "renderer/base/deadline.hpp"

namespace furnace {

// Threads: any. Owns: the count of seats; first come, first served.
class Admission {
 public:
  // seats >= 1 working, queue_length >= 0 waiting.
  Admission(int seats, int queue_length);
  Admission(const Admission&) = delete;
  Admission& operator=(const Admission&) = delete;

  // A place at work, given back by the destructor. Must not outlive its Admission.
  class Seat {
   public:
    Seat(Seat&& other) noexcept : owner_(std::exchange(other.owner_, nullptr)) {}
    Seat& operator=(Seat&&) = delete;
    ~Seat() {
      if (owner_) owner_->leave();
    }

   private:
    friend class Admission;
    explicit Seat(Admission& owner) : owner_(&owner) {}
    Admission* owner_;
  };

  // Errors: kOverloaded at once when the queue is full; kDeadlineExceeded when the time ends, or the client
  // goes, while waiting.
  Seat enter(const Deadline& deadline);

  int seats() const { return seats_; }
  int seats_in_use() const;
  int waiting() const;

 private:
  struct Waiter;
  void leave();

  const int seats_;
  const int queue_length_;
  mutable std::mutex mutex_;
  int in_use_ = 0;
  std::deque<Waiter*> queue_;
};

}  // namespace furnace
