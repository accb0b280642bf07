// Webhooks: keys, signatures, when to try again, and the list of those that are due.
#include <filesystem>
#include <functional>

#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "api/document.hpp"
#include "server/job_document.hpp"
#include "server/webhook.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using Kind = Verdict::Kind;

std::string refusal(const std::function<void()>& what) {
  try {
    what();
  } catch (const Error& error) {
    std::string text = error.message;
    for (const Problem& problem : error.problems) text += "\n" + problem.pointer + " " + problem.message;
    return text;
  }
  return {};
}

// The vector of the convention's reference libraries; openssl dgst -sha256 -mac HMAC makes the same.
TEST(Webhook, ASignatureForOtherImplementations) {
  const auto keys = parse_webhook_keys("svix:whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw\n");
  EXPECT_EQ(webhook_signature(keys, "msg_p5jXN8AQM9LWM0D4loKWxJek", 1614265330, R"({"test": 2432232314})"),
            "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
  EXPECT_EQ(webhook_secret_text(keys[0].secret), "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw");
}

TEST(Webhook, AllKeysSign) {
  const std::string old_line = "old:" + webhook_secret_text(std::string(24, '\xfb')),
                    new_line = "new:" + webhook_secret_text(std::string(64, '\x7f'));
  const auto both = parse_webhook_keys("# in use until June\n" + old_line + "\r\n\n" + new_line);
  const auto sign = [](const std::vector<WebhookKey>& keys) {
    return webhook_signature(keys, "msg_1", 5, "{}");
  };
  EXPECT_EQ(sign(both), sign(parse_webhook_keys(old_line)) + " " + sign(parse_webhook_keys(new_line)));
}

TEST(Webhook, KeysThatCannotBe) {
  const std::string good = webhook_secret_text(std::string(24, 'a'));
  EXPECT_NE(refusal([&] { parse_webhook_keys(""); }), "");
  EXPECT_THAT(
      refusal([&] { parse_webhook_keys("a:" + good + "\na:" + webhook_secret_text(std::string(24, 'b'))); }),
      HasSubstr("line 2"));
  for (const std::string& line :
       {std::string("a"), good, "a:" + good + ":x", "a b:" + good, std::string("a:whsec_"),
        "a:" + webhook_secret_text(std::string(23, 's')), "a:" + webhook_secret_text(std::string(65, 's')),
        "a:whsec_" + std::string(40, '!'), "a:whsec_" + std::string(32, '-')}) {
    const std::string told = refusal([&] { parse_webhook_keys(line); });
    EXPECT_THAT(told, HasSubstr("line 1")) << line;
    EXPECT_THAT(told, Not(HasSubstr("sssss"))) << "a secret in a message";
  }
  std::string many;
  for (int i = 0; i < 9; ++i) many += std::to_string(i) + ":" + good + "\n";
  EXPECT_THAT(refusal([&] { parse_webhook_keys(many); }), HasSubstr("line 9"));
}

OutboundAnswer answered(int status, std::int64_t retry_after_s = 0) {
  OutboundAnswer answer;
  answer.status = status;
  answer.retry_after_s = retry_after_s;
  return answer;
}
OutboundAnswer faulted(OutboundFault fault, int status = 0) {
  OutboundAnswer answer;
  answer.fault = fault;
  answer.status = status;
  return answer;
}

TEST(Webhook, WhatIsTriedAgain) {
  const auto kind = [](const OutboundAnswer& answer) { return judge(answer, {}, 1, 0, 0, 0).kind; };
  for (const int status : {200, 201, 202, 204, 299})
    EXPECT_EQ(kind(answered(status)), Kind::kDelivered) << status;
  for (const int status : {408, 429, 500, 502, 503, 504, 599})
    EXPECT_EQ(kind(answered(status)), Kind::kAgain) << status;
  for (const int status : {301, 302, 307, 400, 401, 403, 404, 410, 422})
    EXPECT_EQ(kind(answered(status)), Kind::kFailed) << status;
  for (const OutboundFault fault :
       {OutboundFault::kUnreachable, OutboundFault::kTimeout, OutboundFault::kBadAnswer})
    EXPECT_EQ(kind(faulted(fault)), Kind::kAgain);
  EXPECT_EQ(kind(faulted(OutboundFault::kRefused)), Kind::kFailed);
  EXPECT_EQ(kind(faulted(OutboundFault::kTooLarge, 200)), Kind::kDelivered) << "nobody reads what it says";
  EXPECT_EQ(kind(faulted(OutboundFault::kTooLarge, 500)), Kind::kAgain);
}

TEST(Webhook, WhenItIsTriedAgain) {
  RetryPolicy policy;
  policy.max_attempts = 5;
  policy.first_pause_ms = 1000;
  policy.most_pause_ms = 60'000;
  policy.max_age_ms = 1'000'000;
  const auto pause = [&](int attempts, std::int64_t asked_s = 0, double chance = 0) {
    const Verdict verdict = judge(answered(503, asked_s), policy, attempts, 500, 7000, chance);
    return verdict.kind == Kind::kAgain ? verdict.next_ms - 7000 : -1;
  };
  EXPECT_EQ(pause(1), 1000);
  EXPECT_EQ(pause(2), 3000);
  EXPECT_EQ(pause(3), 9000);
  EXPECT_EQ(pause(4), 27'000);
  EXPECT_EQ(pause(5), -1) << "that was the last";
  EXPECT_EQ(pause(1, 0, 0.5), 1100);
  EXPECT_EQ(pause(1, 20), 20'000) << "Retry-After is waited for";
  EXPECT_EQ(pause(3, 2), 9000) << "but not less than without it";
  EXPECT_EQ(pause(1, 1'000'000'000), 60'000) << "and not for ever";
  policy.max_attempts = 1000;
  EXPECT_EQ(pause(999), 60'000);
  EXPECT_EQ(judge(answered(503), policy, 1, 0, 999'001, 0).kind, Kind::kFailed) << "too old by then";
  EXPECT_EQ(judge(answered(503), policy, 1, 0, 999'000, 0).kind, Kind::kAgain);
}

class DeliveryTest : public ::testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  static JobRequest request(const std::string& host = "a", std::string body = "{}") {
    JobRequest request{"/v1/renders", "application/json", "*/*", std::move(body), 0, {}, {}};
    request.webhook = Webhook{"https://" + host + "/hook", "https://" + host + ":443", "trace"};
    return request;
  }
  // A job that has ended at `now_ms`.
  static std::string ended(JobStore& store, const std::string& host, std::int64_t now_ms) {
    const std::string id = store.create(request(host), now_ms).job.id;
    store.begin(now_ms);
    store.succeed(id, "result", now_ms);
    return id;
  }

  fs::path folder_ = fs::temp_directory_path() / ("delivery_test." + std::to_string(::getpid()));
};

TEST_F(DeliveryTest, FromTheJobsEndToItsReceiver) {
  JobStore store({}, {});
  const std::string id = store.create(request(), 1000).job.id;
  EXPECT_EQ(store.find(id)->delivery->status, DeliveryStatus::kWaiting);
  EXPECT_FALSE(store.begin_delivery(9000)) << "the job is not over";
  EXPECT_FALSE(store.next_delivery_ms());
  EXPECT_EQ(store.unfinished_deliveries(), 1);
  store.begin(2000);
  store.succeed(id, "result", 3000);
  EXPECT_EQ(store.next_delivery_ms(), 3000);
  EXPECT_FALSE(store.begin_delivery(2999));
  const auto work = store.begin_delivery(3000);
  ASSERT_TRUE(work);
  EXPECT_EQ(work->id, id);
  EXPECT_EQ(work->webhook.url, "https://a/hook");
  EXPECT_EQ(work->webhook.traceparent, "trace");
  EXPECT_EQ(work->attempts, 1);
  EXPECT_EQ(work->due_ms, 3000);
  const auto body = api::Document::parse(work->body, {});
  EXPECT_EQ(body.root()["type"].text(), "job.succeeded");
  EXPECT_EQ(body.root()["timestamp"].text(), "1970-01-01T00:00:03.000Z");
  EXPECT_EQ(body.root()["data"]["id"].text(), id);
  EXPECT_EQ(body.root()["data"]["result"].text(), "/v1/jobs/" + id + "/result");
  EXPECT_FALSE(body.root()["data"]["webhook"]);
  EXPECT_FALSE(store.begin_delivery(9000)) << "it is under way";

  store.try_delivery_again(id, 8000, "503");
  const auto told = api::Document::parse(job_document(*store.find(id)), {});
  EXPECT_EQ(told.root()["webhook"]["status"].text(), "pending");
  EXPECT_EQ(told.root()["webhook"]["lastOutcome"].text(), "503");
  EXPECT_EQ(told.root()["webhook"]["nextAttemptAt"].text(), "1970-01-01T00:00:08.000Z");
  EXPECT_FALSE(store.begin_delivery(7999));
  const auto again = store.begin_delivery(8000);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->attempts, 2);
  EXPECT_EQ(again->body, work->body);
  store.finish_delivery(id, DeliveryStatus::kDelivered, "204");
  EXPECT_EQ(store.find(id)->delivery->status, DeliveryStatus::kDelivered);
  EXPECT_FALSE(store.begin_delivery(1'000'000));
  EXPECT_EQ(store.unfinished_deliveries(), 0);
}

TEST_F(DeliveryTest, FailuresAndCancellationsAreTold) {
  JobStore store({}, {});
  const std::string failing = store.create(request(), 0).job.id;
  store.begin(0);
  store.fail(failing, R"({"status": 422})", 1);
  EXPECT_THAT(store.begin_delivery(1)->body, HasSubstr(R"("job.failed")"));
  const std::string cancelled = store.create(request(), 0).job.id;
  store.remove(cancelled, 2);
  EXPECT_THAT(store.begin_delivery(2)->body, HasSubstr(R"("job.cancelled")"));
}

TEST_F(DeliveryTest, WhatWasUnderWayWhenTheProcessDiedIsTriedAgain) {
  std::string id;
  {
    JobStore store(folder_, {});
    id = ended(store, "a", 10);
    ASSERT_TRUE(store.begin_delivery(10));
  }
  JobStore store(folder_, {});
  const auto work = store.begin_delivery(10);
  ASSERT_TRUE(work);
  EXPECT_EQ(work->id, id);
  EXPECT_EQ(work->attempts, 2);
  store.put_back_delivery(id);
  EXPECT_EQ(store.find(id)->delivery->attempts, 1);
}

TEST_F(DeliveryTest, AJobThatKillsTheProcessIsToldOf) {
  for (int life = 0; life < 3; ++life) {
    JobStore store(folder_, {});
    if (life == 0) store.create(request(), 0);
    ASSERT_TRUE(store.begin(0)) << life;
  }
  JobStore store(folder_, {});
  EXPECT_THAT(store.begin_delivery(0)->body, HasSubstr(R"("job.failed")"));
}

TEST_F(DeliveryTest, OneHostTakesTwoPlacesAtMost) {
  JobStore store({}, {});
  for (int i = 0; i < 4; ++i) ended(store, "dead", 1);
  const std::string other = ended(store, "alive", 2);
  const auto first = store.begin_delivery(9), second = store.begin_delivery(9),
             third = store.begin_delivery(9);
  EXPECT_EQ(first->webhook.origin, "https://dead:443");
  EXPECT_EQ(second->webhook.origin, "https://dead:443");
  ASSERT_TRUE(third);
  EXPECT_EQ(third->id, other);
  EXPECT_FALSE(store.begin_delivery(9));
  EXPECT_FALSE(store.next_delivery_ms()) << "nothing to wait for but an end";
  store.try_delivery_again(first->id, 100, "timeout");
  EXPECT_EQ(store.next_delivery_ms(), 1);
  EXPECT_EQ(store.begin_delivery(9)->webhook.origin, "https://dead:443");
}

TEST_F(DeliveryTest, NewsOutliveTheJobButNotItsRemoval) {
  JobLimits limits;
  limits.keep_ms = 1000;
  JobStore store({}, limits);
  const std::string old = ended(store, "a", 0);
  store.trim(5000);
  EXPECT_FALSE(store.find(old));
  const auto work = store.begin_delivery(5000);
  ASSERT_TRUE(work);
  EXPECT_EQ(work->id, old);
  store.finish_delivery(old, DeliveryStatus::kDelivered, "200");
  const std::string removed = ended(store, "a", 5000);
  store.remove(removed, 5000);
  EXPECT_FALSE(store.begin_delivery(6000));
  EXPECT_EQ(store.unfinished_deliveries(), 0);
}

TEST_F(DeliveryTest, AsManyAsMayWait) {
  JobLimits limits;
  limits.max_deliveries = 1;
  JobStore store({}, limits);
  store.create(request(), 0);
  EXPECT_THAT(refusal([&] { store.create(request(), 0); }), HasSubstr("webhooks"));
  JobRequest quiet = request();
  quiet.webhook.reset();
  store.create(quiet, 0);
}

TEST_F(DeliveryTest, AnotherWebhookIsAnotherRequest) {
  JobStore store({}, {});
  JobRequest first = request("a"), second = request("b");
  first.idempotency_key = second.idempotency_key = "k";
  store.create(first, 0);
  EXPECT_FALSE(store.create(first, 0).is_new);
  EXPECT_NE(refusal([&] { store.create(second, 0); }), "");
}

}  // namespace
}  // namespace furnace
