// Every metric is a member here, so this header is the list.
#pragma once

#include <mutex>
#include <string>
#include <string_view>

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "renderer/decode/process_pool.hpp"
#include "renderer/renderer.hpp"
#include "server/asset_store.hpp"

namespace furnace {

// Threads: any. Owns: all metrics.
class Metrics {
 private:
  prometheus::Registry registry_;  // first: the members below live in it

 public:
  explicit Metrics(std::string_view build);

  prometheus::Family<prometheus::Counter>& requests;           // route, status
  prometheus::Family<prometheus::Counter>& statuses;           // status
  prometheus::Family<prometheus::Counter>& errors;             // type
  prometheus::Family<prometheus::Histogram>& request_seconds;  // route
  prometheus::Family<prometheus::Counter>& client_requests;    // client, status
  prometheus::Gauge& requests_in_flight;
  prometheus::Counter& connections_refused;
  prometheus::Counter& clients_gone;

  prometheus::Gauge& seats;
  prometheus::Gauge& seats_in_use;
  prometheus::Gauge& queue_length;
  prometheus::Gauge& jobs_waiting;
  prometheus::Gauge& webhooks_unfinished;
  prometheus::Family<prometheus::Counter>& webhook_attempts;  // result
  prometheus::Family<prometheus::Counter>& remote_fetches;    // result
  prometheus::Counter& remote_bytes;

  prometheus::Counter& renders;
  prometheus::Counter& not_modified;
  prometheus::Counter& pixels;
  prometheus::Family<prometheus::Counter>& notes;            // code
  prometheus::Family<prometheus::Histogram>& stage_seconds;  // span
  prometheus::Family<prometheus::Counter>& cache_lookups;    // cache, result
  prometheus::Gauge& ready;
  prometheus::Gauge& probes_are_alike;
  prometheus::Counter& ibl_cache_hits;
  prometheus::Counter& ibl_cache_misses;
  prometheus::Gauge& ibl_cache_bytes;

  prometheus::Gauge& decoders;
  prometheus::Counter& decoder_jobs;
  prometheus::Counter& decoder_crashes;
  prometheus::Counter& decoder_timeouts;
  prometheus::Counter& decoder_starts;

  prometheus::Gauge& contexts;
  prometheus::Gauge& contexts_busy_percent;
  prometheus::Family<prometheus::Gauge>& context_callers;     // context
  prometheus::Family<prometheus::Gauge>& gpu_bytes;           // context
  prometheus::Family<prometheus::Counter>& context_renewals;  // reason

  prometheus::Gauge& assets;
  prometheus::Gauge& asset_bytes;
  prometheus::Counter& asset_uploads;

  void observe_request(std::string_view route, int status, double seconds);
  void observe_error(std::string_view type);
  void observe_client(const std::string& client, int status);  // a key's name: as many as there are keys
  void observe_stages(const StageTimes& times);
  void observe_decoders(const decode::PoolStats& stats);
  void observe_renderer(const RendererStats& stats);
  void observe_assets(const AssetStore::Stats& stats);

  std::string text() const;  // Prometheus text format

 private:
  std::mutex counting_;  // what others have counted is taken over
};

}  // namespace furnace
