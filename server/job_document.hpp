// A job as others are told of it: the answer of /v1/jobs, the events of its stream, the body of its webhook.
#pragma once

#include <string>
#include <string_view>

#include "server/job_store.hpp"

namespace furnace {

inline constexpr std::string_view kJobs = "/v1/jobs/", kJobResult = "/result";

std::string job_location(std::string_view id);  // "/v1/jobs/ID"
std::string job_document(const Job& job);       // JSON, one line

// Of a finished job: {"type": "job.succeeded", "timestamp": when it finished, "data": the document without its delivery}.
std::string webhook_body(const Job& job);

}  // namespace furnace
