#include <fmt/core.h>

#include "server/application.hpp"
#include "server/commands/commands.hpp"

namespace furnace {

Command check_config_command(CLI::App& root) {
  CLI::App* options =
      root.add_subcommand("check-config", "Checks the configuration of serve and prints what it comes to");
  const auto settings = std::make_shared<SettingOptions>(*options);
  return {options, [settings] {
            const LoadedConfig loaded = settings->load();
            if (!tell_problems(loaded)) return kFailed;
            tls_certificate(loaded.config);  // whether its files are what they should be
            fmt::print("{}", print_config(loaded));
            return kDone;
          }};
}

}  // namespace furnace
