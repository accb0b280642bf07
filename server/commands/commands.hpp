// The subcommands of `furnace`: each adds its options to the command line and says what to run when it is
// chosen.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "renderer/base/error.hpp"
#include "server/config.hpp"

namespace furnace {

inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;  // the thing asked for failed
inline constexpr int kWrongUsage = 2;
inline constexpr int kHangs = 3;  // of serve: the GL driver does not come back

// `run` returns the exit status; an Error that it throws is told by main.
struct Command {
  CLI::App* options;
  std::function<int()> run;
};

Command serve_command(CLI::App& root);
Command render_command(CLI::App& root);
Command bake_command(CLI::App& root);
Command inspect_command(CLI::App& root);
Command sheet_command(CLI::App& root);
Command doctor_command(CLI::App& root);
Command check_config_command(CLI::App& root);
Command version_command(CLI::App& root);
Command sign_url_command(CLI::App& root);
Command hash_key_command(CLI::App& root);

// The options of the table of settings, and what was given.
// Threads: one. Owns: the texts given; must outlive the parse.
class SettingOptions {
 public:
  explicit SettingOptions(CLI::App& command);
  // Reads the file and the environment too. Problems are printed; the caller exits with kWrongUsage when
  // there are any.
  LoadedConfig load() const;

 private:
  CLI::App& command_;
  std::string config_file_;
  std::map<std::string, std::vector<std::string>> given_;
};

// On one's own machine the only limits are those of the formats.
Config local_config();

// --decoder-sandbox, off unless given: who names a file on the own machine mostly trusts it.
void add_decoder_option(CLI::App& command, Config& config);

// The whole of a file, or of standard input for "-". Errors: those of read_file.
std::string read_input(const std::string& input, std::int64_t max_bytes);

// Prints all problems and warnings; returns whether the configuration can be used.
bool tell_problems(const LoadedConfig& loaded);

// For people on a terminal, one JSON line per fault otherwise.
void tell_error(const Error& error);

}  // namespace furnace
