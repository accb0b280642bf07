#include "api/job_report.hpp"

#include <chrono>

#include <fmt/chrono.h>
#include <nlohmann/json.hpp>

namespace furnace::api {

namespace {

using OrderedJson = nlohmann::ordered_json;

// RFC 3339, to the millisecond.
std::string time_text(std::int64_t ms) {
  const std::chrono::sys_time<std::chrono::milliseconds> time{std::chrono::milliseconds(ms)};
  return fmt::format("{:%Y-%m-%dT%H:%M:}{:06.3f}Z", std::chrono::floor<std::chrono::seconds>(time),
                     double(ms % 60'000) / 1000);
}

OrderedJson members(const JobReport& report) {
  OrderedJson json = {{"id", report.id}, {"status", report.status}, {"priority", report.priority}};
  json["createdAt"] = time_text(report.created_ms);
  if (report.started_ms > 0) json["startedAt"] = time_text(report.started_ms);
  if (report.finished_ms > 0) json["finishedAt"] = time_text(report.finished_ms);
  if (report.frames > 0) json["progress"] = {{"framesDone", report.frames_done}, {"frames", report.frames}};
  if (!report.stage.empty()) json["progress"]["stage"] = report.stage;
  if (report.share > 0) json["progress"]["share"] = report.share;
  if (!report.result.empty()) json["result"] = report.result;
  if (!report.problem.empty()) json["problem"] = OrderedJson::parse(report.problem, nullptr, false);
  const WebhookReport& webhook = report.webhook;
  if (webhook.status.empty()) return json;
  json["webhook"] = {{"status", webhook.status}, {"attempts", webhook.attempts}};
  if (!webhook.last_outcome.empty()) json["webhook"]["lastOutcome"] = webhook.last_outcome;
  if (webhook.next_ms > 0) json["webhook"]["nextAttemptAt"] = time_text(webhook.next_ms);
  return json;
}

std::string text_of(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace

std::string job_report_json(const JobReport& report) {
  return text_of(members(report));
}

std::string job_event_json(const JobReport& report) {
  return text_of({{"type", "job." + std::string(report.status)},
                  {"timestamp", time_text(report.finished_ms)},
                  {"data", members(report)}});
}

}  // namespace furnace::api
