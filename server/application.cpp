#include "server/application.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "server/build_id.hpp"
#include "server/even_time.hpp"

namespace furnace {
namespace {

using std::chrono::milliseconds;

constexpr int kRefusingThreads = 8;  // beyond seats and queue: they tell others that there is no place
constexpr int kAdminThreads = 2;
constexpr milliseconds kWarmUpTime{120'000};

int cores() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

int cpu_threads(const Config& config) {
  return config.cpu_threads > 0 ? config.cpu_threads : cores();
}

// One seat per core keeps the CPU stages busy, one more each GL thread.
int seats(const Config& config, const Renderer& renderer) {
  return config.seats > 0 ? config.seats : cores() + int(renderer.stats().contexts.callers.size());
}

RendererConfig renderer_config(const Config& config) {
  RendererConfig out;
  out.gl.device = config.device;
  out.gl.determinism = config.determinism == "exact" ? gl::Determinism::kExact : gl::Determinism::kFast;
  out.contexts = config.contexts;
  out.context_life = {config.context_renders, milliseconds(config.context_age_ms),
                      config.context_process_bytes};
  out.build_id = std::string(build_id());
  out.shader_dir = config.shader_dir;
  out.scene_cache_bytes = config.scene_cache_bytes;
  out.bake_cache_bytes = config.bake_cache_bytes;
  out.background_cache_bytes = config.background_cache_bytes;
  out.data_folder = config.data;
  out.disk_cache_bytes = config.disk_cache_bytes;
  out.gpu_cache_bytes = config.gpu_cache_bytes;
  return out;
}

HttpConfig http_config(const Config& config, std::string_view listen, int threads) {
  const auto address = parse_address(listen);
  FURNACE_CHECK(address.has_value(), "address {}", listen);
  HttpConfig out;
  out.address = *address;
  out.threads = threads;
  out.max_connections = config.max_connections;
  out.max_body_bytes = config.max_body_bytes;
  out.max_bodies_bytes = config.max_bodies_bytes;
  out.timeout = milliseconds(config.timeout_ms);
  out.keep_alive = milliseconds(config.keep_alive_ms);
  out.io.header_timeout = milliseconds(config.header_timeout_ms);
  out.io.io_timeout = milliseconds(config.io_timeout_ms);
  out.hsts_max_age = milliseconds(config.hsts_max_age_ms);
  return out;
}

api::Capabilities capabilities(const Config& config, const Renderer& renderer) {
  const Fingerprint& print = renderer.fingerprint();
  api::Capabilities out;
  out.version = {std::string(version()), std::string(build_id()), print.shaders, print.gl, print.text()};
  out.request = request_limits(config);
  out.max_body_bytes = config.max_body_bytes;
  out.max_texture_px = renderer.limits().max_texture_px;
  out.software_gl = renderer.limits().software;
  out.remote_files = !config.remote_allow.empty();
  out.webhooks = !config.webhook_allow.empty();
  return out;
}

OutboundConfig outbound_config(const Config& config) {
  OutboundConfig out;
  out.user_agent = fmt::format("furnace/{}", version());
  out.ca_file = config.outbound_ca_file;
  return out;
}

std::unique_ptr<WebhookSender> webhook_sender(const Config& config, JobStore& jobs, Metrics& metrics) {
  constexpr std::int64_t kMostReplyBytes = 64 << 10;  // nobody reads it
  if (config.webhook_allow.empty()) return nullptr;
  OutboundConfig client = outbound_config(config);
  client.timeout = client.connect_timeout = milliseconds(config.webhook_timeout_ms);
  client.max_bytes = kMostReplyBytes;
  client.max_redirects = 0;
  WebhookConfig out;
  out.threads = config.webhook_threads;
  out.keys_file = config.webhook_secrets_file;
  out.retries.max_attempts = config.webhook_attempts;
  out.retries.first_pause_ms = config.webhook_pause_ms;
  out.retries.max_age_ms = config.webhook_max_age_ms;
  return std::make_unique<WebhookSender>(jobs, OutboundClient(AllowList(config.webhook_allow), client), out,
                                         metrics);
}

std::unique_ptr<RemoteFiles> remote_files(const Config& config, Metrics& metrics) {
  if (config.remote_allow.empty()) return nullptr;
  OutboundConfig client = outbound_config(config);
  client.timeout = milliseconds(config.remote_timeout_ms);
  client.max_bytes = config.remote_max_bytes;
  RemoteConfig out;
  out.max_request_bytes = config.remote_request_bytes;
  out.max_fetches = config.remote_fetches;
  out.freshness = milliseconds(config.remote_freshness_ms);
  out.cache_bytes = config.remote_cache_bytes;
  return std::make_unique<RemoteFiles>(OutboundClient(AllowList(config.remote_allow), client), out, metrics);
}

JobLimits job_limits(const Config& config) {
  constexpr std::int64_t kMostInMemory = 256ll << 20;
  JobLimits limits;
  limits.max_waiting = config.job_queue;
  limits.max_bytes = config.data.empty() ? std::min(config.job_bytes, kMostInMemory) : config.job_bytes;
  limits.keep_ms = config.job_ttl_ms;
  limits.max_deliveries = config.webhook_queue;
  return limits;
}

AssetStoreConfig asset_store_config(const Config& config) {
  AssetStoreConfig out;
  if (!config.data.empty()) out.folder = std::filesystem::path(config.data) / "assets";
  out.largest_bytes = config.max_asset_bytes;
  out.budget_bytes = config.asset_store_bytes;
  out.ttl = milliseconds(config.asset_ttl_ms);
  out.now = [] { return std::chrono::file_clock::from_sys(even_now()); };
  out.partial_ttl = milliseconds(config.partial_ttl_ms);
  out.memory_bytes = config.file_cache_bytes;
  return out;
}

RegistryConfig registry_config(const Config& config) {
  RegistryConfig out;
  if (!config.data.empty()) out.folder = std::filesystem::path(config.data) / "environments";
  out.files_bytes = config.environments_bytes;
  out.maps_bytes = config.map_cache_bytes;
  return out;
}

std::shared_ptr<const Presets> presets(const Config& config) {
  if (config.presets.empty()) return std::make_shared<const Presets>();
  const api::JsonLimits limits{api::RequestLimits{}.max_json_depth, config.max_json_bytes};
  return std::make_shared<const Presets>(config.presets, limits);
}

std::vector<std::filesystem::path> paths(const std::vector<std::string>& texts) {
  return {texts.begin(), texts.end()};
}

}  // namespace

api::RequestLimits request_limits(const Config& config) {
  api::RequestLimits limits;
  limits.max_side_px = config.max_side_px;
  limits.max_area_px = config.max_area_px;
  limits.max_samples = config.max_samples;
  limits.max_layer_bytes = config.max_layer_bytes;
  limits.max_frames = config.max_frames;
  limits.max_sequence_px = config.max_sequence_px;
  limits.max_json_bytes = config.max_json_bytes;
  return limits;
}

std::unique_ptr<TlsCertificate> tls_certificate(const Config& config) {
  if (config.tls_certificate.empty()) return nullptr;
  return std::make_unique<TlsCertificate>(TlsFiles{config.tls_certificate, config.tls_key});
}

Engine::Engine(const Config& config, std::vector<std::filesystem::path> file_roots)
    : pool_(cpu_threads(config)),
      decoders(config),
      renderer(renderer_config(config), pool_, decoders.decoder()),
      admission(seats(config, renderer), config.queue),
      files(std::move(file_roots), config.file_cache_bytes, config.max_file_bytes),
      environments([this](const EnvironmentSpec& spec,
                          const Deadline& deadline) { return renderer.environment(spec, deadline); },
                   admission, pool_, decoders.decoder(), registry_config(config)),
      renders({config.render_cache_bytes, config.data, config.render_disk_bytes}),
      service(painter_of(renderer), admission, pool_, renders, {config.max_frames, config.max_sequence_px}) {}

Application::Application(const Config& config)
    : config_(config),
      gate_({config_.api_keys_file, config_.url_keys_file, config_.cors_origins, config_.max_url_bytes}),
      engine_(config_, paths(config_.assets)),
      metrics_(build_id()),
      assets_(asset_store_config(config_)),
      readiness_([this](const Deadline& deadline) { return engine_.renderer.probe(deadline); },
                 milliseconds(config_.ready_timeout_ms)),
      jobs_(config_.data, job_limits(config_)),
      webhooks_(webhook_sender(config_, jobs_, metrics_)),
      remote_(remote_files(config_, metrics_)),
      doors_{engine_.service,
             engine_.admission,
             engine_.files,
             engine_.decoders.decoder(),
             engine_.environments,
             readiness_,
             metrics_,
             capabilities(config_, engine_.renderer),
             config_.max_parts,
             config_.max_batch,
             engine_.decoders.processes(),
             &job_doors_,
             presets(config_),
             {config_.image_max_age_ms / 1000, config_.presets_only == "on"},
             &assets_,
             remote_.get(),
             [this] { return engine_.renderer.stats(); },
             config_.determinism == "exact",
             config_.max_bundle_bytes},
      job_runner_(
          jobs_,
          [this](const JobRequest& request, const Deadline& deadline, const TellProgress& progress) {
            return draw_job(doors_, request, deadline, progress);
          },
          {config_.job_threads, milliseconds(config_.job_timeout_ms), milliseconds(config_.job_deadline_ms)},
          [this] {
            if (webhooks_) webhooks_->wake();
          }),
      job_doors_(jobs_, job_runner_, config_.event_streams, AllowList(config_.webhook_allow)),
      public_dispatcher_(public_routes(doors_, config_.admin_listen.empty()), metrics_, &gate_),
      admin_dispatcher_(operation_routes(doors_, true), metrics_),
      tls_(tls_certificate(config_)),
      admin_server_(
          config_.admin_listen.empty()
              ? nullptr
              : std::make_unique<HttpServer>(http_config(config_, config_.admin_listen, kAdminThreads),
                                             admin_dispatcher_, metrics_)),
      // A waiting request holds its thread, and so does a stream of events.
      server_(
          http_config(config_, config_.listen,
                      engine_.admission.seats() + config_.queue + config_.event_streams + kRefusingThreads),
          public_dispatcher_, metrics_, tls_.get()) {}

void Application::start() {
  if (admin_server_) admin_server_->start();
  server_.start();
  try {
    readiness_.check(kWarmUpTime);
  } catch (const Error& error) {
    log::error("server.not_ready", {{"message", error.message}, {"detail", error.detail}});
  }
}

void Application::stop() {
  readiness_.drain();
  log::info("server.draining", {{"timeout_ms", config_.drain_timeout_ms}});
  server_.stop(milliseconds(config_.drain_timeout_ms));
  if (admin_server_) admin_server_->stop(milliseconds(0));
  log::info("server.stopped");
}

bool Application::hangs() const {
  return config_.gl_watchdog_ms > 0 && engine_.renderer.overdue() > milliseconds(config_.gl_watchdog_ms);
}

void Application::reload() {
  const auto attempt = [](std::string_view what, const std::function<void()>& renew) {
    try {
      renew();
      log::info(fmt::format("{}.reloaded", what));
    } catch (const Error& error) {
      log::error(fmt::format("{}.kept", what), {{"message", error.message}, {"detail", error.detail}});
    }
  };
  attempt("keys", [this] { gate_.reload(); });
  if (webhooks_) attempt("webhooks", [this] { webhooks_->reload(); });
  if (tls_) attempt("tls", [this] { tls_->reload(); });
}

std::optional<int> Application::admin_port() const {
  if (!admin_server_) return std::nullopt;
  return admin_server_->port();
}

}  // namespace furnace
