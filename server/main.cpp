// furnace: a render server, and the same engine on the command line.
#include <exception>
#include <vector>

#include <CLI/CLI.hpp>

#include "renderer/base/error.hpp"
#include "server/commands/commands.hpp"

int main(int argc, char** argv) {
  CLI::App root{"Furnace renders glTF and JSON scenes with physically based light."};
  root.require_subcommand(1);
  const std::vector<furnace::Command> commands = {
      furnace::serve_command(root),        furnace::render_command(root),  furnace::doctor_command(root),
      furnace::check_config_command(root), furnace::version_command(root),
  };
  try {
    root.parse(argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return root.exit(wrong) == 0 ? furnace::kDone : furnace::kWrongUsage;
  }

  // The one catch of the command line's door.
  try {
    for (const furnace::Command& command : commands) {
      if (command.options->parsed()) return command.run();
    }
  } catch (const furnace::Error& error) {
    furnace::tell_error(error);
  } catch (const std::exception& stray) {
    furnace::tell_error({furnace::ErrorCode::kInternal, stray.what(), {}, {}, {}, {}});
  }
  return furnace::kFailed;
}
