#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/file.hpp"
#include "renderer/base/log.hpp"
#include "renderer/gl/context.hpp"
#include "renderer/image/encode.hpp"
#include "renderer/scene/model_format.hpp"
#include "renderer/scene/procedural.hpp"
#include "api/document.hpp"
#include "server/application.hpp"
#include "server/commands/commands.hpp"
#include "server/contact_sheet.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr auto kModelTime = std::chrono::minutes(5);

struct Arguments {
  std::vector<std::string> inputs;
  std::string output;
  std::string environment = "studio";
  int columns = 0;  // 0: as many as rows
  int cell_px = 256;
  Config config;
};

std::vector<fs::path> find_models(const std::vector<std::string>& inputs) {
  std::vector<fs::path> models;
  for (const std::string& input : inputs) {
    if (!fs::exists(input)) fail(ErrorCode::kNotFound, fmt::format("there is no file or folder {}", input));
    if (!fs::is_directory(input)) {
      models.emplace_back(input);
      continue;
    }
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(input))
      if (entry.is_regular_file() && is_model_name(entry.path().string())) found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    models.insert(models.end(), found.begin(), found.end());
  }
  if (models.empty()) fail(ErrorCode::kNotFound, "there is no model to draw");
  return models;
}

RenderSpec spec_of(const fs::path& model, const Arguments& arguments) {
  FileAssets files({model.has_parent_path() ? model.parent_path() : fs::path(".")}, 0,
                   arguments.config.max_file_bytes);
  RenderSpec spec;
  spec.scene.model =
      AssetResolver(files, {}, ImportLimits{}).read_model("file:" + model.filename().string(), {});
  spec.environment.map = BuiltinName{arguments.environment};
  spec.output.width = spec.output.height = arguments.cell_px;
  return spec;
}

// One line for each cell.
void tell_cell(int index, int columns, const fs::path& model, const std::set<std::string>& notes,
               const std::string& error) {
  const std::string name = model.string();
  fmt::print("{{\"row\":{},\"column\":{},\"model\":{},\"notes\":[{}]", index / columns, index % columns,
             api::quoted(name, name.size()), fmt::join(notes, ","));
  if (!error.empty()) fmt::print(",\"error\":{}", api::quoted(error, error.size()));
  fmt::print("}}\n");
  std::fflush(stdout);
}

int sheet(const Arguments& arguments) {
  log::set_level(log::Level::kWarning);
  gl::apply_determinism(gl::Determinism::kFast);
  const std::vector<fs::path> models = find_models(arguments.inputs);
  const int count = int(models.size());
  const int px = arguments.cell_px;
  if (ContactSheetPicture::extent_of(count, arguments.columns, px).area() > arguments.config.max_area_px)
    fail(ErrorCode::kTooLarge,
         fmt::format("{} models of {} px are too many for one sheet; ask for smaller cells", count, px));
  ContactSheetPicture picture(count, arguments.columns, px);
  const int columns = picture.columns();
  Engine engine(arguments.config, {});
  int failures = 0;
  for (int i = 0; i < count; ++i) {
    const fs::path& model = models[std::size_t(i)];
    try {
      const Film film = engine.renderer.render(spec_of(model, arguments), Deadline(kModelTime));
      picture.put(i, film.image);
      std::set<std::string> codes;
      for (const Note& note : film.notes) codes.insert(api::quoted(note.code, note.code.size()));
      tell_cell(i, columns, model, codes, {});
    } catch (const Error& error) {
      ++failures;
      tell_cell(i, columns, model, {},
                error.pointer.empty() ? error.message : error.pointer + ": " + error.message);
    }
  }
  write_file_atomically(arguments.output, encode_png(picture.image(), {}));
  return failures == 0 ? kDone : kFailed;
}

}  // namespace

Command sheet_command(CLI::App& root) {
  CLI::App* command = root.add_subcommand("sheet", "Draws many models into one picture, and lists its cells");
  const auto arguments = std::make_shared<Arguments>();
  arguments->config = local_config();
  command->add_option("inputs", arguments->inputs, "models, or folders that are searched for models")
      ->required();
  command
      ->add_option("-o,--output", arguments->output, "OUT.png; a cell stays transparent where a model failed")
      ->required();
  command->add_option("--cell", arguments->cell_px, "width and height of a model's picture, px")
      ->check(CLI::Range(16, 2048));
  command->add_option("--columns", arguments->columns, "else as many as rows")->check(CLI::Range(1, 1000));
  command->add_option("--environment", arguments->environment, "the name of a built-in environment")
      ->check(CLI::IsMember(builtin_environment_names()));
  add_decoder_option(*command, arguments->config);
  return {command, [arguments] { return sheet(*arguments); }};
}

}  // namespace furnace
