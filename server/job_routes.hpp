// Renders that are answered later: /v1/jobs, and the 202 of POST /v1/renders.
#pragma once

#include <atomic>
#include <functional>
#include <vector>

#include "server/dispatcher.hpp"
#include "server/job_runner.hpp"

namespace furnace {

// Threads: any. Owns: nothing; store and runner outlive it.
class JobDoors {
 public:
  JobDoors(JobStore& store, JobRunner& runner, int max_streams)
      : store_(store), runner_(runner), max_streams_(max_streams) {}

  // Whether the client would rather not wait (RFC 7240).
  static bool is_asked_for(const Request& request);
  // 202, or what is known of the job that came with the same Idempotency-Key. The request must have been understood already.
  // Errors: those of JobStore::create; kInvalidRequest for a Priority or an Idempotency-Key that cannot be.
  Reply accept(const Request& request);

  std::vector<Route> routes();
  int waiting() { return store_.waiting(); }

 private:
  Reply get(const Request& request);
  Reply get_result(const Request& request, const std::string& id);
  Reply get_events(const Request& request, const std::string& id);
  Reply remove(const Request& request);

  JobStore& store_;
  JobRunner& runner_;
  const int max_streams_;
  std::atomic<int> streams_ = 0;
};

}  // namespace furnace
