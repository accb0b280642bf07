#include "renderer/base/confined_thread.hpp"

#include "renderer/base/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <latch>
#include <stdexcept>
#include <vector>

namespace furnace {
namespace {

using std::chrono::milliseconds;

// Remembers its thread; what happens to it is told to the outside.
struct World {
  std::thread::id home = std::this_thread::get_id();
  int value = 1;
  std::thread::id* died_on = nullptr;

  ~World() {
    if (died_on) *died_on = std::this_thread::get_id();
  }
};

ConfinedThread<World> make_thread() {
  return ConfinedThread<World>("world", [] { return std::make_unique<World>(); });
}

const Deadline kNever;

ErrorCode code_of(auto&& body) {
  try {
    body();
  } catch (const Error& error) {
    return error.code;
  }
  return ErrorCode::kInternal;
}

TEST(ConfinedThread, CallsWhereTheWorldWasMade) {
  auto thread = make_thread();
  const auto [here, home] =
      thread.call(kNever, [](World& world) { return std::pair(std::this_thread::get_id(), world.home); });
  EXPECT_EQ(here, home);
  EXPECT_NE(here, std::this_thread::get_id());
}

TEST(ConfinedThread, ReturnsResultsOfAnyKind) {
  auto thread = make_thread();
  thread.call(kNever, [](World& world) { world.value = 42; });
  EXPECT_EQ(thread.call(kNever, [](World& world) { return world.value; }), 42);
  EXPECT_EQ(*thread.call(kNever, [](World&) { return std::make_unique<int>(7); }), 7);  // movable only
  int outside = 0;
  thread.call(kNever, [&, only_movable = std::make_unique<int>(3)](World&) { outside = *only_movable; });
  EXPECT_EQ(outside, 3);
}

TEST(ConfinedThread, BringsExceptionsBack) {
  auto thread = make_thread();
  EXPECT_THROW(thread.call(kNever, [](World&) { throw std::out_of_range("x"); }), std::out_of_range);
  EXPECT_EQ(code_of([&] { thread.call(kNever, [](World&) -> int { fail(ErrorCode::kTooLarge, "x"); }); }),
            ErrorCode::kTooLarge);
  EXPECT_EQ(thread.call(kNever, [](World& world) { return world.value; }), 1) << "the world did not survive";
}

TEST(ConfinedThread, KeepsTheOrderOfArrival) {
  auto thread = make_thread();
  std::vector<int> order;  // touched on the confined thread alone
  std::latch begun(1), go(1);
  std::vector<std::jthread> callers;
  callers.emplace_back([&] {
    thread.call(kNever, [&](World&) {
      begun.count_down();
      go.wait();
    });
  });
  begun.wait();
  for (int i = 0; i < 5; ++i) {
    callers.emplace_back([&, i] { thread.call(kNever, [&, i](World&) { order.push_back(i); }); });
    while (thread.load() < static_cast<std::size_t>(i) + 2) std::this_thread::yield();
  }
  go.count_down();
  callers.clear();
  EXPECT_THAT(order, testing::ElementsAre(0, 1, 2, 3, 4));
}

// Holds a confined thread up for as long as it lives.
struct Blocker {
  std::latch begun{1}, go{1};
  std::jthread caller;

  explicit Blocker(ConfinedThread<World>& thread)
      : caller([&] {
          thread.call(kNever, [&](World&) {
            begun.count_down();
            go.wait();
          });
        }) {
    begun.wait();
  }
  ~Blocker() { go.count_down(); }
};

TEST(ConfinedThread, WithdrawsAQueuedCallWhenItsDeadlinePasses) {
  auto thread = make_thread();
  std::atomic<bool> ran{false};
  {
    Blocker blocker(thread);
    EXPECT_EQ(code_of([&] { thread.call(Deadline(milliseconds(20)), [&](World&) { ran = true; }); }),
              ErrorCode::kDeadlineExceeded);
    EXPECT_EQ(thread.load(), 1u);
  }
  thread.call(kNever, [](World&) {});
  EXPECT_FALSE(ran);
}

TEST(ConfinedThread, WithdrawsAQueuedCallWhenItIsCancelled) {
  auto thread = make_thread();
  std::atomic<bool> ran{false};
  std::stop_source client;
  Blocker blocker(thread);
  std::jthread caller([&] {
    const Deadline deadline(milliseconds(3'600'000), client.get_token());
    EXPECT_EQ(code_of([&] { thread.call(deadline, [&](World&) { ran = true; }); }),
              ErrorCode::kDeadlineExceeded);
  });
  while (thread.load() < 2) std::this_thread::yield();
  client.request_stop();
  caller.join();
  EXPECT_FALSE(ran);
}

TEST(ConfinedThread, NeverAbandonsARunningCall) {
  auto thread = make_thread();
  bool ended = false;  // not atomic: were the call abandoned, this would be a race
  EXPECT_EQ(thread.call(Deadline(milliseconds(2'000)),
                        [&, began = Clock::now()](World&) {
                          const Deadline own(milliseconds(30));
                          while (!own.passed()) std::this_thread::yield();
                          ended = true;
                          return 5;
                        }),
            5);
  EXPECT_TRUE(ended);

  std::latch running(1);
  std::stop_source client;
  std::jthread canceller([&] {
    running.wait();
    client.request_stop();
  });
  bool saw_cancel = false;
  thread.call(Deadline(milliseconds(3'600'000), client.get_token()), [&](World&) {
    running.count_down();
    while (!client.stop_requested()) std::this_thread::yield();
    saw_cancel = true;
  });
  EXPECT_TRUE(saw_cancel);
}

TEST(ConfinedThread, RethrowsWhatItsFactoryThrows) {
  int made = 0;
  EXPECT_THROW(ConfinedThread<World>("world",
                                     [&]() -> std::unique_ptr<World> {
                                       ++made;
                                       throw std::runtime_error("no device");
                                     }),
               std::runtime_error);
  EXPECT_EQ(made, 1);
}

TEST(ConfinedThread, DestroysTheWorldOnItsThread) {
  std::thread::id home, died_on;
  {
    auto thread = make_thread();
    home = thread.call(kNever, [&](World& world) {
      world.died_on = &died_on;
      return world.home;
    });
  }
  EXPECT_EQ(died_on, home);
}

TEST(ConfinedThread, EndsWhatIsQueuedBeforeItStops) {
  std::atomic<int> ended{0};
  std::vector<std::jthread> callers;
  {
    auto thread = make_thread();
    {
      Blocker blocker(thread);
      for (int i = 0; i < 3; ++i)
        callers.emplace_back([&] { thread.call(kNever, [&](World&) { ++ended; }); });
      while (thread.load() < 4) std::this_thread::yield();
    }
  }
  EXPECT_EQ(ended, 3);
}

TEST(ConfinedThread, RebuildsItsWorld) {
  std::atomic<int> made{0};
  std::atomic<bool> is_broken{false};
  ConfinedThread<World> thread("world", [&] {
    if (is_broken) fail(ErrorCode::kGpuUnavailable, "no context");
    auto world = std::make_unique<World>();
    world->value = ++made;
    return world;
  });
  const auto value = [&] { return thread.call(kNever, [](World& world) { return world.value; }); };
  EXPECT_EQ(value(), 1);

  std::thread::id home, died_on;
  home = thread.call(kNever, [&](World& world) {
    world.died_on = &died_on;
    return world.home;
  });
  thread.rebuild(kNever);
  EXPECT_EQ(died_on, home);
  EXPECT_EQ(value(), 2);

  is_broken = true;
  EXPECT_EQ(code_of([&] { thread.rebuild(kNever); }), ErrorCode::kGpuUnavailable);
  EXPECT_EQ(code_of([&] { value(); }), ErrorCode::kGpuUnavailable);
  is_broken = false;
  EXPECT_EQ(value(), 3) << "a call makes the missing world";
}

TEST(ConfinedThread, TellsWhatItIsDoing) {
  auto thread = make_thread();
  {
    Blocker blocker(thread);
    EXPECT_EQ(thread.load(), 1u);
    EXPECT_EQ(thread.overdue(), Clock::duration::zero()) << "it has all the time";
  }
  thread.call(kNever, [](World&) {});
  EXPECT_EQ(thread.load(), 0u);
}

TEST(ConfinedThread, TellsForHowLongACallHasOutlivedItsDeadline) {
  auto thread = make_thread();
  using std::chrono::milliseconds;
  Clock::duration before{}, after{};
  thread.call(Deadline(milliseconds(30)), [&](World&) {
    before = thread.overdue();
    std::this_thread::sleep_for(milliseconds(80));
    after = thread.overdue();
  });
  EXPECT_EQ(before, Clock::duration::zero());
  EXPECT_GE(after, milliseconds(50));
  EXPECT_EQ(thread.overdue(), Clock::duration::zero());
}

// Many callers, deadlines that pass at all moments of a call: every call either ran or was withdrawn, never
// both.
TEST(ConfinedThread, StandsCrowdsInAHurry) {
  auto thread = make_thread();
  std::atomic<int> ended{0}, withdrawn{0};
  int ran = 0;  // touched on the confined thread alone
  {
    std::vector<std::jthread> callers;
    for (int c = 0; c < 8; ++c) {
      callers.emplace_back([&, c] {
        for (int i = 0; i < 100; ++i) {
          try {
            thread.call(Deadline(milliseconds((c + i) % 3)), [&](World&) {
              ++ran;
              if (i % 7 == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
            });
            ++ended;
          } catch (const Error& error) {
            ASSERT_EQ(error.code, ErrorCode::kDeadlineExceeded);
            ++withdrawn;
          }
        }
      });
    }
  }
  EXPECT_EQ(thread.call(kNever, [&](World&) { return ran; }), ended);
  EXPECT_EQ(ended + withdrawn, 800);
}

TEST(ConfinedThread, CarriesTheRequestAlong) {
  auto thread = make_thread();
  const log::RequestScope scope({"r-9", {}, {}});
  EXPECT_EQ(thread.call(kNever, [](World&) { return std::string(log::origin().request); }), "r-9");
}

TEST(ConfinedThreadDeathTest, RefusesToWaitForItself) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        auto thread = make_thread();
        thread.call(kNever, [&](World&) { thread.call(kNever, [](World&) {}); });
      },
      "wait for itself");
}

}  // namespace
}  // namespace furnace
