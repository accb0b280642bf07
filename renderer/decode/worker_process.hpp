// The parent's side of one child.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "renderer/base/descriptor.hpp"
#include "renderer/decode/jobs.hpp"
#include "renderer/decode/messages.hpp"
#include "renderer/decode/sandbox.hpp"

namespace furnace::decode {

// The program that decodes, its socket and limits are put behind it. The default is this one: a program whose main hands
// `decode-worker` to run_worker.
struct WorkerCommand {
  std::vector<std::string> program = {"/proc/self/exe", "decode-worker"};
  SandboxLimits limits;
};

// One job for a child.
struct Task {
  JobKind kind{};
  std::string_view name;  // of the job, for the log
  std::string arguments;  // with the request's own fields less than kMostMessageBytes
  Bytes file;
  std::int64_t block_bytes = 0;  // the largest result
  // Reads the result and judges it: false for one that no honest decoder gives. Runs on the caller's thread.
  std::function<bool(WireReader& result)> take;
};

// How an exchange came out.
struct Outcome {
  enum class Kind {
    kTaken,     // the result was taken
    kRefused,   // the decoder says why: `error`
    kUnsent,    // the child had ended before; the file is not to blame
    kDied,      // it ended on this file
    kGarbage,   // what it said makes no sense
    kOutOfTime  // neither came before `until`, or the request was cancelled
  };
  Kind kind = Kind::kTaken;
  Error error{};
};

// Threads: one at a time; the child must be started by a thread that outlives it, for it ends when that thread does.
// Owns: the child process, which is killed with it, and the socket.
class WorkerProcess {
 public:
  // Errors: kInternal, when the system gives no process.
  explicit WorkerProcess(const WorkerCommand& command);
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  // Waits until the child is ready; returns what its sandbox lacks, empty: nothing. None: it is no worker, or too slow.
  std::optional<std::string> greet(Clock::time_point until);

  // Afterwards the child can be used again only if the outcome is kTaken or kRefused.
  Outcome exchange(const Task& task, Clock::time_point until, const std::stop_token& cancel);

  pid_t pid() const { return pid_; }
  int jobs() const { return jobs_; }
  std::int64_t bytes() const { return bytes_; }  // of all files so far

  // Kills it and says how it ended, for the log: "exit status 1", "signal 11 (Segmentation fault)".
  std::string end();

 private:
  bool wait_for_message(Clock::time_point until);
  Outcome read_reply(const Task& task, const std::string& bytes, int block_fd) const;

  pid_t pid_ = -1;
  Descriptor socket_;
  std::uint64_t serial_ = 0;
  int jobs_ = 0;
  std::int64_t bytes_ = 0;
};

}  // namespace furnace::decode
