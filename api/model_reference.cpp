#include "api/model_reference.hpp"

#include <algorithm>
#include <utility>

#include "renderer/scene/model_import.hpp"

namespace furnace::api {
namespace {

// The MTL file of an OBJ names textures from where it lies itself.
bool is_used(const ModelBundle& model, const std::string& name) {
  const auto is_meant = [&](const auto& sibling) {
    return name == sibling.first ||
           (model.format == ModelFormat::kObj && name.ends_with('/' + sibling.first));
  };
  return std::any_of(model.siblings.begin(), model.siblings.end(), is_meant);
}

std::string named_by(const ModelBundle& model) {
  constexpr std::size_t kMostShown = 10;
  std::vector<std::string> names = model_siblings(model.document, model.format, {});
  if (names.empty()) return "it names none";
  const bool more = names.size() > kMostShown;
  names.resize(std::min(names.size(), kMostShown));
  for (std::string& name : names) name = api::quoted(name);
  return fmt::format("it names {}{}", fmt::join(names, ", "), more ? ", ..." : "");
}

}  // namespace

std::shared_ptr<const ModelBundle> read_model_reference(const Value& model, const Value& files,
                                                        const AssetResolver& assets, Faults& faults) {
  NamedFiles named;
  const auto wanted = files.members();
  for (const auto& file : wanted) {
    faults.collect(file.second, [&] {
      named.emplace(file.first, assets.read(std::string(file.second.text()), file.second.pointer()));
    });
  }
  std::shared_ptr<const ModelBundle> bundle;
  faults.collect(model,
                 [&] { bundle = assets.read_model(std::string(model.text()), model.pointer(), named); });
  if (!bundle || named.size() < wanted.size()) return nullptr;
  for (const auto& file : wanted) {
    if (is_used(*bundle, file.first)) continue;
    faults.add(ErrorCode::kUnprocessable, file.second,
               fmt::format("the model names no such file; {}", named_by(*bundle)));
  }
  return bundle;
}

}  // namespace furnace::api
