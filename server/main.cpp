// furnace: a render server, and the same engine on the command line.
#include <malloc.h>

#include <exception>
#include <span>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "renderer/base/error.hpp"
#include "renderer/decode/worker.hpp"
#include "server/commands/commands.hpp"

namespace {

// glibc keeps ever larger freed blocks for itself; pictures and maps are large and seldom of one size. With a fixed threshold
// they go back at once: a third less memory held after a few models, at the same speed.
void return_large_blocks() {
#ifdef M_MMAP_THRESHOLD
  constexpr int kThreshold = 256 << 10;
  mallopt(M_MMAP_THRESHOLD, kThreshold);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  return_large_blocks();
  // Not a command of the command line: the server starts it, often, and it must be ready at once.
  if (argc > 2 && std::string_view(argv[1]) == "decode-worker")
    return furnace::decode::run_worker(std::span(argv, std::size_t(argc)).subspan(2),
                                       furnace::decode::decode_jobs());
  CLI::App root{"Furnace renders glTF and JSON scenes with physically based light."};
  root.require_subcommand(1);
  const std::vector<furnace::Command> commands = {
      furnace::serve_command(root),        furnace::render_command(root),  furnace::bake_command(root),
      furnace::inspect_command(root),      furnace::sheet_command(root),   furnace::doctor_command(root),
      furnace::check_config_command(root), furnace::version_command(root), furnace::sign_url_command(root),
      furnace::hash_key_command(root),
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
