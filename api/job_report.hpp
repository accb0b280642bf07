// A job as JSON: the answer of /v1/jobs and the events of its stream.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace furnace::api {

struct JobReport {
  std::string id;
  std::string_view status;  // queued, running, succeeded, failed, cancelled
  int priority = 0;
  std::int64_t created_ms = 0, started_ms = 0, finished_ms = 0;  // since the epoch; 0: not yet
  int frames_done = 0, frames = 0;                               // of a sequence; frames 0: not known
  std::string result;   // where the file stands; empty: there is none
  std::string problem;  // problem document; empty: it did not fail
};

std::string job_report_json(const JobReport& report);  // one line

}  // namespace furnace::api
