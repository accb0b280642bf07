#include "server/job_document.hpp"

#include <fmt/format.h>

#include "api/job_report.hpp"

namespace furnace {
namespace {

api::JobReport report_of(const Job& job) {
  api::JobReport report;
  report.id = job.id;
  report.status = name_of(job.status);
  report.priority = job.priority;
  report.created_ms = job.created_ms;
  report.started_ms = job.started_ms;
  report.finished_ms = job.finished_ms;
  report.frames_done = job.progress.frames_done;
  report.frames = job.progress.frames;
  report.stage = job.progress.stage;
  report.share = job.progress.share;
  report.problem = job.problem;
  if (job.status == JobStatus::kSucceeded) report.result = job_location(job.id) + std::string(kJobResult);
  return report;
}

}  // namespace

std::string job_location(std::string_view id) {
  return fmt::format("{}{}", kJobs, id);
}

std::string job_document(const Job& job) {
  api::JobReport report = report_of(job);
  if (job.delivery) {
    const bool is_pending = job.delivery->status == DeliveryStatus::kPending;
    report.webhook = {std::string(name_of(job.delivery->status)), job.delivery->attempts,
                      is_pending ? job.delivery->next_ms : 0, job.delivery->last_outcome};
  }
  return api::job_report_json(report);
}

std::string webhook_body(const Job& job) {
  return api::job_event_json(report_of(job));
}

}  // namespace furnace
