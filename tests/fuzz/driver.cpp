// One program for every target, `fuzz --target=NAME`, so that all share one build; libFuzzer does not read flags with two dashes.
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "tests/fuzz/targets.hpp"

namespace furnace::fuzz {
namespace {

constexpr std::string_view kTargetFlag = "--target=";

std::vector<Target> all_targets() {
  std::vector<Target> all;
  for (const auto rows : {image_targets(), gltf_targets(), mesh_targets(), request_targets(), url_targets()})
    all.insert(all.end(), rows.begin(), rows.end());
  return all;
}

std::optional<Target> chosen;

[[noreturn]] void list_targets(int status) {
  for (const Target& target : all_targets()) fmt::print("{}\n", target.name);
  std::exit(status);
}

void choose(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view flag = argv[i];
    if (flag == "--list") list_targets(EXIT_SUCCESS);
    if (!flag.starts_with(kTargetFlag)) continue;
    for (const Target& target : all_targets())
      if (target.name == flag.substr(kTargetFlag.size())) chosen = target;
  }
  if (!chosen) list_targets(EXIT_FAILURE);
}

// The target's bound goes before the caller's flags, which have the last word.
void add_bound(int* argc, char*** argv) {
  static std::string bound = fmt::format("-max_len={}", chosen->most_bytes);
  static std::vector<char*> flags(*argv, *argv + *argc);
  flags.insert(flags.begin() + 1, bound.data());
  *argc = int(flags.size());
  flags.push_back(nullptr);
  *argv = flags.data();
}

}  // namespace
}  // namespace furnace::fuzz

using namespace furnace::fuzz;

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  choose(*argc, *argv);
  add_bound(argc, argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    chosen->run(std::as_bytes(std::span(data, size)));
  } catch (const furnace::Error& error) {
    if (error.code != furnace::ErrorCode::kInternal && !error.message.empty()) return 0;
    fmt::print(stderr, "ERROR: an Error that is our own mistake: \"{}\" ({}), at \"{}\"\n", error.message,
               error.detail, error.pointer);
    std::abort();
  }
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t room,
                                               unsigned seed) {
  return chosen->mutate(data, size, room, seed);
}
