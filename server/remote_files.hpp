// Files of other servers that requests refer to by URL.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <semaphore>
#include <string>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/blob.hpp"
#include "renderer/base/budget_cache.hpp"
#include "renderer/base/deadline.hpp"
#include "server/metrics.hpp"
#include "server/outbound_client.hpp"

namespace furnace {

struct RemoteConfig {
  std::int64_t max_request_bytes = 256ll << 20;
  int max_fetches = 8;                          // at once
  std::chrono::milliseconds freshness{60'000};  // not asked for again within
  std::int64_t cache_bytes = 256ll << 20;
};

// Threads: any; a fetch runs on its caller's thread. Owns: a cache of what was fetched; Metrics outlives it.
class RemoteFiles {
 public:
  RemoteFiles(OutboundClient client, const RemoteConfig& config, Metrics& metrics);

  // What one request may refer to, within its time and bytes. A sibling must have the origin of the file that names it, and
  // lie in its folder or below.
  // Errors: kUnprocessable for what is no URL, or one that is not allowed or leads where it may not; kTooLarge; kOverloaded
  // when too many fetches wait; kBadGateway for a server that cannot be reached or answers with no file; kDeadlineExceeded.
  // No message tells an address.
  AssetResolver::RemoteFiles of_request(const Deadline& deadline);

 private:
  struct Fetched {
    std::optional<Blob> file;  // none: the server has no such file
    std::string etag;
  };

  std::optional<Blob> read(const std::string& url, const std::string& relative, const Deadline& deadline);
  std::shared_ptr<const Fetched> fetch(const OutboundUrl& url, const Deadline& deadline);
  Fetched ask(const OutboundUrl& url, const std::shared_ptr<const Fetched>& before, const Deadline& deadline);

  const OutboundClient client_;
  const RemoteConfig config_;
  Metrics& metrics_;
  std::counting_semaphore<> places_;
  BudgetCache<Fetched> fetched_;  // by URL and time, in steps of freshness
};

}  // namespace furnace
