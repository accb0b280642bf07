#include "server/build_id.hpp"
#include "server/commands/commands.hpp"

#include <fmt/core.h>

namespace furnace {

Command version_command(CLI::App& root) {
  return {root.add_subcommand("version", "Prints version and build"), [] {
            fmt::print("furnace {}\n", build_id());
            return kDone;
          }};
}

}  // namespace furnace
