#include "server/admission.hpp"

#include <atomic>
#include <chrono>
#include <memory>
#include <stop_token>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

ErrorCode code_of_entering(Admission& admission, const Deadline& deadline) {
  try {
    admission.enter(deadline);
  } catch (const Error& error) {
    return error.code;
  }
  ADD_FAILURE() << "entered";
  return ErrorCode::kInternal;
}

void wait_until_waiting(const Admission& admission, int count) {
  while (admission.waiting() != count) std::this_thread::yield();
}

TEST(Admission, SeatsAreGivenBack) {
  Admission admission(2, 0);
  {
    const auto a = admission.enter({});
    const auto b = admission.enter({});
    EXPECT_EQ(admission.seats_in_use(), 2);
  }
  EXPECT_EQ(admission.seats_in_use(), 0);
}

TEST(Admission, AMovedSeatIsGivenBackOnce) {
  Admission admission(1, 0);
  {
    auto a = admission.enter({});
    const auto b = std::move(a);
  }
  EXPECT_EQ(admission.seats_in_use(), 0);
}

TEST(Admission, FullQueueRefusesAtOnce) {
  Admission admission(1, 0);
  const auto seat = admission.enter({});
  EXPECT_EQ(code_of_entering(admission, {}), ErrorCode::kOverloaded);
}

TEST(Admission, AWaiterPastItsDeadlineLeavesTheQueue) {
  Admission admission(1, 1);
  const auto seat = admission.enter({});
  EXPECT_EQ(code_of_entering(admission, Deadline(milliseconds(5))), ErrorCode::kDeadlineExceeded);
  EXPECT_EQ(admission.waiting(), 0);
}

TEST(Admission, APassedDeadlineTakesNoSeat) {
  Admission admission(1, 1);
  EXPECT_EQ(code_of_entering(admission, Deadline(milliseconds(-1))), ErrorCode::kDeadlineExceeded);
  EXPECT_EQ(admission.seats_in_use(), 0);
}

TEST(Admission, CancellingWakesAWaiter) {
  Admission admission(1, 1);
  const auto seat = admission.enter({});
  std::stop_source stop;
  std::jthread waiter([&] {
    EXPECT_EQ(code_of_entering(admission, Deadline(hours(1), stop.get_token())),
              ErrorCode::kDeadlineExceeded);
  });
  wait_until_waiting(admission, 1);
  stop.request_stop();
}

TEST(Admission, FirstComeFirstServed) {
  Admission admission(1, 3);
  auto seat = std::make_unique<Admission::Seat>(admission.enter({}));
  std::vector<int> order;  // written only by who holds the one seat
  std::vector<std::jthread> waiters;
  for (int i = 0; i < 3; ++i) {
    waiters.emplace_back([&, i] {
      const auto mine = admission.enter({});
      order.push_back(i);
    });
    wait_until_waiting(admission, i + 1);
  }
  seat.reset();
  waiters.clear();
  EXPECT_EQ(order, (std::vector{0, 1, 2}));
}

TEST(Admission, NeverMoreThanItsSeats) {
  constexpr int kSeats = 3;
  Admission admission(kSeats, 100);
  std::atomic<int> inside = 0, most = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 200; ++i) {
          const auto seat = admission.enter({});
          const int now = ++inside;
          int seen = most;
          while (now > seen && !most.compare_exchange_weak(seen, now)) {
          }
          --inside;
        }
      });
    }
  }
  EXPECT_LE(most, kSeats);
  EXPECT_EQ(admission.seats_in_use(), 0);
  EXPECT_EQ(admission.waiting(), 0);
}

}  // namespace
}  // namespace furnace
