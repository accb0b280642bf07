#include "server/commands/commands.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include "renderer/base/file.hpp"
#include "renderer/base/log.hpp"
#include "server/settings.hpp"

extern char** environ;

namespace furnace {
namespace {

constexpr std::int64_t kMaxConfigBytes = 1 << 20;

NamedValues whole_environment() {
  NamedValues values;
  for (char** entry = environ; *entry; ++entry) {
    const std::string_view text = *entry;
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) continue;
    values.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return values;
}

}  // namespace

SettingOptions::SettingOptions(CLI::App& command) : command_(command) {
  command.add_option("--config", config_file_, "configuration file with lines of the form name = value")
      ->envname("FURNACE_CONFIG")
      ->check(CLI::ExistingFile);
  for (const Setting& setting : all_settings()) {
    const std::string name(setting.name);
    CLI::Option* option = command.add_option("--" + name, given_[name],
                                             fmt::format("{} ({})", setting.help, environment_name(setting)));
    option->default_str(value_text(setting, Config{}))->expected(1);
    const bool list = std::holds_alternative<std::vector<std::string> Config::*>(setting.member);
    option->type_name(setting.choices.empty() ? "" : fmt::format("{{{}}}", setting.choices));
    option->multi_option_policy(list ? CLI::MultiOptionPolicy::TakeAll : CLI::MultiOptionPolicy::Throw);
  }
}

LoadedConfig SettingOptions::load() const {
  ConfigSources sources;
  sources.environment = whole_environment();
  if (!config_file_.empty()) sources.file_text = read_file(config_file_, kMaxConfigBytes);
  for (const auto& [name, values] : given_) {
    for (const std::string& value : values) sources.flags.emplace_back(name, value);
  }
  return load_config(sources);
}

Config local_config() {
  Config config;
  config.queue = 0;
  config.max_side_px = 16384;
  config.max_area_px = 256ll << 20;
  config.max_samples = 4096;
  config.max_layer_bytes = 64ll << 30;
  config.render_cache_bytes = 0;
  config.max_frames = 100'000;
  config.max_sequence_px = 1ll << 40;
  config.max_json_bytes = 256ll << 20;
  config.max_file_bytes = 4ll << 30;
  config.timeout_ms = 24ll * 3600 * 1000;
  return config;
}

void add_decoder_option(CLI::App& command, Config& config) {
  config.decoder_sandbox = "off";
  command.add_option("--decoder-sandbox", config.decoder_sandbox, "as of serve, but off unless given")
      ->check(CLI::IsMember({"require", "prefer", "off"}));
}

std::string read_input(const std::string& input, std::int64_t max_bytes) {
  if (input != "-") return read_file(input, max_bytes);
  std::string bytes;
  constexpr std::size_t kStep = 1 << 20;
  for (std::size_t got = kStep; got == kStep;) {
    const std::size_t end = bytes.size();
    bytes.resize(end + kStep);
    got = std::fread(bytes.data() + end, 1, kStep, stdin);
    bytes.resize(end + got);
    if (std::int64_t(bytes.size()) > max_bytes) {
      fail(ErrorCode::kTooLarge, fmt::format("standard input has more than the allowed {} bytes", max_bytes));
    }
  }
  if (std::ferror(stdin) != 0) fail(ErrorCode::kStorage, "standard input cannot be read");
  return bytes;
}

bool tell_problems(const LoadedConfig& loaded) {
  for (const std::string& problem : loaded.problems) fmt::print(stderr, "furnace: {}\n", problem);
  for (const std::string& warning : loaded.warnings) fmt::print(stderr, "furnace: warning: {}\n", warning);
  return loaded.problems.empty();
}

void tell_error(const Error& error) {
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  if (!terminal) {
    log::error("failed", {{"code", error_code_name(error.code)},
                          {"message", error.message},
                          {"pointer", error.pointer},
                          {"detail", error.detail}});
    for (const Problem& problem : error.problems) {
      log::error("problem", {{"pointer", problem.pointer}, {"message", problem.message}});
    }
    return;
  }
  const auto place = [](const std::string& pointer) {
    return pointer.empty() ? "" : " (at " + pointer + ")";
  };
  fmt::print(stderr, "furnace: {}{}\n", error.message, place(error.pointer));
  for (const Problem& problem : error.problems) {
    fmt::print(stderr, "  {}: {}\n", problem.pointer.empty() ? "/" : problem.pointer, problem.message);
  }
  if (!error.detail.empty()) fmt::print(stderr, "  {}\n", error.detail);
}

}  // namespace furnace
