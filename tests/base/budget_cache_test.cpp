#include "renderer/base/budget_cache.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace furnace {
namespace {

using std::chrono::milliseconds;
using Cache = BudgetCache<std::string, int>;

const Deadline kNever;

Cache make_cache(std::int64_t budget) {
  return Cache(budget, [](const std::string& text) { return static_cast<std::int64_t>(text.size()); });
}

// A loader that must not run.
std::string unwanted() {
  ADD_FAILURE() << "loaded again";
  return {};
}

TEST(BudgetCache, LoadsOnceAndReportsHow) {
  auto cache = make_cache(100);
  CacheOutcome outcome;
  const auto first = cache.get_or_load(
      1, kNever, [] { return std::string("one"); }, &outcome);
  EXPECT_EQ(*first, "one");
  EXPECT_EQ(outcome, CacheOutcome::kLoaded);
  EXPECT_EQ(cache.get_or_load(1, kNever, unwanted, &outcome), first);
  EXPECT_EQ(outcome, CacheOutcome::kHit);
  EXPECT_EQ(cache.find(1), first);
  EXPECT_EQ(cache.find(2), nullptr);
  const CacheStats stats = cache.stats();
  EXPECT_EQ(stats.loads, 1);
  EXPECT_EQ(stats.hits, 2);
  EXPECT_EQ(stats.entries, 1);
  EXPECT_EQ(stats.bytes, 3);
}

TEST(BudgetCache, TakesPointersFromLoaders) {
  auto cache = make_cache(100);
  const auto made = std::make_shared<const std::string>("x");
  EXPECT_EQ(cache.get_or_load(1, kNever, [&] { return made; }), made);
  EXPECT_EQ(*cache.get_or_load(2, kNever, [] { return std::make_unique<std::string>("y"); }), "y");
}

TEST(BudgetCache, EvictsTheLeastRecentlyUsed) {
  auto cache = make_cache(10);
  const auto load = [&](int key, std::size_t size) {
    return cache.get_or_load(key, kNever, [&] { return std::string(size, 'x'); });
  };
  const auto held = load(1, 4);
  load(2, 4);
  load(1, 4);  // a hit: 2 is the oldest now
  load(3, 4);
  EXPECT_EQ(cache.find(2), nullptr);
  EXPECT_NE(cache.find(1), nullptr);
  EXPECT_NE(cache.find(3), nullptr);
  EXPECT_EQ(cache.stats().bytes, 8);
  load(4, 10);  // takes the room of both
  EXPECT_EQ(cache.stats().entries, 1);
  EXPECT_EQ(cache.stats().evictions, 3);
  EXPECT_EQ(*held, "xxxx") << "a value in use outlives its eviction";
}

TEST(BudgetCache, HandsOutWhatItCannotKeep) {
  auto cache = make_cache(10);
  cache.get_or_load(1, kNever, [] { return std::string("kept"); });
  EXPECT_EQ(cache.get_or_load(2, kNever, [] { return std::string(11, 'x'); })->size(), 11u);
  EXPECT_EQ(cache.find(2), nullptr);
  EXPECT_NE(cache.find(1), nullptr) << "evicted for nothing";
}

TEST(BudgetCache, ClearForgetsEverything) {
  auto cache = make_cache(10);
  cache.get_or_load(1, kNever, [] { return std::string("x"); });
  cache.clear();
  EXPECT_EQ(cache.find(1), nullptr);
  EXPECT_EQ(cache.stats().bytes, 0);
}

TEST(BudgetCache, DoesNotRememberFailures) {
  auto cache = make_cache(100);
  EXPECT_THROW(cache.get_or_load(1, kNever, []() -> std::string { fail(ErrorCode::kNotFound, "x"); }), Error);
  EXPECT_THROW(cache.get_or_load(1, kNever, []() -> std::string { throw std::runtime_error("x"); }),
               std::runtime_error);
  EXPECT_EQ(*cache.get_or_load(1, kNever, [] { return std::string("now"); }), "now");
}

TEST(BudgetCache, LoadsOutsideOfTheLock) {
  auto cache = make_cache(100);
  const auto outer = cache.get_or_load(1, kNever, [&] {
    return "outer " + *cache.get_or_load(2, kNever, [] { return std::string("inner"); });
  });
  EXPECT_EQ(*outer, "outer inner");
}

// One leader inside its loader and some who wait for it.
class Flight {
 public:
  explicit Flight(Cache& cache) : cache_(cache) {}
  ~Flight() {
    if (!go_.try_wait()) go_.count_down();
  }

  // `finish` runs in the leader's loader once it is let go.
  void lead(std::function<std::string()> finish) {
    threads_.emplace_back([this, finish] {
      record([&] {
        return cache_.get_or_load(1, kNever, [&] {
          begun_.count_down();
          go_.wait();
          return finish();
        });
      });
    });
    begun_.wait();
  }

  void join(const Deadline& deadline, std::function<std::string()> load) {
    ++joined_;
    threads_.emplace_back(
        [this, deadline, load] { record([&] { return cache_.get_or_load(1, deadline, load); }); });
  }

  // Lets the leader go when all who join wait for it.
  void finish() {
    while (cache_.stats().waiting < joined_) std::this_thread::yield();
    go_.count_down();
    threads_.clear();
  }

  std::vector<std::string> results;  // values, or "code: message"

 private:
  void record(const std::function<Cache::Pointer()>& get) {
    std::string result;
    try {
      result = *get();
    } catch (Error& error) {
      error.context.emplace_back("mine");  // each has a copy of its own, or this is a race
      result = std::string(error_code_name(error.code)) + ": " + error.message;
    } catch (const std::exception& error) {
      result = std::string("foreign: ") + error.what();
    }
    const std::lock_guard lock(mutex_);
    results.push_back(result);
  }

  Cache& cache_;
  std::latch begun_{1}, go_{1};
  int joined_ = 0;
  std::mutex mutex_;
  std::vector<std::jthread> threads_;
};

TEST(BudgetCache, JoinsLoadsThatOverlap) {
  auto cache = make_cache(100);
  Flight flight(cache);
  flight.lead([] { return std::string("once"); });
  for (int i = 0; i < 4; ++i) flight.join(kNever, unwanted);
  flight.finish();
  EXPECT_THAT(flight.results, testing::ElementsAre("once", "once", "once", "once", "once"));
  EXPECT_EQ(cache.stats().loads, 1);
}

TEST(BudgetCache, JoinsLoadsEvenWithoutABudget) {
  auto cache = make_cache(0);
  Flight flight(cache);
  flight.lead([] { return std::string("once"); });
  flight.join(kNever, unwanted);
  flight.finish();
  EXPECT_THAT(flight.results, testing::ElementsAre("once", "once"));
  EXPECT_EQ(cache.stats().entries, 0);
}

TEST(BudgetCache, SharesFailuresWithThoseWhoWait) {
  auto cache = make_cache(100);
  Flight flight(cache);
  flight.lead([]() -> std::string { fail(ErrorCode::kUnprocessable, "broken"); });
  for (int i = 0; i < 3; ++i) flight.join(kNever, unwanted);
  flight.finish();
  EXPECT_THAT(flight.results, testing::Each("unprocessable: broken"));
  EXPECT_EQ(flight.results.size(), 4u);
  EXPECT_EQ(*cache.get_or_load(1, kNever, [] { return std::string("later"); }), "later");
}

TEST(BudgetCache, SharesForeignFailuresToo) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP()
      << "libstdc++.so counts a shared exception's references in code that ThreadSanitizer does not see";
#endif
  auto cache = make_cache(100);
  Flight flight(cache);
  flight.lead([]() -> std::string { throw std::runtime_error("codec"); });
  flight.join(kNever, unwanted);
  flight.finish();
  EXPECT_THAT(flight.results, testing::ElementsAre("foreign: codec", "foreign: codec"));
}

// The leader's time is over; the others still have theirs.
TEST(BudgetCache, HandsTheLoadOverWhenTheLeaderRunsOutOfTime) {
  auto cache = make_cache(100);
  Flight flight(cache);
  std::atomic<int> second_loads{0};
  flight.lead([]() -> std::string { fail(ErrorCode::kDeadlineExceeded, "leader"); });
  for (int i = 0; i < 3; ++i) {
    flight.join(kNever, [&] {
      ++second_loads;
      return std::string("second");
    });
  }
  flight.finish();
  EXPECT_THAT(flight.results,
              testing::UnorderedElementsAre("deadline-exceeded: leader", "second", "second", "second"));
  EXPECT_EQ(second_loads, 1);
}

TEST(BudgetCache, HandsOverAgainAndAgain) {
  auto cache = make_cache(100);
  Flight flight(cache);
  std::atomic<int> loads{0};
  flight.lead([]() -> std::string { fail(ErrorCode::kDeadlineExceeded, "late"); });
  for (int i = 0; i < 4; ++i) {
    flight.join(kNever, [&]() -> std::string {
      if (++loads < 4) fail(ErrorCode::kDeadlineExceeded, "late");
      return "fourth";
    });
  }
  flight.finish();
  EXPECT_THAT(flight.results,
              testing::UnorderedElementsAre("deadline-exceeded: late", "deadline-exceeded: late",
                                            "deadline-exceeded: late", "deadline-exceeded: late", "fourth"));
}

TEST(BudgetCache, ForgetsAFlightThatNobodyWants) {
  auto cache = make_cache(100);
  EXPECT_THROW(cache.get_or_load(1, kNever, []() -> std::string { fail(ErrorCode::kDeadlineExceeded, "x"); }),
               Error);
  CacheOutcome outcome;
  cache.get_or_load(
      1, kNever, [] { return std::string("x"); }, &outcome);
  EXPECT_EQ(outcome, CacheOutcome::kLoaded);
}

TEST(BudgetCache, WaitsNoLongerThanTheWaitersDeadline) {
  auto cache = make_cache(100);
  Flight flight(cache);
  flight.lead([] { return std::string("slow"); });
  try {
    cache.get_or_load(1, Deadline(milliseconds(20)), unwanted);
    FAIL() << "did not wait for its deadline";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
  }
  std::stop_source client;
  std::jthread canceller([&] { client.request_stop(); });
  EXPECT_THROW(cache.get_or_load(1, Deadline(milliseconds(3'600'000), client.get_token()), unwanted), Error);
  flight.finish();
  EXPECT_THAT(flight.results, testing::ElementsAre("slow"));
}

// Loads, hits, evictions, failures and hurried callers at once; the sanitizers judge.
TEST(BudgetCache, StandsCrowds) {
  auto cache = make_cache(40);
  std::atomic<int> wrong{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t) {
      threads.emplace_back([&, t] {
        for (int i = 0; i < 300; ++i) {
          const int key = (i * 7 + t) % 9;
          try {
            const auto value = cache.get_or_load(key, Deadline(milliseconds(i % 4)), [&] {
              if (i % 5 == 0) std::this_thread::sleep_for(milliseconds(1));
              if (i % 11 == 0) fail(ErrorCode::kDeadlineExceeded, "late");
              if (i % 13 == 0) fail(ErrorCode::kNotFound, "gone");
              return std::string(10, static_cast<char>('a' + key));
            });
            wrong += *value != std::string(10, static_cast<char>('a' + key));
          } catch (const Error&) {
          }
        }
      });
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(cache.stats().bytes, 40);
  for (int key = 0; key < 9; ++key) {
    EXPECT_EQ(
        cache.get_or_load(key, kNever, [&] { return std::string(10, static_cast<char>('a' + key)); })->size(),
        10u);
  }
}

}  // namespace
}  // namespace furnace
