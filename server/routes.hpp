// The route table and its handlers.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "renderer/decode/process_decoder.hpp"
#include "api/capabilities.hpp"
#include "server/asset_store.hpp"
#include "server/dispatcher.hpp"
#include "server/environment_registry.hpp"
#include "server/image_url.hpp"
#include "server/job_routes.hpp"
#include "server/metrics.hpp"
#include "server/remote_files.hpp"
#include "server/render_service.hpp"
#include "server/request_body.hpp"

namespace furnace {

// Whether this process can draw: asks with a real picture, at most once a second. While one caller asks, others get the
// last answer, so that nobody waits for them.
// Threads: any. Owns: the last answer.
class Readiness {
 public:
  // Draws a probe and checks its pixels; may throw an Error.
  using Probe = std::function<bool(const Deadline&)>;
  Readiness(Probe probe, std::chrono::milliseconds timeout) : probe_(std::move(probe)), timeout_(timeout) {}

  // Errors: kGpuUnavailable when draining or when the probe was wrong, late or failed.
  void check() { check(timeout_); }
  // The first probe compiles and bakes what later ones find ready, so it may take longer.
  void check(std::chrono::milliseconds timeout);
  void drain() { draining_ = true; }

 private:
  Probe probe_;
  std::chrono::milliseconds timeout_;
  std::atomic<bool> draining_ = false;
  std::mutex mutex_;  // one probe at a time
  Clock::time_point good_until_{};
  std::atomic<bool> was_good_ = false;
};

// What handlers work with; everything outlives the routes.
struct Doors {
  RenderService& service;
  Admission& admission;
  FileAssets& files;
  Decoder& decoder;
  EnvironmentRegistry& environments;
  Readiness& readiness;
  Metrics& metrics;
  api::Capabilities capabilities;  // with the limits that requests are held to
  int max_parts = 64;
  int max_batch = 256;                               // renders
  const decode::ProcessDecoder* decoders = nullptr;  // null: files are decoded in this process
  JobDoors* jobs = nullptr;                          // null: every render is waited for
  std::shared_ptr<const Presets> presets = std::make_shared<const Presets>();
  ImageUrlConfig image_urls = {};
  AssetStore* assets = nullptr;   // null: nothing can be uploaded, nor referred to
  RemoteFiles* remote = nullptr;  // null: nothing is fetched from elsewhere
  std::function<RendererStats()> renderer = {};
  bool is_exact = false;  // gl::Determinism::kExact
  std::int64_t max_bundle_bytes = 512ll << 20;
};

// `reads`, if any, hears what the references are. Errors: those of parse_render_request; kNotAcceptable.
RenderSpec parse_spec(const RequestBody& body, std::string_view accept, const Doors& doors,
                      const Deadline& deadline, std::vector<ReadReference>* reads = nullptr);

// A job's work: the request is understood and drawn as POST /v1/renders would. The result is as encode_stored_render writes it.
// Errors: those of that door.
std::string draw_job(const Doors& doors, const JobRequest& request, const Deadline& deadline,
                     const TellProgress& progress);

// The picture of a document as POST /v1/renders answers it, or 304. Errors: those of api::parse_render_request and of
// RenderService::render; kNotAcceptable.
Reply answer_document(const Doors& doors, const Request& request, const RequestBody& body);

// Health and version; metrics too when `with_metrics`.
std::vector<Route> operation_routes(const Doors& doors, bool with_metrics);
// Everything, operations included.
std::vector<Route> public_routes(const Doors& doors, bool with_metrics);

}  // namespace furnace
