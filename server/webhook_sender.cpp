#include "server/webhook_sender.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "server/job_runner.hpp"
#include "server/key_lines.hpp"

namespace furnace {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongestWait{60'000}, kGrace{2000};
constexpr milliseconds kStoragePause{500};  // after a disk that failed

std::shared_ptr<const std::vector<WebhookKey>> read_keys(const std::string& file) {
  return std::make_shared<const std::vector<WebhookKey>>(parse_webhook_keys(read_key_file(file, true)));
}

// In [0, 1), another for each job and attempt.
double chance_of(const DeliveryWork& work) {
  const std::size_t hash = std::hash<std::string>()(fmt::format("{}.{}", work.id, work.attempts));
  return double(hash % 1000) / 1000;
}

std::string outcome_of(const OutboundAnswer& answer) {
  return answer.status > 0 ? std::to_string(answer.status) : std::string(name_of(answer.fault));
}

std::string_view metric_of(Verdict::Kind kind) {
  if (kind == Verdict::Kind::kDelivered) return "delivered";
  return kind == Verdict::Kind::kAgain ? "again" : "failed";
}

}  // namespace

WebhookSender::WebhookSender(JobStore& store, OutboundClient client, const WebhookConfig& config,
                             Metrics& metrics)
    : store_(store),
      client_(std::move(client)),
      config_(config),
      metrics_(metrics),
      keys_(read_keys(config.keys_file)) {
  for (int i = 0; i < config.threads; ++i) threads_.emplace_back([this] { run_thread(); });
}

WebhookSender::~WebhookSender() {
  {
    std::unique_lock lock(mutex_);
    stopping_ = true;
    changed_.notify_all();
    changed_.wait_for(lock, kGrace, [this] { return under_way_ == 0; });
  }
  cancel_.request_stop();
  for (std::thread& thread : threads_) thread.join();
}

void WebhookSender::wake() {
  {
    const std::lock_guard lock(mutex_);
    ++wakes_;
  }
  changed_.notify_one();
}

void WebhookSender::reload() {
  auto keys = read_keys(config_.keys_file);
  const std::lock_guard lock(mutex_);
  keys_ = std::move(keys);
}

void WebhookSender::run_thread() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const std::uint64_t wakes = wakes_;
    ++under_way_;
    lock.unlock();
    bool worked = false;
    milliseconds wait = kStoragePause;
    try {
      worked = deliver_next();
      const std::int64_t next_ms = store_.next_delivery_ms().value_or(INT64_MAX) - unix_time_ms();
      wait = std::clamp(milliseconds(next_ms), milliseconds(1), kLongestWait);
    } catch (const Error& error) {
      log::error("webhooks.failed", {{"message", error.message}, {"detail", error.detail}});
    } catch (const std::exception& error) {
      log::error("webhooks.failed", {{"detail", error.what()}});
    }
    lock.lock();
    if (--under_way_ == 0 && stopping_) changed_.notify_all();
    if (!worked) changed_.wait_for(lock, wait, [&] { return stopping_ || wakes != wakes_; });
  }
}

// False when nothing was due.
bool WebhookSender::deliver_next() {
  const std::optional<DeliveryWork> work = store_.begin_delivery(unix_time_ms());
  if (!work) return false;
  const log::RequestScope scope({work->id, {}, {}});
  deliver(*work);
  return true;
}

void WebhookSender::deliver(const DeliveryWork& work) {
  const OutboundAnswer answer = send(work);
  if (answer.fault == OutboundFault::kCancelled) {
    store_.put_back_delivery(work.id);
    return;
  }
  const std::int64_t now_ms = unix_time_ms();
  const Verdict verdict = judge(answer, config_.retries, work.attempts, work.due_ms, now_ms, chance_of(work));
  metrics_.webhook_attempts.Add({{"result", std::string(metric_of(verdict.kind))}}).Increment();
  log::info("webhook.attempt", {{"id", work.id},
                                {"origin", work.webhook.origin},
                                {"attempt", work.attempts},
                                {"outcome", outcome_of(answer)},
                                {"result", metric_of(verdict.kind)},
                                {"detail", answer.detail}});
  using Kind = Verdict::Kind;
  if (verdict.kind == Kind::kAgain)
    store_.try_delivery_again(work.id, verdict.next_ms, outcome_of(answer));
  else
    store_.finish_delivery(
        work.id, verdict.kind == Kind::kDelivered ? DeliveryStatus::kDelivered : DeliveryStatus::kFailed,
        outcome_of(answer));
}

OutboundAnswer WebhookSender::send(const DeliveryWork& work) {
  const std::optional<OutboundUrl> url = parse_outbound_url(work.webhook.url);
  if (!url) {
    OutboundAnswer answer;
    answer.fault = OutboundFault::kRefused;
    return answer;
  }
  std::shared_ptr<const Keys> keys;
  {
    const std::lock_guard lock(mutex_);
    keys = keys_;
  }
  const std::string id = webhook_id(work.id);
  // The calendar's, for the receiver compares it with its own.
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const std::int64_t now_s = std::chrono::duration_cast<std::chrono::seconds>(now).count();
  OutboundRequest request{*url};
  request.headers = {{"Content-Type", "application/json"},
                     {"webhook-id", id},
                     {"webhook-timestamp", std::to_string(now_s)},
                     {"webhook-signature", webhook_signature(*keys, id, now_s, work.body)}};
  if (!work.webhook.traceparent.empty())
    request.headers.emplace_back("traceparent", work.webhook.traceparent);
  request.body = work.body;
  return client_.send(request, Deadline(std::chrono::hours(1), cancel_.get_token()));
}

}  // namespace furnace
