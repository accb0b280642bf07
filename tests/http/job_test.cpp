// The list of jobs, by itself and with its threads.
#include <atomic>
#include <filesystem>
#include <functional>
#include <thread>

#include <unistd.h>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "server/job_runner.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

class JobStoreTest : public ::testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  static JobRequest request(std::string body, int priority = 0, std::optional<std::string> key = {}) {
    return {"/v1/renders", "application/json", "*/*", std::move(body), priority, std::move(key)};
  }
  // The text of the error; "" without one.
  static std::string refusal(const std::function<void()>& what) {
    try {
      what();
    } catch (const Error& error) {
      return error.message;
    }
    return {};
  }

  fs::path folder_ = fs::temp_directory_path() / ("job_test." + std::to_string(::getpid()));
};

TEST_F(JobStoreTest, FromTheQueueToTheResult) {
  JobStore store({}, {});
  const Job made = store.create(request("{\"a\":\"\\u0000\"}" + std::string("\0x", 2)), 1000).job;
  EXPECT_EQ(made.id.size(), 32u);
  EXPECT_EQ(made.status, JobStatus::kQueued);
  EXPECT_EQ(made.created_ms, 1000);
  EXPECT_FALSE(store.result(made.id));
  const auto work = store.begin(2000);
  ASSERT_TRUE(work);
  EXPECT_EQ(work->id, made.id);
  EXPECT_EQ(work->request.body, "{\"a\":\"\\u0000\"}" + std::string("\0x", 2));
  EXPECT_FALSE(store.begin(2000));
  store.tell_progress(made.id, {3, 8, "bake", 0.25});
  EXPECT_EQ(store.find(made.id)->progress.frames_done, 3);
  EXPECT_EQ(store.find(made.id)->progress.share, 0.25);
  EXPECT_EQ(store.find(made.id)->status, JobStatus::kRunning);
  const std::string result("\0bytes\xff", 7);
  store.succeed(made.id, result, 3000);
  EXPECT_EQ(store.find(made.id)->status, JobStatus::kSucceeded);
  EXPECT_EQ(store.find(made.id)->finished_ms, 3000);
  EXPECT_EQ(store.result(made.id), result);
  EXPECT_TRUE(store.remove(made.id, 4000));
  EXPECT_FALSE(store.find(made.id));
  EXPECT_FALSE(store.result(made.id));
  EXPECT_FALSE(store.remove(made.id, 4000));
}

TEST_F(JobStoreTest, TheMoreImportantFirstThenTheOlder) {
  JobStore store({}, {});
  for (const auto& [body, priority] : {std::pair{"a", 0}, {"b", 5}, {"c", 0}, {"d", 5}})
    store.create(request(body, priority), 0);
  std::string order;
  while (const auto work = store.begin(0)) order += work->request.body;
  EXPECT_EQ(order, "bdac");
}

TEST_F(JobStoreTest, OneKeyIsOneJob) {
  JobStore store({}, {});
  const auto first = store.create(request("a", 0, "k"), 0);
  const auto again = store.create(request("a", 0, "k"), 5);
  EXPECT_TRUE(first.is_new);
  EXPECT_FALSE(again.is_new);
  EXPECT_EQ(again.job.id, first.job.id);
  EXPECT_NE(refusal([&] { store.create(request("b", 0, "k"), 5); }), "");
  EXPECT_EQ(store.waiting(), 1);
}

TEST_F(JobStoreTest, TheKeysOfTwoClientsAreTwo) {
  JobStore store({}, {});
  const auto of = [&](std::string client, std::string body) {
    JobRequest wanted = request(std::move(body), 0, "key");
    wanted.client = std::move(client);
    return store.create(wanted, 0);
  };
  const std::string annas = of("anna", "a").job.id;
  EXPECT_TRUE(of("berta", "b").is_new);
  EXPECT_TRUE(of("", "c").is_new);
  EXPECT_EQ(of("anna", "a").job.id, annas);
  EXPECT_EQ(store.find(annas)->client, "anna");
  EXPECT_NE(refusal([&] { of("berta", "a"); }), "");
}

TEST_F(JobStoreTest, BoundsHold) {
  JobLimits limits;
  limits.max_waiting = 2;
  limits.max_bytes = 100;
  limits.keep_ms = 1000;
  JobStore store({}, limits);
  EXPECT_NE(refusal([&] { store.create(request(std::string(101, 'a')), 0); }), "");
  const std::string first = store.create(request("a"), 0).job.id;
  store.create(request("b"), 0);
  EXPECT_NE(refusal([&] { store.create(request("c"), 0); }), "") << "two wait";
  const auto finish = [&](std::int64_t now_ms) {
    store.succeed(store.begin(now_ms)->id, std::string(60, 'r'), now_ms);
  };
  finish(10);
  EXPECT_TRUE(store.result(first));
  finish(20);
  EXPECT_FALSE(store.find(first)) << "two results are more than may be kept, the older one goes";
  const std::string third = store.create(request("d"), 30).job.id;
  finish(30);
  EXPECT_TRUE(store.find(third));
  store.trim(2000);
  EXPECT_FALSE(store.find(third)) << "kept for a second only";
}

TEST_F(JobStoreTest, ACancelledJobHasNoResult) {
  JobStore store({}, {});
  const std::string waiting = store.create(request("a"), 0).job.id;
  EXPECT_TRUE(store.remove(waiting, 1));
  EXPECT_EQ(store.find(waiting)->status, JobStatus::kCancelled);
  EXPECT_FALSE(store.begin(1));
  const std::string running = store.create(request("b"), 2).job.id;
  store.begin(2);
  store.remove(running, 3);
  store.succeed(running, "late", 4);
  EXPECT_EQ(store.find(running)->status, JobStatus::kCancelled);
  EXPECT_FALSE(store.result(running));
}

TEST_F(JobStoreTest, OutlivesItsProcess) {
  std::string done, ran, waited;
  {
    JobStore store(folder_, {});
    done = store.create(request("a"), 0).job.id;
    store.succeed(store.begin(0)->id, "result", 0);
    ran = store.create(request("b"), 0).job.id;
    waited = store.create(request("c"), 0).job.id;
    store.begin(0);
  }
  JobStore store(folder_, {});
  EXPECT_EQ(store.result(done), "result");
  EXPECT_EQ(store.find(ran)->status, JobStatus::kQueued);
  EXPECT_EQ(store.begin(0)->id, ran) << "in its old place";
  EXPECT_EQ(store.find(ran)->attempts, 2);
  EXPECT_EQ(store.begin(0)->id, waited);
}

TEST_F(JobStoreTest, WhatKillsTheProcessAgainAndAgainFails) {
  std::string id;
  for (int life = 0; life < 3; ++life) {
    JobStore store(folder_, {});
    if (life == 0) id = store.create(request("a"), 0).job.id;
    ASSERT_TRUE(store.begin(0)) << life;
  }
  JobStore store(folder_, {});
  EXPECT_EQ(store.find(id)->status, JobStatus::kFailed);
  EXPECT_NE(store.find(id)->problem, "");
  EXPECT_FALSE(store.begin(0));
}

TEST_F(JobStoreTest, WhatWasPutBackHasNotBeenTried) {
  JobStore store({}, {});
  const std::string id = store.create(request("a"), 0).job.id;
  for (int i = 0; i < 10; ++i) store.put_back(store.begin(0)->id);
  EXPECT_EQ(store.find(id)->attempts, 0);
  EXPECT_EQ(store.find(id)->status, JobStatus::kQueued);
}

TEST_F(JobStoreTest, WithoutAFolderToWriteToItWorksInMemory) {
  std::fclose(std::fopen(folder_.c_str(), "wb"));  // a file where the folder should be
  JobStore store(folder_, {});
  const std::string id = store.create(request("a"), 0).job.id;
  EXPECT_EQ(store.begin(0)->id, id);
}

TEST_F(JobStoreTest, AForeignFileIsRefused) {
  fs::create_directories(folder_);
  for (const std::string& content :
       {std::string("not a database, but long enough to be looked at"), std::string(4096, '\0')}) {
    std::FILE* file = std::fopen((folder_ / "jobs.sqlite").c_str(), "wb");
    std::fwrite(content.data(), 1, content.size(), file);
    std::fclose(file);
    EXPECT_NE(refusal([&] { JobStore(folder_, {}); }), "");
  }
}

// Waits until `what` holds.
bool soon(const std::function<bool()>& what) {
  for (int i = 0; i < 1000 && !what(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return what();
}

TEST_F(JobStoreTest, TheWaitInTheQueueCounts) {
  JobStore store({}, {});
  const std::int64_t now_ms = unix_time_ms();
  const std::string late = store.create(request("late"), now_ms - 61'000).job.id;
  const std::string hurried = store.create(request("hurried"), now_ms - 50'000).job.id;
  std::atomic<int> worked = 0;
  Clock::time_point end{};
  JobRunner runner(store,
                   [&](const JobRequest&, const Deadline& deadline, const auto&) -> std::string {
                     end = deadline.end();
                     ++worked;
                     return "drawn";
                   },
                   {1, std::chrono::minutes(10), std::chrono::minutes(1)});
  EXPECT_TRUE(soon(
      [&] { return is_finished(store.find(late)->status) && is_finished(store.find(hurried)->status); }));
  EXPECT_EQ(store.find(late)->status, JobStatus::kFailed);
  EXPECT_NE(store.find(late)->problem.find("\"status\": 504"), std::string::npos)
      << store.find(late)->problem;
  EXPECT_EQ(store.find(hurried)->status, JobStatus::kSucceeded);
  EXPECT_EQ(worked, 1);
  EXPECT_LT(end, Clock::now() + std::chrono::seconds(11)) << "no more than what is left";
}

TEST_F(JobStoreTest, ThreadsWorkThroughTheList) {
  JobStore store({}, {});
  std::atomic<int> worked = 0;
  JobRunner runner(store,
                   [&](const JobRequest& request, const Deadline&, const auto& progress) -> std::string {
                     progress({1, 2});
                     ++worked;
                     if (request.body == "bad") fail(ErrorCode::kUnprocessable, "no such thing", "/scene");
                     if (request.body == "stray") throw std::runtime_error("stray");
                     return "drawn " + request.body;
                   },
                   {2, std::chrono::seconds(10)});
  std::vector<std::string> ids;
  for (const char* body : {"a", "bad", "b", "stray"}) {
    ids.push_back(store.create(request(body), unix_time_ms()).job.id);
    runner.wake();
  }
  for (const std::string& id : ids) EXPECT_TRUE(soon([&] { return is_finished(store.find(id)->status); }));
  EXPECT_EQ(worked, 4);
  EXPECT_EQ(store.result(ids[0]), "drawn a");
  EXPECT_NE(store.find(ids[1])->problem.find("/scene"), std::string::npos);
  EXPECT_EQ(store.find(ids[3])->status, JobStatus::kFailed);
}

TEST_F(JobStoreTest, RemovingEndsTheWork) {
  JobStore store({}, {});
  std::atomic<bool> begun = false, ended = false;
  JobRunner runner(store,
                   [&](const JobRequest&, const Deadline& deadline, const auto&) -> std::string {
                     begun = true;
                     while (!deadline.passed()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                     ended = true;
                     check_deadline(deadline, "draw");
                     return {};
                   },
                   {1, std::chrono::seconds(60)});
  const std::string id = store.create(request("a"), unix_time_ms()).job.id;
  runner.wake();
  ASSERT_TRUE(soon([&] { return begun.load(); }));
  EXPECT_TRUE(runner.remove(id));
  EXPECT_TRUE(soon([&] { return ended.load(); }));
  EXPECT_EQ(store.find(id)->status, JobStatus::kCancelled);
}

TEST_F(JobStoreTest, WhatRunsWhenTheServerEndsWaitsAgain) {
  JobStore store({}, {});
  std::atomic<bool> begun = false;
  const std::string id = store.create(request("a"), unix_time_ms()).job.id;
  {
    JobRunner runner(store,
                     [&](const JobRequest&, const Deadline& deadline, const auto&) -> std::string {
                       begun = true;
                       while (!deadline.passed()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                       check_deadline(deadline, "draw");
                       return {};
                     },
                     {1, std::chrono::seconds(60)});
    ASSERT_TRUE(soon([&] { return begun.load(); }));
  }
  EXPECT_EQ(store.find(id)->status, JobStatus::kQueued);
  EXPECT_EQ(store.find(id)->attempts, 0);
}

}  // namespace
}  // namespace furnace
