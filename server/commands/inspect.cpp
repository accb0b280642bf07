#include <cstdio>
#include <filesystem>
#include <memory>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "api/model_report.hpp"
#include "server/commands/commands.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxFileBytes = 4ll << 30;
constexpr const char* kModelPart = "model";

struct Arguments {
  std::string input;
  ImportOptions options;
  std::string variant;
  bool text = false;
};

// What a .gltf refers to stands beside it; what came through standard input has nothing beside it.
std::shared_ptr<const ModelBundle> read_model(const std::string& input, const ImportLimits& limits) {
  const bool stream = input == "-";
  const fs::path path = input, folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  FileAssets files({folder}, 0, kMaxFileBytes);
  std::map<std::string, Blob> parts;
  if (stream) parts[kModelPart] = Blob(read_input(input, kMaxFileBytes));
  const AssetResolver assets(files, std::move(parts), limits);
  return assets.read_model(stream ? std::string("part:") + kModelPart : "file:" + path.filename().string(),
                           {});
}

int inspect(const Arguments& arguments) {
  const ImportLimits limits;
  ImportOptions options = arguments.options;
  if (!arguments.variant.empty()) options.variant = arguments.variant;
  const ModelReport report = inspect_model(decode::in_process_decoder(), *read_model(arguments.input, limits),
                                           options, limits, Deadline());
  const std::string text = arguments.text ? api::model_report_text(report) : api::model_report_json(report);
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    fail(ErrorCode::kStorage, "could not write to standard output");
  return kDone;
}

}  // namespace

Command inspect_command(CLI::App& root) {
  CLI::App* command = root.add_subcommand("inspect", "Prints what is in a model, as JSON");
  const auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("input", arguments->input, "MODEL.glb, .gltf, .obj, .stl or .ply, or - for standard input")
      ->required();
  command->add_option("--scene", arguments->options.scene, "index of the glTF scene that counts as drawn")
      ->check(CLI::Range(0, 1'000'000));
  command->add_option("--variant", arguments->variant, "one of the model's sets of materials");
  command->add_flag("--text", arguments->text, "a summary for people instead");
  return {command, [arguments] { return inspect(*arguments); }};
}

}  // namespace furnace
