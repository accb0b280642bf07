#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>

#include <fmt/core.h>

#include "renderer/base/log.hpp"
#include "renderer/gl/context.hpp"
#include "server/application.hpp"
#include "server/build_id.hpp"
#include "server/commands/commands.hpp"

namespace furnace {
namespace {

sigset_t awaited_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGHUP);  // reads keys and certificate again
  return set;
}

log::Level log_level(const std::string& name) {
  if (name == "debug") return log::Level::kDebug;
  if (name == "warning") return log::Level::kWarning;
  if (name == "error") return log::Level::kError;
  if (name == "off") return log::Level::kOff;
  return log::Level::kInfo;
}

std::string base_url(const Config& config, int port) {
  std::string host = parse_address(config.listen)->host;
  if (host == "0.0.0.0" || host == "::") host = "127.0.0.1";  // what one can type on this machine
  if (host.find(':') != std::string::npos) host = '[' + host + ']';
  return fmt::format("{}://{}:{}", config.tls_certificate.empty() ? "http" : "https", host, port);
}

// The first line is for programs, the second for people.
void announce(const Application& application, const Config& config) {
  const std::string url = base_url(config, application.port());
  fmt::print("furnace listening on {}\n", url);
  fmt::print("curl -X POST {}/v1/renders -H 'Content-Type: application/json' -d '{{}}' -o picture.png\n",
             url);
  if (const auto port = application.admin_port()) fmt::print("furnace admin on port {}\n", *port);
  std::fflush(stdout);
}

int serve(const LoadedConfig& loaded) {
  const Config& config = loaded.config;
  log::set_level(log_level(config.log_level));
  gl::apply_determinism(config.determinism == "exact" ? gl::Determinism::kExact : gl::Determinism::kFast);

  // Before any thread, so that all inherit it: only this thread takes them.
  const sigset_t signals = awaited_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  Application application(config);
  application.start();
  log::info("server.started", {{"build", build_id()},
                               {"port", application.port()},
                               {"fingerprint", application.fingerprint().text()}});
  announce(application, config);

  constexpr timespec kLook{1, 0};
  for (int signal = 0; signal != SIGTERM && signal != SIGINT;) {
    signal = sigtimedwait(&signals, nullptr, &kLook);
    if (signal == SIGHUP) application.reload();
    if (!application.hangs()) continue;
    // The thread that hangs can neither be ended nor waited for. What must outlive the process is on the disk.
    log::error("gl.hangs", {{"watchdog_ms", config.gl_watchdog_ms}});
    std::_Exit(kHangs);
  }
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);  // a second signal ends the process at once
  application.stop();
  return kDone;
}

}  // namespace

Command serve_command(CLI::App& root) {
  CLI::App* options = root.add_subcommand("serve", "Serves renders over HTTP until SIGTERM or SIGINT");
  const auto settings = std::make_shared<SettingOptions>(*options);
  const auto print_only = std::make_shared<bool>(false);
  options->add_flag("--print-config", *print_only, "print the effective configuration and exit");
  return {options, [settings, print_only] {
            const LoadedConfig loaded = settings->load();
            if (!tell_problems(loaded)) return kWrongUsage;
            if (!*print_only) return serve(loaded);
            fmt::print("{}", print_config(loaded));
            return kDone;
          }};
}

}  // namespace furnace
