#include "server/metrics.hpp"

#include <prometheus/text_serializer.h>

namespace furnace {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;

// Seconds: from a cached tiny picture to the longest time a request may have.
const prometheus::Histogram::BucketBoundaries kSecondsBuckets = {
    0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60};

constexpr double kSecondsPerMs = 1e-3;

void catch_up(prometheus::Counter& counter, std::int64_t count) {
  counter.Increment(double(count) - counter.Value());
}

}  // namespace

Metrics::Metrics(std::string_view build)
    : requests(BuildCounter().Name("furnace_requests_total").Help("Answered requests").Register(registry_)),
      statuses(BuildCounter()
                   .Name("furnace_status_codes_total")
                   .Help("Answers by status, those of no route too")
                   .Register(registry_)),
      errors(
          BuildCounter().Name("furnace_errors_total").Help("Problem documents by type").Register(registry_)),
      request_seconds(BuildHistogram()
                          .Name("furnace_request_duration_seconds")
                          .Help("From a complete request to its reply, the wait for a seat included")
                          .Register(registry_)),
      client_requests(BuildCounter()
                          .Name("furnace_client_requests_total")
                          .Help("Requests with an API key, by its name")
                          .Register(registry_)),
      requests_in_flight(BuildGauge()
                             .Name("furnace_requests_in_progress")
                             .Help("Requests being answered")
                             .Register(registry_)
                             .Add({})),
      connections_refused(BuildCounter()
                              .Name("furnace_connections_refused_total")
                              .Help("Connections refused because too many were waiting")
                              .Register(registry_)
                              .Add({})),
      clients_gone(BuildCounter()
                       .Name("furnace_clients_gone_total")
                       .Help("Requests cancelled because the client went away")
                       .Register(registry_)
                       .Add({})),
      seats(BuildGauge()
                .Name("furnace_render_pool_size")
                .Help("Renders that may be worked on at once")
                .Register(registry_)
                .Add({})),
      seats_in_use(BuildGauge()
                       .Name("furnace_render_pool_active")
                       .Help("Renders worked on")
                       .Register(registry_)
                       .Add({})),
      queue_length(BuildGauge()
                       .Name("furnace_render_pool_waiting")
                       .Help("Renders waiting")
                       .Register(registry_)
                       .Add({})),
      jobs_waiting(
          BuildGauge().Name("furnace_jobs_waiting").Help("Jobs not yet begun").Register(registry_).Add({})),
      webhooks_unfinished(BuildGauge()
                              .Name("furnace_webhooks_unfinished")
                              .Help("Webhooks not yet delivered, those of unfinished jobs too")
                              .Register(registry_)
                              .Add({})),
      webhook_attempts(BuildCounter()
                           .Name("furnace_webhook_attempts_total")
                           .Help("Attempts to deliver a webhook: delivered, again, failed")
                           .Register(registry_)),
      remote_fetches(BuildCounter()
                         .Name("furnace_remote_fetches_total")
                         .Help("Files asked for at other servers, by what came of it")
                         .Register(registry_)),
      remote_bytes(BuildCounter()
                       .Name("furnace_remote_bytes_total")
                       .Help("Bytes of the files that other servers gave")
                       .Register(registry_)
                       .Add({})),
      renders(
          BuildCounter().Name("furnace_renders_total").Help("Pictures drawn").Register(registry_).Add({})),
      not_modified(BuildCounter()
                       .Name("furnace_renders_not_modified_total")
                       .Help("Renders answered 304 without drawing")
                       .Register(registry_)
                       .Add({})),
      pixels(BuildCounter()
                 .Name("furnace_pixels_total")
                 .Help("Pixels of all pictures drawn")
                 .Register(registry_)
                 .Add({})),
      notes(BuildCounter()
                .Name("furnace_notes_total")
                .Help("What could not be drawn as asked, by code")
                .Register(registry_)),
      stage_seconds(BuildHistogram()
                        .Name("furnace_request_span_duration_seconds")
                        .Help("Time of a render's stages")
                        .Register(registry_)),
      cache_lookups(
          BuildCounter().Name("furnace_cache_lookups_total").Help("Hits and misses").Register(registry_)),
      ready(BuildGauge()
                .Name("furnace_ready")
                .Help("1 when the last probe picture was right")
                .Register(registry_)
                .Add({})),
      probes_are_alike(
          BuildGauge()
              .Name("furnace_determinism_probe_ok")
              .Help("1 while every probe picture, on every GL context, has the pixels of the first")
              .Register(registry_)
              .Add({})),
      ibl_cache_hits(BuildCounter()
                         .Name("furnace_ibl_cache_hits_total")
                         .Help("Environments whose maps were in memory, or just being baked")
                         .Register(registry_)
                         .Add({})),
      ibl_cache_misses(BuildCounter()
                           .Name("furnace_ibl_cache_misses_total")
                           .Help("Environments whose maps were read from the disk or baked")
                           .Register(registry_)
                           .Add({})),
      ibl_cache_bytes(BuildGauge()
                          .Name("furnace_ibl_cache_bytes")
                          .Help("Maps of environments in memory")
                          .Register(registry_)
                          .Add({})),
      decoders(BuildGauge()
                   .Name("furnace_decoders")
                   .Help("Child processes that decode")
                   .Register(registry_)
                   .Add({})),
      decoder_jobs(BuildCounter()
                       .Name("furnace_decoder_jobs_total")
                       .Help("Files that child processes decoded, or failed to")
                       .Register(registry_)
                       .Add({})),
      decoder_crashes(BuildCounter()
                          .Name("furnace_decoder_crashes_total")
                          .Help("Children that ended, or gave an answer without sense, over a file")
                          .Register(registry_)
                          .Add({})),
      decoder_timeouts(
          BuildCounter()
              .Name("furnace_decoder_timeouts_total")
              .Help("Children that were killed because the time of the file or the request was over")
              .Register(registry_)
              .Add({})),
      decoder_starts(BuildCounter()
                         .Name("furnace_decoder_starts_total")
                         .Help("Child processes started")
                         .Register(registry_)
                         .Add({})),
      contexts(BuildGauge().Name("furnace_workers").Help("GL contexts").Register(registry_).Add({})),
      contexts_busy_percent(BuildGauge()
                                .Name("furnace_workers_utilization")
                                .Help("GL contexts that draw or are about to, percent")
                                .Register(registry_)
                                .Add({})),
      context_callers(BuildGauge()
                          .Name("furnace_context_callers")
                          .Help("Renders that draw on a GL context, or will")
                          .Register(registry_)),
      gpu_bytes(BuildGauge()
                    .Name("furnace_gpu_memory_bytes")
                    .Help("Meshes, textures and environments on a GL context")
                    .Register(registry_)),
      context_renewals(BuildCounter()
                           .Name("furnace_worker_recycles_total")
                           .Help("GL contexts made anew, by reason")
                           .Register(registry_)),
      assets(BuildGauge().Name("furnace_assets").Help("Uploaded files kept").Register(registry_).Add({})),
      asset_bytes(BuildGauge()
                      .Name("furnace_asset_bytes")
                      .Help("Bytes of the uploaded files, each 4096 at least")
                      .Register(registry_)
                      .Add({})),
      asset_uploads(BuildCounter()
                        .Name("furnace_asset_uploads_total")
                        .Help("Uploads kept, or found to be there already")
                        .Register(registry_)
                        .Add({})) {
  BuildGauge()
      .Name("furnace_build_info")
      .Help("Always 1; the label says which build this is")
      .Register(registry_)
      .Add({{"build", std::string(build)}})
      .Set(1);
}

void Metrics::observe_request(std::string_view route, int status, double seconds) {
  requests.Add({{"route", std::string(route)}, {"status", std::to_string(status)}}).Increment();
  statuses.Add({{"status", std::to_string(status)}}).Increment();
  request_seconds.Add({{"route", std::string(route)}}, kSecondsBuckets).Observe(seconds);
}

void Metrics::observe_error(std::string_view type) {
  errors.Add({{"type", std::string(type)}}).Increment();
}

void Metrics::observe_client(const std::string& client, int status) {
  client_requests.Add({{"client", client}, {"status", std::to_string(status)}}).Increment();
}

void Metrics::observe_stages(const StageTimes& times) {
  const auto stage = [this](const char* name, double ms) {
    stage_seconds.Add({{"span", name}}, kSecondsBuckets).Observe(ms * kSecondsPerMs);
  };
  const auto lookup = [this](const char* cache, bool hit) {
    cache_lookups.Add({{"cache", cache}, {"result", hit ? "hit" : "miss"}}).Increment();
  };
  stage("queue", times.queue_ms);
  stage("decode", times.decode_ms);
  stage("bake", times.bake_ms);
  stage("upload", times.upload_ms);
  stage("draw", times.draw_ms);
  stage("readback", times.readback_ms);
  stage("encode", times.encode_ms);
  lookup("scene", times.decode_hit);
  lookup("bake", times.bake_hit);
  lookup("gpu", times.upload_hit);
}

void Metrics::observe_assets(const AssetStore::Stats& stats) {
  const std::lock_guard lock(counting_);
  assets.Set(double(stats.assets));
  asset_bytes.Set(double(stats.bytes));
  catch_up(asset_uploads, stats.uploads);
}

void Metrics::observe_decoders(const decode::PoolStats& stats) {
  const std::lock_guard lock(counting_);
  decoders.Set(stats.processes);
  catch_up(decoder_jobs, stats.jobs);
  catch_up(decoder_crashes, stats.crashes);
  catch_up(decoder_timeouts, stats.timeouts);
  catch_up(decoder_starts, stats.starts);
}

void Metrics::observe_renderer(const RendererStats& stats) {
  const std::lock_guard lock(counting_);
  const ContextPoolStats& pool = stats.contexts;
  int busy = 0;
  for (std::size_t i = 0; i < pool.callers.size(); ++i) {
    const prometheus::Labels context = {{"context", std::to_string(i)}};
    context_callers.Add(context).Set(pool.callers[i]);
    gpu_bytes.Add(context).Set(double(pool.gpu_bytes[i]));
    if (pool.callers[i] > 0) ++busy;
  }
  contexts.Set(double(pool.callers.size()));
  contexts_busy_percent.Set(100.0 * busy / double(pool.callers.size()));
  for (std::size_t i = 0; i < kRenewalReasons; ++i) {
    const std::string reason(name_of(RenewalReason(i)));
    catch_up(context_renewals.Add({{"reason", reason}}), pool.renewals[i]);
  }
  catch_up(ibl_cache_hits, stats.baked.hits + stats.baked.joins);
  catch_up(ibl_cache_misses, stats.baked.loads);
  ibl_cache_bytes.Set(double(stats.baked.bytes));
  probes_are_alike.Set(stats.probes_are_alike ? 1 : 0);
}

std::string Metrics::text() const {
  return prometheus::TextSerializer().Serialize(registry_.Collect());
}

}  // namespace furnace
