// The composition root: what is built, in which order, and how it ends. Destruction in reverse is the
// shutdown order.
#pragma once

#include <memory>
#include <optional>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/renderer.hpp"
#include "server/admission.hpp"
#include "server/asset_store.hpp"
#include "server/config.hpp"
#include "server/decoders.hpp"
#include "server/dispatcher.hpp"
#include "server/environment_registry.hpp"
#include "server/gate.hpp"
#include "server/http_server.hpp"
#include "server/job_routes.hpp"
#include "server/metrics.hpp"
#include "server/remote_files.hpp"
#include "server/render_service.hpp"
#include "server/routes.hpp"
#include "server/tls.hpp"
#include "server/webhook_sender.hpp"

namespace furnace {

// Everything that draws, without a door: the command line needs no more.
// Threads: any. Owns: the CPU threads, the decoders, the GL thread and its caches.
class Engine {
 public:
  // Errors: kGpuUnavailable; those of Decoders. gl::apply_determinism must have been called.
  Engine(const Config& config, std::vector<std::filesystem::path> file_roots);

 private:
  WorkerPool pool_;

 public:
  Decoders decoders;
  Renderer renderer;
  Admission admission;
  FileAssets files;
  EnvironmentRegistry environments;
  RenderCache renders;
  RenderService service;
};

// The server. Threads: one owner. Owns: everything.
class Application {
 public:
  // Builds all and binds, so that what cannot work fails here. Errors: those of Engine, kUnprocessable (an
  // address).
  explicit Application(const Config& config);

  // Listens, then draws the first probe; a probe that fails is logged, and told by /readyz.
  void start();
  // Not ready from now on; requests in flight end, or are cancelled after the drain timeout.
  void stop();

  // The GL thread hangs: only another process draws again.
  bool hangs() const;

  // Takes the files of keys and of the certificate anew; what is wrong with them is logged, and what was in use stays.
  void reload();

  int port() const { return server_.port(); }
  std::optional<int> admin_port() const;
  const Fingerprint& fingerprint() const { return engine_.renderer.fingerprint(); }

 private:
  const Config config_;
  Gate gate_;
  Engine engine_;
  Metrics metrics_;
  AssetStore assets_;
  Readiness readiness_;
  JobStore jobs_;
  const std::unique_ptr<WebhookSender> webhooks_;  // null: none are called
  const std::unique_ptr<RemoteFiles> remote_;      // null: nothing is fetched
  const Doors doors_;
  JobRunner job_runner_;
  JobDoors job_doors_;
  const Dispatcher public_dispatcher_;
  const Dispatcher admin_dispatcher_;
  const std::unique_ptr<TlsCertificate> tls_;  // null: plain HTTP
  std::unique_ptr<HttpServer> admin_server_;   // null without admin_listen
  HttpServer server_;
};

// Null when none is set. Errors: those of TlsCertificate.
std::unique_ptr<TlsCertificate> tls_certificate(const Config& config);

// A request's limits as configured.
api::RequestLimits request_limits(const Config& config);

}  // namespace furnace
