#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "renderer/base/file.hpp"
#include "renderer/base/log.hpp"
#include "renderer/environment_bake.hpp"
#include "renderer/image/encode.hpp"
#include "server/commands/commands.hpp"
#include "server/decoders.hpp"
#include "server/environment_report.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxFileBytes = 4ll << 30;

struct Arguments {
  std::string input, folder;
  std::string method = "spectral";
  std::string sun = "keep";
  EnvironmentLayout layout = EnvironmentLayout::kAuto;
  int threads = 0;
  Config config;  // of the decoders
};

void tell(const char* stage, const std::string& what) {
  if (::isatty(STDERR_FILENO) == 1) {
    fmt::print(stderr, "{}: {}\n", stage, what);
  } else {
    log::info(std::string("bake.") + stage, {{"what", what}});
  }
}

// One line that is written over on a terminal; elsewhere a line of the log each quarter.
BakeProgress tell_progress() {
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  return [terminal, told = 0](double fraction) mutable {
    const int percent = int(100 * fraction), step = terminal ? 1 : 25;
    if (percent < told + step) return;
    told = percent / step * step;
    if (terminal) {
      fmt::print(stderr, "\rbake: {} %{}", percent, percent == 100 ? "\n" : "");
    } else {
      log::info("bake.progress", {{"percent", percent}});
    }
  };
}

void make_folder(const fs::path& folder) {
  std::error_code wrong;
  fs::create_directories(folder, wrong);
  if (wrong)
    fail(ErrorCode::kStorage, fmt::format("cannot make the folder {}: {}", folder.string(), wrong.message()));
}

int bake(const Arguments& arguments) {
  if (::isatty(STDERR_FILENO) == 1) log::set_level(log::Level::kWarning);
  const fs::path folder = arguments.folder;
  const Blob encoded(read_input(arguments.input, kMaxFileBytes));
  make_folder(folder);
  EnvironmentBakeSettings settings;
  if (arguments.method == "riemann") settings.irradiance = IrradianceMethod::kRiemann;
  if (arguments.sun == "extract") settings.sun = SunMode::kExtract;
  settings.layout = arguments.layout;
  settings.progress = tell_progress();
  WorkerPool pool(arguments.threads > 0 ? arguments.threads
                                        : int(std::max(1u, std::thread::hardware_concurrency())));
  tell("begin", arguments.input);
  Decoders decoders(arguments.config);
  const EnvironmentBake baked =
      bake_whole_environment(encoded, settings, pool, decoders.decoder(), Deadline());
  const api::EnvironmentReport report =
      report_of(fs::path(arguments.input).filename().string(), encoded, baked);
  tell("baked", fmt::format("{}, {} x {} px in {:.1f} ms, {} maps", report.layout, report.width,
                            report.height, report.bake_ms, report.maps.size()));
  // The report last: where it stands, every map stands.
  for (const EnvironmentMap& map : baked.list()) {
    const fs::path path = folder / (map.name + ".exr");
    write_file_atomically(path.string(), encode_exr(*map.equirect, {}));
    tell("written", path.string());
  }
  write_file_atomically((folder / "bake.json").string(), api::environment_report_json(report));
  tell("done", (folder / "bake.json").string());
  return kDone;
}

}  // namespace

Command bake_command(CLI::App& root) {
  CLI::App* command =
      root.add_subcommand("bake", "Bakes an HDRI and writes every map as EXR, with bake.json");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("input", arguments->input, "ENVIRONMENT.hdr, ENVIRONMENT.exr, or - for standard input")
      ->required();
  command->add_option("-o,--output", arguments->folder, "folder for the maps; made when it is not there")
      ->required();
  command
      ->add_option("--irradiance-method", arguments->method,
                   "spectral, or riemann: sums over spherical triangles")
      ->check(CLI::IsMember({"spectral", "riemann"}));
  command
      ->add_option("--sun", arguments->sun,
                   "keep, or extract: maps of what is left without the suns that the report lists")
      ->check(CLI::IsMember({"keep", "extract"}));
  std::map<std::string, EnvironmentLayout> layouts;
  for (int k = 0; k <= int(kLastEnvironmentLayout); ++k)
    layouts.emplace(name_of(EnvironmentLayout(k)), EnvironmentLayout(k));
  command
      ->add_option("--layout", arguments->layout,
                   "auto, or what the picture must be: equirect, or a cube as a cross or strip")
      ->transform(CLI::CheckedTransformer(layouts))
      ->option_text("LAYOUT");
  command->add_option("--threads", arguments->threads, "0: one a core")->check(CLI::Range(0, 1024));
  add_decoder_option(*command, arguments->config);
  return {command, [arguments] { return bake(*arguments); }};
}

}  // namespace furnace
