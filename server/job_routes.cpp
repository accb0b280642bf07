#include "server/job_routes.hpp"

#include <charconv>
#include <memory>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "api/stored_render.hpp"
#include "server/job_document.hpp"
#include "server/negotiation.hpp"
#include "server/preferences.hpp"
#include "server/webhook.hpp"

namespace furnace {
namespace {

constexpr std::string_view kJson = "application/json", kEvents = "/events";
constexpr std::string_view kWebhook = "Furnace-Webhook";
constexpr std::size_t kIdDigits = 32, kMostKeyBytes = 255;
constexpr int kMostPriority = 9;
constexpr std::chrono::milliseconds kLook{50}, kSignOfLife{10'000};

Reply reply_of(int status, const Job& job) {
  Reply reply{status, std::string(kJson), job_document(job) + "\n", {}};
  reply.with("Cache-Control", "no-store").with("Location", job_location(job.id));
  if (!is_finished(job.status)) reply.with("Retry-After", "1");
  return reply;
}

[[noreturn]] void fail_unknown() {
  fail(ErrorCode::kNotFound, "There is no such job. Finished ones are kept for a while only.");
}

// "/v1/jobs/ID" or "/v1/jobs/ID/WHAT".
struct Place {
  std::string id;
  std::string_view what;
};
Place place_of(const Request& request) {
  const std::string_view rest = std::string_view(request.path).substr(kJobs.size());
  const std::string_view id = rest.substr(0, kIdDigits);
  if (id.size() != kIdDigits || id.find_first_not_of("0123456789abcdef") != id.npos) fail_unknown();
  return {std::string(id), rest.substr(kIdDigits)};
}

// 0 to 9; the larger, the sooner.
int priority_of(const Request& request) {
  const std::string_view text = request.header("Furnace-Priority");
  if (text.empty()) return 0;
  int priority = -1;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), priority);
  if (fault != std::errc{} || end != text.data() + text.size() || priority < 0 || priority > kMostPriority)
    fail(ErrorCode::kInvalidRequest,
         fmt::format("Furnace-Priority is a number from 0 to {}.", kMostPriority));
  return priority;
}

// A string of a structured field: draft-ietf-httpapi-idempotency-key-header-07. Bare ones are taken, too.
std::optional<std::string> idempotency_key(const Request& request) {
  std::string_view text = request.header("Idempotency-Key");
  if (text.empty()) return std::nullopt;
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  if (text.empty() || text.size() > kMostKeyBytes)
    fail(ErrorCode::kInvalidRequest, fmt::format("Idempotency-Key has 1 to {} characters.", kMostKeyBytes));
  return std::string(text);
}

std::optional<Webhook> webhook_of(const Request& request, const AllowList& allowed) {
  const std::string_view text = request.header(kWebhook);
  if (text.empty()) return std::nullopt;
  if (allowed.empty())
    fail(ErrorCode::kUnprocessable,
         "This server calls no webhooks: its operator names the hosts it may call with webhook-allow.");
  const std::optional<OutboundUrl> url = parse_outbound_url(text);
  if (!url)
    fail(ErrorCode::kInvalidRequest,
         fmt::format("{} is an https URL with a plain host, without user and password.", kWebhook));
  if (!allowed.allows(*url))
    fail(ErrorCode::kUnprocessable,
         fmt::format("{}: this host is not among those that the server may call.", kWebhook));
  return Webhook{url->text, fmt::format("{}://{}:{}", url->scheme, url->host, url->port),
                 request.trace.text()};
}

// HTML, 9.2: server-sent events. One whenever something has changed, the last one when the job is finished.
class EventStream {
 public:
  EventStream(JobStore& store, std::string id, const Deadline& deadline, std::shared_ptr<void> place)
      : store_(store), id_(std::move(id)), deadline_(deadline), place_(std::move(place)) {}

  // Waits for the next piece. False: it was the last.
  bool next(std::string& piece) {
    const auto silent_until = Clock::now() + kSignOfLife;
    while (!deadline_.passed()) {
      const std::optional<Job> job = store_.find(id_);
      if (!job) return false;
      std::string text = job_document(*job);
      if (text != last_) {
        piece = fmt::format("event: {}\ndata: {}\n\n", name_of(job->status), text);
        last_ = std::move(text);
        return !is_finished(job->status);
      }
      if (Clock::now() > silent_until) {
        piece = ": waiting\n\n";
        return true;
      }
      std::this_thread::sleep_for(kLook);
    }
    return false;
  }

 private:
  JobStore& store_;
  const std::string id_;
  const Deadline deadline_;
  const std::shared_ptr<void> place_;
  std::string last_;
};

}  // namespace

bool JobDoors::is_asked_for(const Request& request) {
  const bool is_asked = parse_preferences(request.header("Prefer")).respond_async;
  if (!is_asked && !request.header(kWebhook).empty())
    fail(ErrorCode::kInvalidRequest,
         fmt::format("{} tells of a job's end: it goes with Prefer: respond-async.", kWebhook));
  return is_asked;
}

// Until it is finished, or the client would rather not wait any longer. It holds a thread, as a stream of events does, and
// does not wait where there is none.
Job JobDoors::wait_for(const Request& request, Job job, std::chrono::seconds longest) {
  const std::shared_ptr<void> place = take_stream();
  if (!place) return job;
  const auto end = std::min(request.deadline.end(), Clock::now() + longest);
  while (!is_finished(job.status) && Clock::now() < end && !request.deadline.cancelled()) {
    std::this_thread::sleep_for(kLook);
    std::optional<Job> now = store_.find(job.id);
    if (!now) break;
    job = *std::move(now);
  }
  return job;
}

// Null when there are as many as may be.
std::shared_ptr<void> JobDoors::take_stream() {
  if (++streams_ > max_streams_) {
    --streams_;
    return nullptr;
  }
  return {this, [](JobDoors* doors) { --doors->streams_; }};
}

Reply JobDoors::accept(const Request& request) {
  const JobRequest wanted{request.path,
                          std::string(request.header("Content-Type")),
                          std::string(request.header("Accept")),
                          request.body,
                          priority_of(request),
                          idempotency_key(request),
                          webhook_of(request, webhooks_),
                          request.client.name};
  const JobStore::Created created = store_.create(wanted, unix_time_ms());
  log::info("job.accepted", {{"id", created.job.id}, {"is_new", created.is_new}});
  if (created.is_new) runner_.wake();
  const auto wait = parse_preferences(request.header("Prefer")).wait;
  const Job job = wait ? wait_for(request, created.job, *wait) : created.job;
  Reply reply =
      wait && job.status == JobStatus::kSucceeded ? get_result(request, job.id) : reply_of(202, job);
  if (!created.is_new) reply.renders = 0;  // that was charged when it was new
  if (reply.status == 200) reply.with("Content-Location", fmt::format("{}{}{}", kJobs, job.id, kJobResult));
  return std::move(reply.with("Preference-Applied", "respond-async"));
}

// Of those that the client may see: its own, an administrator all.
std::optional<Job> JobDoors::find(const Request& request, const std::string& id) {
  std::optional<Job> job = store_.find(id);
  const Client& client = request.client;
  const bool may_see =
      job && (job->client.empty() || job->client == client.name || (client.scopes & scope::kAdmin) != 0);
  return may_see ? job : std::nullopt;
}

Reply JobDoors::get(const Request& request) {
  const Place place = place_of(request);
  if (place.what == kJobResult) return get_result(request, place.id);
  if (place.what == kEvents) return get_events(request, place.id);
  const std::optional<Job> job = place.what.empty() ? find(request, place.id) : std::nullopt;
  if (!job) fail_unknown();
  return reply_of(200, *job);
}

Reply JobDoors::get_result(const Request& request, const std::string& id) {
  const std::optional<Job> job = find(request, id);
  if (!job) fail_unknown();
  const std::optional<std::string> file = store_.result(id);
  if (!file)
    fail(ErrorCode::kNotFound, fmt::format("The job has no result: it is {}.", name_of(job->status)));
  api::StoredRender render = api::decode_stored_render(*file);
  const std::string etag = hash_bytes(std::as_bytes(std::span(render.bytes))).hex();
  const bool unchanged = etag_matches(request.header("If-None-Match"), etag);
  Reply reply =
      unchanged ? Reply{304, {}, {}, {}} : Reply{200, render.media_type, std::move(render.bytes), {}};
  return reply.with("ETag", '"' + etag + '"')
      .with("Furnace-Exposure-Ev", fmt::format("{}", render.exposure_ev))
      .with("Cache-Control", "private, max-age=31536000, immutable");
}

Reply JobDoors::get_events(const Request& request, const std::string& id) {
  if (!find(request, id)) fail_unknown();
  const std::shared_ptr<void> place = take_stream();
  if (!place) fail(ErrorCode::kOverloaded, "Too many streams of events at once; ask for the job itself.");
  Reply reply{200, "text/event-stream", {}, {}};
  reply.stream = [stream = std::make_shared<EventStream>(store_, id, request.deadline, place)](
                     std::string& piece) { return stream->next(piece); };
  return reply.with("Cache-Control", "no-store");
}

Reply JobDoors::remove(const Request& request) {
  const Place place = place_of(request);
  if (!place.what.empty() || !find(request, place.id) || !runner_.remove(place.id)) fail_unknown();
  return Reply{204, {}, {}, {}};
}

std::vector<Route> JobDoors::routes() {
  return {
      {"GET", "/v1/jobs/*", [this](const Request& request) { return get(request); }, scope::kRender},
      {"DELETE", "/v1/jobs/*", [this](const Request& request) { return remove(request); }, scope::kRender}};
}

}  // namespace furnace
