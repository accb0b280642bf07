#include "renderer/base/worker_pool.hpp"

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace furnace {
namespace {

constexpr double kLongWork_us = 1e6;  // worth sharing at any count

TEST(WorkerPool, RunsOnAnotherThreadAndWaits) {
  WorkerPool pool(2);
  std::thread::id where;
  pool.run(Lane::kDecode, [&] { where = std::this_thread::get_id(); });
  EXPECT_NE(where, std::thread::id());
  EXPECT_NE(where, std::this_thread::get_id());
  EXPECT_EQ(pool.threads(), 2);
}

TEST(WorkerPool, BringsExceptionsBack) {
  WorkerPool pool(1);
  EXPECT_THROW(pool.run(Lane::kEncode, [] { throw std::runtime_error("codec"); }), std::runtime_error);
  EXPECT_THROW(pool.run(Lane::kDecode, [] { fail(ErrorCode::kTooLarge, "big"); }), Error);
  int runs = 0;
  pool.run(Lane::kEncode, [&] { ++runs; });
  EXPECT_EQ(runs, 1) << "the thread did not survive";
}

// One thread held up, then decodes before encodes: the encodes leave first.
TEST(WorkerPool, EncodesGoFirst) {
  WorkerPool pool(1);
  std::latch begun(1), queued(1);
  std::mutex mutex;
  std::string order;
  std::vector<std::jthread> callers;
  callers.emplace_back([&] {
    pool.run(Lane::kDecode, [&] {
      begun.count_down();
      queued.wait();
    });
  });
  begun.wait();
  for (char lane : {'d', 'd', 'e', 'e'}) {
    callers.emplace_back([&, lane] {
      pool.run(lane == 'e' ? Lane::kEncode : Lane::kDecode, [&, lane] {
        const std::lock_guard lock(mutex);
        order += lane;
      });
    });
  }
  while (pool.queued() < 4) std::this_thread::yield();
  queued.count_down();
  callers.clear();
  EXPECT_EQ(order, "eedd");
}

TEST(WorkerPool, NestsWithoutDeadlock) {
  WorkerPool pool(1);
  int depth = 0;
  pool.run(Lane::kDecode, [&] {
    pool.run(Lane::kEncode, [&] { pool.parallel_for(10, kLongWork_us, [&](std::size_t) { ++depth; }); });
  });
  EXPECT_EQ(depth, 10);
}

TEST(WorkerPool, ParallelForVisitsEachIndexOnce) {
  for (int threads : {1, 2, 5}) {
    WorkerPool pool(threads);
    for (double cost_us : {0.0, 0.01, 1.0, kLongWork_us}) {
      for (std::size_t count : {0u, 1u, 2u, 3u, 7u, 1000u}) {
        std::vector<std::atomic<int>> visits(count);
        pool.parallel_for(count, cost_us, [&](std::size_t i) { ++visits.at(i); });
        for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(visits[i], 1) << i << " of " << count;
      }
    }
  }
}

TEST(WorkerPool, ParallelForSharesTheWork) {
  WorkerPool pool(3);
  std::latch all_here(3);  // passes only when three threads work at once
  pool.parallel_for(3, kLongWork_us, [&](std::size_t) { all_here.arrive_and_wait(); });
}

TEST(WorkerPool, ParallelForKeepsSmallWorkInPlace) {
  WorkerPool pool(3);
  std::set<std::thread::id> where;
  pool.parallel_for(100, 1.0, [&](std::size_t) { where.insert(std::this_thread::get_id()); });
  EXPECT_THAT(where, testing::ElementsAre(std::this_thread::get_id()));
}

TEST(WorkerPool, ParallelForNests) {
  WorkerPool pool(3);
  std::atomic<int> visits{0};
  pool.parallel_for(8, kLongWork_us, [&](std::size_t) {
    pool.parallel_for(8, kLongWork_us, [&](std::size_t) {
      pool.parallel_for(8, kLongWork_us, [&](std::size_t) { ++visits; });
    });
  });
  EXPECT_EQ(visits, 512);
}

TEST(WorkerPool, ParallelForServesManyCallers) {
  WorkerPool pool(2);
  std::atomic<int> visits{0};
  {
    std::vector<std::jthread> callers;
    for (int c = 0; c < 6; ++c) {
      callers.emplace_back([&] {
        for (int round = 0; round < 20; ++round)
          pool.parallel_for(50, kLongWork_us, [&](std::size_t) { ++visits; });
      });
    }
  }
  EXPECT_EQ(visits, 6 * 20 * 50);
}

// The failure reported does not depend on who was faster: always the lowest index that fails.
TEST(WorkerPool, ParallelForRethrowsTheLowestFailureAfterAllEnded) {
  WorkerPool pool(4);
  for (int round = 0; round < 50; ++round) {
    std::atomic<int> running{0};
    try {
      pool.parallel_for(100, 30.0, [&](std::size_t i) {
        ++running;
        std::this_thread::yield();
        --running;
        if (i % 10 == 7) fail(ErrorCode::kUnprocessable, std::to_string(i));
      });
      FAIL() << "nothing was thrown";
    } catch (const Error& error) {
      ASSERT_EQ(error.message, "7");
    }
    ASSERT_EQ(running, 0);
  }
}

TEST(WorkerPool, FinishesWhatIsQueuedBeforeItEnds) {
  std::atomic<int> done{0};
  std::vector<std::jthread> callers;
  std::latch begun(1), go(1);
  {
    WorkerPool pool(1);
    callers.emplace_back([&] {
      pool.run(Lane::kDecode, [&] {
        begun.count_down();
        go.wait();
        ++done;
      });
    });
    begun.wait();
    callers.emplace_back([&] { pool.run(Lane::kEncode, [&] { ++done; }); });
    while (pool.queued() < 1) std::this_thread::yield();
    go.count_down();
  }
  EXPECT_EQ(done, 2);
}

TEST(WorkerPool, CarriesTheRequestAlong) {
  WorkerPool pool(2);
  const log::RequestScope scope({"r-7", {}, {}});
  std::string seen;
  pool.run(Lane::kDecode, [&] { seen = log::origin().request; });
  EXPECT_EQ(seen, "r-7");
  std::atomic<int> wrong{0};
  pool.parallel_for(20, kLongWork_us, [&](std::size_t) { wrong += log::origin().request != "r-7"; });
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace furnace
