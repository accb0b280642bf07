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
      request_seconds(BuildHistogram()
                          .Name("furnace_request_seconds")
                          .Help("From a complete request to its reply, the wait for a seat included")
                          .Register(registry_)),
      client_requests(BuildCounter()
                          .Name("furnace_client_requests_total")
                          .Help("Requests with an API key, by its name")
                          .Register(registry_)),
      requests_in_flight(BuildGauge()
                             .Name("furnace_requests_in_flight")
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
      seats_in_use(
          BuildGauge().Name("furnace_seats_in_use").Help("Renders worked on").Register(registry_).Add({})),
      queue_length(
          BuildGauge().Name("furnace_queue_length").Help("Renders waiting").Register(registry_).Add({})),
      jobs_waiting(
          BuildGauge().Name("furnace_jobs_waiting").Help("Jobs not yet begun").Register(registry_).Add({})),
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
                        .Name("furnace_stage_seconds")
                        .Help("Time of a render's stages")
                        .Register(registry_)),
      cache_lookups(
          BuildCounter().Name("furnace_cache_lookups_total").Help("Hits and misses").Register(registry_)),
      ready(BuildGauge()
                .Name("furnace_ready")
                .Help("1 when the last probe picture was right")
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
      context_callers(BuildGauge()
                          .Name("furnace_context_callers")
                          .Help("Renders that draw on a GL context, or will")
                          .Register(registry_)),
      context_renewals(BuildCounter()
                           .Name("furnace_context_renewals_total")
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
  request_seconds.Add({{"route", std::string(route)}}, kSecondsBuckets).Observe(seconds);
}

void Metrics::observe_client(const std::string& client, int status) {
  client_requests.Add({{"client", client}, {"status", std::to_string(status)}}).Increment();
}

void Metrics::observe_stages(const StageTimes& times) {
  const auto stage = [this](const char* name, double ms) {
    stage_seconds.Add({{"stage", name}}, kSecondsBuckets).Observe(ms * kSecondsPerMs);
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

void Metrics::observe_contexts(const ContextPoolStats& stats) {
  const std::lock_guard lock(counting_);
  for (std::size_t i = 0; i < stats.callers.size(); ++i)
    context_callers.Add({{"context", std::to_string(i)}}).Set(stats.callers[i]);
  for (std::size_t i = 0; i < kRenewalReasons; ++i) {
    const std::string reason(name_of(RenewalReason(i)));
    catch_up(context_renewals.Add({{"reason", reason}}), stats.renewals[i]);
  }
}

std::string Metrics::text() const {
  return prometheus::TextSerializer().Serialize(registry_.Collect());
}

}  // namespace furnace
