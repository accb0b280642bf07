#include "renderer/decode/worker_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <stop_token>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "renderer/base/check.hpp"
#include "renderer/decode/channel.hpp"

extern char** environ;

namespace furnace::decode {
namespace {

constexpr int kSocketOfChild = 3;

// What a program needs to start. Nothing else of our environment, which may hold what is secret.
constexpr std::array<std::string_view, 4> kInherited = {
    "LD_LIBRARY_PATH=", "ASAN_OPTIONS=", "TSAN_OPTIONS=", "UBSAN_OPTIONS="};

std::vector<char*> inherited_environment() {
  std::vector<char*> kept;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const auto begins = [&](std::string_view name) { return std::string_view(*entry).starts_with(name); };
    if (std::ranges::any_of(kInherited, begins)) kept.push_back(*entry);
  }
  kept.push_back(nullptr);
  return kept;
}

// Threads: one. Owns: what posix_spawn is told; the first fault is kept.
class SpawnPlan {
 public:
  explicit SpawnPlan(int socket) {
    ::posix_spawn_file_actions_init(&files_);
    ::posix_spawnattr_init(&attributes_);
    for (const int standard : {0, 1, 2})
      note(::posix_spawn_file_actions_addopen(&files_, standard, "/dev/null", O_RDWR, 0));
    note(::posix_spawn_file_actions_adddup2(&files_, socket, kSocketOfChild));
    note(::posix_spawn_file_actions_addclosefrom_np(&files_, kSocketOfChild + 1));
    // Our threads block what the main one waits for, and a terminal's signals are not for the child.
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    note(::posix_spawnattr_setsigmask(&attributes_, &none));
    note(::posix_spawnattr_setsigdefault(&attributes_, &all));
    note(::posix_spawnattr_setpgroup(&attributes_, 0));
    note(::posix_spawnattr_setflags(&attributes_,
                                    POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP));
  }
  ~SpawnPlan() {
    ::posix_spawn_file_actions_destroy(&files_);
    ::posix_spawnattr_destroy(&attributes_);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  // posix_spawn shares our memory until the child has its own program: no copy of a process with GL and threads.
  pid_t spawn(std::vector<std::string> words) {
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    std::vector<char*> environment = inherited_environment();
    pid_t pid = -1;
    if (fault_ == 0)
      note(::posix_spawn(&pid, argv[0], &files_, &attributes_, argv.data(), environment.data()));
    if (fault_ != 0) {
      fail(ErrorCode::kInternal, "no decoder could be started; try again", {},
           "posix_spawn: " + std::generic_category().message(fault_));
    }
    return pid;
  }

 private:
  void note(int fault) {
    if (fault_ == 0) fault_ = fault;
  }

  posix_spawn_file_actions_t files_;
  posix_spawnattr_t attributes_;
  int fault_ = 0;
};

int poll_ms(Clock::time_point until) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
  return int(std::clamp<std::int64_t>(left, 0, std::numeric_limits<int>::max()));
}

std::string ending_text(int status) {
  if (WIFEXITED(status)) return fmt::format("exit status {}", WEXITSTATUS(status));
  if (!WIFSIGNALED(status)) return fmt::format("status {}", status);
  const int number = WTERMSIG(status);
  const char* forbidden = number == SIGSYS ? ", a forbidden system call" : "";
  return fmt::format("signal {} ({}{})", number, ::strsignal(number), forbidden);
}

}  // namespace

WorkerProcess::WorkerProcess(const WorkerCommand& command) {
  SocketPair sockets = make_socket_pair();
  std::vector<std::string> words = command.program;
  words.push_back(std::to_string(kSocketOfChild));
  words.push_back(std::to_string(command.limits.memory_bytes));
  pid_ = SpawnPlan(sockets.theirs.get()).spawn(std::move(words));
  socket_ = std::move(sockets.ours);
}

WorkerProcess::~WorkerProcess() {
  end();
}

std::string WorkerProcess::end() {
  if (pid_ < 0) return {};
  ::kill(pid_, SIGKILL);
  int status = 0;
  pid_t ended = 0;
  do {
    ended = ::waitpid(pid_, &status, 0);
  } while (ended < 0 && errno == EINTR);
  pid_ = -1;
  socket_.close();
  return ended < 0 ? "unknown" : ending_text(status);
}

bool WorkerProcess::wait_for_message(Clock::time_point until) {
  for (;;) {
    pollfd wanted{socket_.get(), POLLIN, 0};
    const int ready = ::poll(&wanted, 1, poll_ms(until));
    if (ready > 0) return true;
    if (Clock::now() >= until) return false;
  }
}

std::optional<std::string> WorkerProcess::greet(Clock::time_point until) {
  if (!wait_for_message(until)) return std::nullopt;
  const auto message = receive_message(socket_.get());
  if (!message) return std::nullopt;
  WireReader reader(message->bytes);
  Hello hello;
  fields(reader, hello);
  if (!reader.ended_well() || hello.magic != kMagic) return std::nullopt;
  return std::move(hello.problem);
}

Outcome WorkerProcess::exchange(const Task& task, Clock::time_point until, const std::stop_token& cancel) {
  const Descriptor file = sealed_copy(task.file);
  const Descriptor block = empty_block(std::size_t(task.block_bytes));
  WireWriter head;
  fields(head, Request{kMagic, task.kind, ++serial_, task.file.size(), std::uint64_t(task.block_bytes)});
  ++jobs_;
  bytes_ += std::int64_t(task.file.size());
  const std::string request = head.bytes() + task.arguments;
  FURNACE_CHECK(request.size() < kMostMessageBytes, "{} bytes of arguments", request.size());
  const std::array<int, 2> descriptors = {file.get(), block.get()};
  // A cancelled request ends the wait by ending the child.
  const std::stop_callback on_cancel(cancel, [this] { ::kill(pid_, SIGKILL); });
  const bool sent = send_message(socket_.get(), request, descriptors);
  if (cancel.stop_requested()) return {Outcome::Kind::kOutOfTime};
  if (!sent) return {Outcome::Kind::kUnsent};
  if (!wait_for_message(until)) return {Outcome::Kind::kOutOfTime};
  const auto message = receive_message(socket_.get());
  if (message) return read_reply(task, message->bytes, block.get());
  return {cancel.stop_requested() ? Outcome::Kind::kOutOfTime : Outcome::Kind::kDied};
}

Outcome WorkerProcess::read_reply(const Task& task, const std::string& bytes, int block_fd) const {
  WireReader reader(bytes, block_fd, std::size_t(task.block_bytes));
  Reply reply;
  fields(reader, reply);
  if (reply.magic != kMagic || reply.serial != serial_) return {Outcome::Kind::kGarbage};
  if (!reply.failed)
    return {task.take(reader) && reader.ended_well() ? Outcome::Kind::kTaken : Outcome::Kind::kGarbage};
  // What a decoder may say of a file; the rest would be ours to say.
  const ErrorCode code = reply.error.code;
  const bool of_file = code == ErrorCode::kUnprocessable || code == ErrorCode::kTooLarge ||
                       code == ErrorCode::kUnsupportedMedia;
  if (!reader.ended_well() || !of_file) return {Outcome::Kind::kGarbage};
  return {Outcome::Kind::kRefused, std::move(reply.error)};
}

}  // namespace furnace::decode
