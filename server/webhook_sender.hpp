// The threads that tell others how their jobs ended.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "server/job_store.hpp"
#include "server/metrics.hpp"
#include "server/webhook.hpp"

namespace furnace {

struct WebhookConfig {
  int threads = 8;
  RetryPolicy retries = {};
  std::string keys_file;
};

// Threads: any. Owns: its threads and the keys; the others outlive it. When it ends, what is under way has two seconds left; what
// is not delivered then stays in the store.
class WebhookSender {
 public:
  // Errors: those of read_key_file and parse_webhook_keys.
  WebhookSender(JobStore& store, OutboundClient client, const WebhookConfig& config, Metrics& metrics);
  ~WebhookSender();

  // Something may have become due.
  void wake();
  // Reads the file of keys anew. Errors: as above; the old ones stay then.
  void reload();
  const AllowList& allowed() const { return client_.allowed(); }

 private:
  using Keys = std::vector<WebhookKey>;

  void run_thread();
  bool deliver_next();
  void deliver(const DeliveryWork& work);
  OutboundAnswer send(const DeliveryWork& work);

  JobStore& store_;
  const OutboundClient client_;
  const WebhookConfig config_;
  Metrics& metrics_;
  std::stop_source cancel_;
  std::mutex mutex_;  // of the members below
  std::shared_ptr<const Keys> keys_;
  std::condition_variable changed_;
  bool stopping_ = false;
  int under_way_ = 0;
  std::uint64_t wakes_ = 0;
  std::vector<std::thread> threads_;
};

}  // namespace furnace
