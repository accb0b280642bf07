// A job as JSON: the answer of /v1/jobs, the events of its stream, the body of a webhook.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace furnace::api {

// How far the news of a job's end has come.
struct WebhookReport {
  std::string status;  // waiting (for the end), pending, delivered, failed; empty: nobody asked for it
  int attempts = 0;
  std::int64_t next_ms = 0;  // since the epoch, when it is tried next; 0: it is not
  std::string last_outcome;  // a status, or a word for what went wrong; empty: none yet
};

struct JobReport {
  std::string id;
  std::string_view status;  // queued, running, succeeded, failed, cancelled
  int priority = 0;
  std::int64_t created_ms = 0, started_ms = 0, finished_ms = 0;  // since the epoch; 0: not yet
  int frames_done = 0, frames = 0;                               // of a sequence; frames 0: not known
  std::string_view stage = {};                                   // bake, draw; empty: not known
  double share = 0;                                              // of the stage that is done; 0: not known
  std::string result;   // where the file stands; empty: there is none
  std::string problem;  // problem document; empty: it did not fail
  WebhookReport webhook = {};
};

std::string job_report_json(const JobReport& report);  // one line
// Of a finished job, one line: {"type": "job.STATUS", "timestamp": when it finished, "data": the report}.
std::string job_event_json(const JobReport& report);

}  // namespace furnace::api
