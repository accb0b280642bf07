// Renders that were asked for and are answered later: what they are, how far they are, what came of them. Nothing of it is lost
// when the process dies.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/delivery_table.hpp"
#include "server/render_progress.hpp"

namespace furnace {

enum class JobStatus { kQueued, kRunning, kSucceeded, kFailed, kCancelled };
std::string_view name_of(JobStatus status);  // "queued", ...
inline bool is_finished(JobStatus status) {
  return status != JobStatus::kQueued && status != JobStatus::kRunning;
}

// A request as it came.
struct JobRequest {
  std::string target;  // path
  std::string content_type, accept, body;
  int priority = 0;                            // larger first; equals in their order
  std::optional<std::string> idempotency_key;  // the same of one client is the same job; not read back
  std::optional<Webhook> webhook = {};         // likewise
  std::string client = {};                     // the key's name; "": anybody's
};

struct Job {
  std::string id;      // 32 hexadecimal digits
  std::string client;  // as JobRequest::client
  JobStatus status = JobStatus::kQueued;
  int priority = 0;
  std::int64_t created_ms = 0, started_ms = 0, finished_ms = 0;  // since the epoch; 0: not yet
  RenderProgress progress = {};                                  // of what runs
  int attempts = 0;                                              // begun, this one included
  std::string problem;                                           // problem document, of one that failed
  std::optional<DeliveryState> delivery = {};                    // of its webhook
};

// What a worker takes.
struct JobWork {
  std::string id;
  JobRequest request;
};

struct JobLimits {
  int max_waiting = 1000;
  std::int64_t max_bytes = 4096ll << 20;      // requests and results together
  std::int64_t keep_ms = 24ll * 3600 * 1000;  // finished ones
  int max_attempts = 3;                       // that ended with the process
  std::int64_t max_deliveries = 10'000;       // webhooks not yet delivered, those of waiting jobs too
};

// One SQLite database, FOLDER/jobs.sqlite, or in memory without a folder, or with one that cannot be written to: then the log
// says so, and jobs end with the process. A database that cannot be opened at first, on a full disk, is opened later. Every change is on the disk when its function returns.
// Errors of all: kStorage.
// Threads: any. Owns: the database; one object per folder and process.
class JobStore {
 public:
  // What ran when the last process died waits again, unless it has used up its attempts.
  JobStore(const std::filesystem::path& folder, const JobLimits& limits);
  ~JobStore();

  struct Created {
    Job job;
    bool is_new = true;
  };
  // Errors: kOverloaded when as many wait as may; kTooLarge; kUnprocessable at /Idempotency-Key for a key that came with
  // another request.
  Created create(const JobRequest& request, std::int64_t now_ms);

  // The next to work on, which is running from now on.
  std::optional<JobWork> begin(std::int64_t now_ms);
  // Gives back what was begun: the process ends.
  void put_back(const std::string& id);
  void tell_progress(const std::string& id, const RenderProgress& progress);
  // No effect on a job that is not running: it may have been cancelled meanwhile.
  void succeed(const std::string& id, std::string_view result, std::int64_t now_ms);
  void fail(const std::string& id, std::string_view problem, std::int64_t now_ms);

  std::optional<Job> find(const std::string& id);
  // As it was given to succeed.
  std::optional<std::string> result(const std::string& id);
  // What waits or runs becomes cancelled; what is finished goes, with a webhook that was not yet delivered. False: there is no
  // such job.
  bool remove(const std::string& id, std::int64_t now_ms);

  int waiting();

  // Webhooks: a job's end makes its delivery due, in one change with it. What begin_delivery gives must be ended by one of the
  // three that follow; when the process ends before, it is tried again.
  std::optional<DeliveryWork> begin_delivery(std::int64_t now_ms);
  void put_back_delivery(const std::string& id);  // as if it had not been tried
  void try_delivery_again(const std::string& id, std::int64_t next_ms, std::string_view outcome);
  void finish_delivery(const std::string& id, DeliveryStatus status, std::string_view outcome);
  std::optional<std::int64_t> next_delivery_ms();  // since the epoch; when there may be one to begin
  std::int64_t unfinished_deliveries();
  // Forgets what has been finished for long, and the oldest finished ones beyond the bytes that may be kept.
  void trim(std::int64_t now_ms);

 private:
  struct Database;
  Database& database();  // Errors: kStorage

  std::filesystem::path file_;  // empty: in memory
  std::mutex mutex_;            // of the database and what it prepares
  std::unique_ptr<Database> database_;
  const JobLimits limits_;
};

}  // namespace furnace
