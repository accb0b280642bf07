// What a child may do to itself, and may not to us.
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "renderer/decode/process_decoder.hpp"
#include "tests/decode/hostile_job.hpp"

namespace furnace::decode::test {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::StartsWith;

#ifdef FURNACE_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

PoolConfig config_of(int processes) {
  log::set_level(log::Level::kOff);
  PoolConfig config;
  config.command.program = {FURNACE_HOSTILE_WORKER};
  config.command.limits.memory_bytes = 256 << 20;
  config.processes = processes;
  return config;
}

std::string text_of(const Echo& echo) {
  return {reinterpret_cast<const char*>(echo.bytes.data()), echo.bytes.size()};
}

std::string ask(ProcessPool& pool, Deed deed, const Deadline& deadline = {}, std::int64_t number = 0,
                std::string_view file = "abc") {
  return text_of(run_in(pool, HostileJob{deed, number}, std::as_bytes(std::span(file)), deadline));
}

Error error_of(ProcessPool& pool, Deed deed, const Deadline& deadline = {}, std::int64_t number = 0) {
  try {
    ask(pool, deed, deadline, number);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "deed " << int(deed) << " was done";
  return {};
}

std::size_t open_descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return std::size_t(std::distance(begin(all), end(all)));
}

// Of /proc/PID/status; empty when there is none.
std::string status_of(const std::string& pid, const std::string& name) {
  std::ifstream file("/proc/" + pid + "/status");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(name + ":")) continue;
    const std::size_t value = line.find_first_not_of(" \t", name.size() + 1);
    return value == std::string::npos ? std::string() : line.substr(value, 1);
  }
  return {};
}

TEST(ProcessPool, GivesWhatTheJobGives) {
  ProcessPool pool(config_of(1));
  EXPECT_EQ(ask(pool, Deed::kReverse), "cba");
  EXPECT_EQ(ask(pool, Deed::kReverse, {}, 0, ""), "");
  const std::string large(900'000, 'x');
  EXPECT_EQ(ask(pool, Deed::kReverse, {}, 0, large), large);
  const PoolStats stats = pool.stats();
  EXPECT_EQ(stats.jobs, 3);
  EXPECT_EQ(stats.starts, 1);
  EXPECT_EQ(stats.processes, 1);
}

TEST(ProcessPool, ErrorsOfAJobComeThroughUnchanged) {
  ProcessPool pool(config_of(1));
  const Error error = error_of(pool, Deed::kRefuse);
  EXPECT_EQ(error.code, ErrorCode::kTooLarge);
  EXPECT_EQ(error.message, "too large \xff");
  EXPECT_EQ(error.pointer, "/pointer");
  EXPECT_EQ(error.detail, "detail");
  EXPECT_EQ(pool.stats().crashes, 0);
  EXPECT_EQ(pool.stats().starts, 1);
}

struct Case {
  Deed deed;
  const char* ending;  // how the log says that it ended
};

void expect_one_request_lost(ProcessPool& pool, const Case& c) {
  SCOPED_TRACE(int(c.deed));
  const std::int64_t crashes = pool.stats().crashes;
  const Error error = error_of(pool, c.deed);
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_EQ(error.message, "the decoder failed on this file");
  EXPECT_THAT(error.detail, StartsWith(c.ending));
  EXPECT_EQ(pool.stats().crashes, crashes + 1);
  EXPECT_EQ(ask(pool, Deed::kReverse), "cba");
}

TEST(ProcessPool, ABreakdownCostsOneRequest) {
  ProcessPool pool(config_of(1));
  // A sanitizer makes its own ends of these; before it aborts, a program may write where it has no file.
  const char* const fault = kSanitized ? "" : "signal 11 ";
  const char* const abort = kSanitized ? "" : "signal ";
  for (const Case& c :
       {Case{Deed::kSegfault, fault}, Case{Deed::kOverflowStack, fault}, Case{Deed::kAbort, abort},
        Case{Deed::kThrowForeign, abort}, Case{Deed::kExit, "exit status 0"}})
    expect_one_request_lost(pool, c);
}

TEST(ProcessPool, ALieCostsOneRequest) {
  constexpr const char* kNonsense = "an answer that makes no sense";
  for (const Case& c : {Case{Deed::kSayNoise, kNonsense}, Case{Deed::kSayOtherSerial, kNonsense},
                        Case{Deed::kClaimHugeArray, kNonsense}, Case{Deed::kClaimLongText, kNonsense},
                        Case{Deed::kUnsound, kNonsense}, Case{Deed::kBlameUs, kNonsense},
                        Case{Deed::kSayNothingMore, "signal 9 "}}) {
    ProcessPool pool(config_of(1));  // the lies are about its first job
    expect_one_request_lost(pool, c);
  }
}

TEST(ProcessPool, ReachingOutCostsOneRequest) {
  ProcessPool pool(config_of(1));
  if (!pool.sandbox_problem().empty()) GTEST_SKIP() << "no sandbox here: " << pool.sandbox_problem();
  for (const Deed deed : {Deed::kOpenFile, Deed::kOpenSocket, Deed::kFork, Deed::kStartThread, Deed::kExec,
                          Deed::kMapCode, Deed::kMakeCode, Deed::kSignalParent, Deed::kRaiseLimits,
                          Deed::kWriteElsewhere, Deed::kAllocateShared})
    expect_one_request_lost(pool, {deed, "signal 31 "});
}

TEST(ProcessPool, MemoryIsBounded) {
  if (kSanitized) GTEST_SKIP() << "sanitizers need more address space than any limit leaves";
  ProcessPool pool(config_of(1));
  const Error error = error_of(pool, Deed::kAllocate);
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(error.message, HasSubstr("needs more memory"));
  EXPECT_EQ(ask(pool, Deed::kReverse), "cba");
}

TEST(ProcessPool, AChildHasOnlyWhatItNeeds) {
  ::setenv("FURNACE_TEST_SECRET", "hush", 1);
  // A library's descriptor that exec would hand on.
  const Descriptor leaky(::open("/dev/null", O_RDONLY));
  const Descriptor leakier(::fcntl(leaky.get(), F_DUPFD, 100));
  ProcessPool pool(config_of(1));
  EXPECT_EQ(ask(pool, Deed::kTellEnvironment).find("FURNACE_TEST_SECRET"), std::string::npos);
  EXPECT_EQ(ask(pool, Deed::kTellDescriptors), "0 1 2 4 5 ");
  const std::string pid = ask(pool, Deed::kTellPid);
  EXPECT_EQ(status_of(pid, "NoNewPrivs"), "1");
  if (pool.sandbox_problem().empty()) {
    EXPECT_EQ(status_of(pid, "Seccomp"), "2");
  }
  EXPECT_EQ(status_of(pid, "Threads"), "1");
}

TEST(ProcessPool, ATimeoutOfTheFileIsTheFilesFault) {
  PoolConfig config = config_of(1);
  config.timeout = milliseconds(50);
  ProcessPool pool(config);
  const Error error = error_of(pool, Deed::kSpin, {}, 60'000);
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_EQ(error.message, "the decoder did not finish this file within 50 ms");
  EXPECT_EQ(pool.stats().timeouts, 1);
  EXPECT_EQ(pool.stats().crashes, 0);
}

TEST(ProcessPool, TheRequestsEndEndsTheJob) {
  ProcessPool pool(config_of(1));
  const std::string pid = ask(pool, Deed::kTellPid);
  EXPECT_EQ(error_of(pool, Deed::kSpin, Deadline(milliseconds(50)), 60'000).code,
            ErrorCode::kDeadlineExceeded);
  EXPECT_EQ(::kill(std::stoi(pid), 0), -1);

  std::stop_source client;
  std::thread leaving([&] {
    std::this_thread::sleep_for(milliseconds(50));
    client.request_stop();
  });
  const Error gone = error_of(pool, Deed::kSpin, Deadline(milliseconds(60'000), client.get_token()), 60'000);
  leaving.join();
  EXPECT_EQ(gone.code, ErrorCode::kDeadlineExceeded);
  EXPECT_THAT(gone.message, HasSubstr("cancelled"));
  EXPECT_EQ(pool.stats().timeouts, 2);
  EXPECT_EQ(ask(pool, Deed::kReverse), "cba");
}

TEST(ProcessPool, WhoWaitsForAChildHasADeadlineToo) {
  ProcessPool pool(config_of(1));
  std::stop_source enough;
  std::thread busy(
      [&] { error_of(pool, Deed::kSpin, Deadline(milliseconds(60'000), enough.get_token()), 60'000); });
  std::string reason;
  while (reason.find("waiting for a decoder") == std::string::npos) {
    try {
      ask(pool, Deed::kReverse, Deadline(milliseconds(20)));
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
      reason = error.message;
    }
  }
  enough.request_stop();
  busy.join();
  EXPECT_EQ(error_of(pool, Deed::kReverse, Deadline(milliseconds(-1))).code, ErrorCode::kDeadlineExceeded);
  EXPECT_EQ(ask(pool, Deed::kReverse), "cba");
}

TEST(ProcessPool, AChildKilledFromOutsideIsReplaced) {
  ProcessPool pool(config_of(1));
  // At work: the request is lost.
  const pid_t first = std::stoi(ask(pool, Deed::kTellPid));
  std::thread killer([&] {
    std::this_thread::sleep_for(milliseconds(50));
    ::kill(first, SIGKILL);
  });
  const Error error = error_of(pool, Deed::kSpin, {}, 60'000);
  killer.join();
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(error.detail, StartsWith("signal 9 "));
  // Idle: nobody notices.
  const std::string second = ask(pool, Deed::kTellPid);
  ::kill(std::stoi(second), SIGKILL);
  while (status_of(second, "State") != "Z") std::this_thread::yield();
  EXPECT_EQ(ask(pool, Deed::kReverse), "cba");
  EXPECT_EQ(pool.stats().crashes, 1);
  EXPECT_EQ(pool.stats().starts, 3);
}

TEST(ProcessPool, WhatEndsAGroupDoesNotEndAChild) {
  ProcessPool pool(config_of(1));
  const std::string pid = ask(pool, Deed::kTellPid);
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) ::kill(std::stoi(pid), number);
  EXPECT_EQ(ask(pool, Deed::kTellPid), pid);
}

TEST(ProcessPool, AChildServesSoManyJobsOrBytes) {
  PoolConfig by_jobs = config_of(1);
  by_jobs.jobs_per_process = 2;
  ProcessPool pool(by_jobs);
  const std::string first = ask(pool, Deed::kTellPid);
  EXPECT_EQ(ask(pool, Deed::kTellPid), first);
  EXPECT_NE(ask(pool, Deed::kTellPid), first);
  EXPECT_EQ(pool.stats().starts, 2);

  PoolConfig by_bytes = config_of(1);
  by_bytes.bytes_per_process = 1000;
  ProcessPool other(by_bytes);
  for (int i = 0; i < 4; ++i) ask(other, Deed::kReverse, {}, 0, std::string(500, 'x'));
  EXPECT_EQ(other.stats().starts, 2);
}

// Honest and hostile ones at once: each gets its own answer, and nothing is left over.
TEST(ProcessPool, TwoHundredJobsOnEightThreads) {
  ProcessPool pool(config_of(3));
  ask(pool, Deed::kReverse);
  const std::size_t before = open_descriptors();
  constexpr int kThreads = 8, kJobs = 25, kKillers = 13;
  std::atomic<int> right = 0, refused = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < kJobs; ++i) {
        const int index = t * kJobs + i;
        const std::string file = std::to_string(index);
        try {
          const std::string answer =
              ask(pool, index % kKillers == 0 ? Deed::kAbort : Deed::kReverse, {}, 0, file);
          right += answer == std::string(file.rbegin(), file.rend());
        } catch (const Error& error) {
          refused += error.code == ErrorCode::kUnprocessable && index % kKillers == 0;
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  constexpr int kAll = kThreads * kJobs, kLost = (kAll + kKillers - 1) / kKillers;
  EXPECT_EQ(right, kAll - kLost);
  EXPECT_EQ(refused, kLost);
  EXPECT_EQ(pool.stats().crashes, kLost);
  EXPECT_LE(pool.stats().processes, 3);
  EXPECT_EQ(pool.stats().starts, kLost + pool.stats().processes);
  // A child's end of a socket is one descriptor; two more children may have come since.
  EXPECT_LE(open_descriptors(), before + 2);
}

TEST(ProcessPool, AProgramThatIsNoWorkerIsAnError) {
  PoolConfig config = config_of(1);
  for (const char* program : {"/bin/true", "/nonexistent/program"}) {
    config.command.program = {program};
    try {
      const ProcessPool pool(config);
      ADD_FAILURE() << program;
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kInternal);
      EXPECT_FALSE(error.detail.empty());
    }
  }
}

TEST(RestartBudget, ABurstThenASteadyRate) {
  RestartBudget budget;
  const Clock::time_point now = Clock::now();
  for (int i = 0; i < RestartBudget::kBurst; ++i) {
    EXPECT_LE(budget.next_start(), now);
    budget.note_failure(now);
  }
  EXPECT_EQ(budget.next_start(), now);
  budget.note_failure(now);
  EXPECT_EQ(budget.next_start(), now + RestartBudget::kInterval);
  // A quiet while later the burst is there again.
  const Clock::time_point later = now + RestartBudget::kInterval * (RestartBudget::kBurst + 1);
  budget.note_failure(later);
  EXPECT_EQ(budget.next_start(), later - RestartBudget::kInterval * (RestartBudget::kBurst - 1));
}

}  // namespace
}  // namespace furnace::decode::test
