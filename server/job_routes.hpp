// Renders that are answered later: /v1/jobs, and the 202 of POST /v1/renders.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "server/dispatcher.hpp"
#include "server/job_runner.hpp"
#include "server/outbound_url.hpp"

namespace furnace {

// Threads: any. Owns: nothing; store and runner outlive it.
class JobDoors {
 public:
  // `webhooks`: where the end of a job may be told.
  JobDoors(JobStore& store, JobRunner& runner, int max_streams, AllowList webhooks = {})
      : store_(store), runner_(runner), max_streams_(max_streams), webhooks_(std::move(webhooks)) {}

  // Whether the client would rather not wait (RFC 7240). Errors: kInvalidRequest for a webhook without a job.
  static bool is_asked_for(const Request& request);
  // 202, or what is known of the job that came with the same Idempotency-Key; its result, when it is there within the time that
  // the client would wait (Prefer: respond-async, wait=10). The request must have been understood already.
  // Errors: those of JobStore::create; kInvalidRequest for a Priority or an Idempotency-Key that cannot be; kUnprocessable for
  // a webhook that is not allowed.
  Reply accept(const Request& request);

  std::vector<Route> routes();
  int waiting() { return store_.waiting(); }
  std::int64_t unfinished_webhooks() { return store_.unfinished_deliveries(); }

 private:
  Job wait_for(const Request& request, Job job, std::chrono::seconds longest);
  std::shared_ptr<void> take_stream();
  Reply get(const Request& request);
  std::optional<Job> find(const Request& request, const std::string& id);
  Reply get_result(const Request& request, const std::string& id);
  Reply get_events(const Request& request, const std::string& id);
  Reply remove(const Request& request);

  JobStore& store_;
  JobRunner& runner_;
  const int max_streams_;
  const AllowList webhooks_;
  std::atomic<int> streams_ = 0;
};

}  // namespace furnace
