#include "server/admission.hpp"

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

#include <condition_variable>

namespace furnace {

struct Admission::Waiter {
  std::condition_variable_any called;
  bool seated = false;
};

Admission::Admission(int seats, int queue_length) : seats_(seats), queue_length_(queue_length) {
  FURNACE_CHECK(seats >= 1 && queue_length >= 0, "{} seats, queue of {}", seats, queue_length);
}

Admission::Seat Admission::enter(const Deadline& deadline) {
  check_deadline(deadline, "queue");
  std::unique_lock lock(mutex_);
  if (in_use_ < seats_) {
    ++in_use_;
    return Seat(*this);
  }
  if (static_cast<int>(queue_.size()) >= queue_length_) {
    fail(ErrorCode::kOverloaded, "The server is busy and its queue is full; try again in a moment.");
  }
  Waiter self;
  queue_.push_back(&self);
  self.called.wait_until(lock, deadline.cancel_token(), deadline.end(), [&self] { return self.seated; });
  if (self.seated) return Seat(*this);
  std::erase(queue_, &self);
  fail_deadline(deadline, "queue");
}

void Admission::leave() {
  std::lock_guard lock(mutex_);
  if (queue_.empty()) {
    --in_use_;
    return;
  }
  // The seat goes straight to the one who has waited longest: nobody can slip in between.
  Waiter* next = queue_.front();
  queue_.pop_front();
  next->seated = true;
  next->called.notify_one();
}

int Admission::seats_in_use() const {
  std::lock_guard lock(mutex_);
  return in_use_;
}

int Admission::waiting() const {
  std::lock_guard lock(mutex_);
  return static_cast<int>(queue_.size());
}

}  // namespace furnace
