// The program that the tests start as a child: it knows HostileJob beside the real jobs.
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "renderer/base/error.hpp"
#include "renderer/decode/worker.hpp"
#include "tests/decode/hostile_job.hpp"

extern char** environ;

namespace furnace::decode::test {
namespace {

constexpr int kSocket = 3;

Echo echo_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {{bytes.begin(), bytes.end()}};
}

void spin(std::int64_t ms) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(ms);
  while (std::chrono::steady_clock::now() < end) {
  }
}

std::string environment_text() {
  std::string text;
  for (char** entry = environ; *entry != nullptr; ++entry) text += std::string(*entry) + "\n";
  return text;
}

std::string descriptors_text() {
  std::string text;
  for (int fd = 0; fd < 256; ++fd) {
    // What can be closed was open; what tells it otherwise is not allowed here.
    if (fd != kSocket && ::close(fd) == 0) text += std::to_string(fd) + " ";
  }
  return text;
}

// Volatile, so that no compiler sees where they lead.
volatile int* volatile nowhere = nullptr;
int (*volatile deeper)(int) = nullptr;

int overflow_stack(int depth) {
  volatile char frame[4096];
  frame[0] = char(depth);
  return deeper(depth + 1) + frame[0];
}

void allocate() {
  std::vector<std::vector<char>> held;
  for (;;) held.emplace_back(16 << 20, 'x');
}

void allocate_shared() {
  for (;;) {
    void* memory = ::mmap(nullptr, 16 << 20, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) std::abort();
    std::memset(memory, 1, 16 << 20);
  }
}

void say(const std::string& text) {
  send_message(kSocket, text);
}

void say_reply(std::uint64_t serial, const std::string& rest) {
  Reply reply;
  reply.serial = serial;
  WireWriter writer;
  fields(writer, reply);
  say(writer.bytes() + rest);
}

template <class Number>
std::string wire_text(Number number) {
  WireWriter writer;
  writer.number(number);
  return writer.bytes();
}

void reach_out(Deed deed) {
  switch (deed) {
    case Deed::kOpenFile:
      ::open("/etc/hostname", O_RDONLY);
      break;
    case Deed::kOpenSocket:
      ::socket(AF_INET, SOCK_STREAM, 0);
      break;
    case Deed::kFork:
      ::fork();
      break;
    case Deed::kStartThread:
      std::thread([] {}).join();
      break;
    case Deed::kExec:
      ::execl("/bin/true", "true", nullptr);
      break;
    case Deed::kMapCode:
      ::mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
      break;
    case Deed::kMakeCode: {
      void* memory = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
      ::mprotect(memory, 4096, PROT_READ | PROT_EXEC);
      break;
    }
    case Deed::kSignalParent:
      ::kill(1, 0);
      break;
    case Deed::kRaiseLimits: {
      const rlimit more{1 << 20, 1 << 20};
      ::setrlimit(RLIMIT_NOFILE, &more);
      break;
    }
    case Deed::kWriteElsewhere: {
      const ssize_t ignored = ::write(STDOUT_FILENO, "x", 1);
      static_cast<void>(ignored);
      break;
    }
    default:
      break;
  }
}

void lie(Deed deed) {
  switch (deed) {
    case Deed::kSayNothingMore:
      ::close(kSocket);
      spin(60'000);
      break;
    case Deed::kSayNoise:
      say("noise");
      break;
    case Deed::kSayOtherSerial:
      say_reply(77, wire_text(std::uint64_t(0)));
      break;
    case Deed::kClaimHugeArray:
      say_reply(1, wire_text(~std::uint64_t(0)));
      break;
    case Deed::kClaimLongText: {
      WireWriter writer;
      writer.number(kMagic);
      writer.number(std::uint64_t(1));
      writer.number(std::uint8_t(1));
      writer.number(std::uint8_t(ErrorCode::kUnprocessable));
      writer.number(~std::uint32_t(0));
      say(writer.bytes());
      break;
    }
    default:
      break;
  }
}

void break_down(Deed deed) {
  switch (deed) {
    case Deed::kRefuse:
      fail(ErrorCode::kTooLarge, "too large \xff", "/pointer", "detail");
    case Deed::kBlameUs:
      fail(ErrorCode::kGpuUnavailable, "it was not me");
    case Deed::kThrowForeign:
      throw std::length_error("of a library");
    case Deed::kSegfault:
      *nowhere = 1;
      break;
    case Deed::kAbort:
      std::abort();
    case Deed::kOverflowStack:
      deeper = &overflow_stack;
      overflow_stack(0);
      break;
    case Deed::kExit:
      ::_exit(0);
    case Deed::kAllocate:
      allocate();
      break;
    case Deed::kAllocateShared:
      allocate_shared();
      break;
    default:
      break;
  }
}

}  // namespace

Echo HostileJob::run(Bytes file) const {
  if (deed == Deed::kTellPid) return echo_of(std::to_string(::getpid()));
  if (deed == Deed::kTellEnvironment) return echo_of(environment_text());
  if (deed == Deed::kTellDescriptors) return echo_of(descriptors_text());
  if (deed == Deed::kUnsound) return {std::vector<std::byte>(1 << 20)};
  if (deed == Deed::kSpin) spin(number);
  break_down(deed);
  reach_out(deed);
  lie(deed);
  return {{file.rbegin(), file.rend()}};
}

}  // namespace furnace::decode::test

int main(int argc, char** argv) {
  using namespace furnace::decode;
  std::vector<JobRow> jobs(decode_jobs().begin(), decode_jobs().end());
  jobs.push_back(job_row<test::HostileJob>());
  return run_worker(std::span(argv, std::size_t(argc)).subspan(1), jobs);
}
