#include "renderer/scene/gltf_about.hpp"

#include <algorithm>

#include "renderer/scene/gltf_read.hpp"

namespace furnace {

namespace {

// A text member, or nothing.
std::string text_of(const Json& object, const char* key) {
  if (!object.is_object()) return {};
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

const Json& member(const Json& object, const char* key) {
  static const Json nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(key);
  return found == object.end() ? nothing : *found;
}

const Json& array_member(const Json& object, const char* key) {
  static const Json nothing = Json::array();
  const Json& value = member(object, key);
  return value.is_array() ? value : nothing;
}

std::vector<std::string> texts_of(const Json& list, const char* key) {
  std::vector<std::string> texts;
  for (const Json& item : list) texts.push_back(text_of(item, key));
  return texts;
}

std::vector<double> numbers_of(const Json& list, std::size_t count) {
  std::vector<double> numbers;
  if (!list.is_array() || list.size() != count) return numbers;
  for (const Json& number : list) {
    if (!number.is_number()) return {};
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

std::vector<std::string> keys_of(const Json& object) {
  std::vector<std::string> keys;
  if (!object.is_object()) return keys;
  for (auto item = object.begin(); item != object.end(); ++item) keys.push_back(item.key());
  std::sort(keys.begin(), keys.end());
  return keys;
}

// Every number "bufferView" below `root`. Without recursion: depth is the document's.
std::vector<int> views_below(const Json& root, std::size_t views) {
  std::vector<int> found;
  std::vector<const Json*> open = {&root};
  while (!open.empty()) {
    const Json& value = *open.back();
    open.pop_back();
    const Json& view = member(value, "bufferView");
    if (view.is_number_unsigned() && view.get<std::uint64_t>() < views)
      found.push_back(static_cast<int>(view.get<std::uint64_t>()));
    if (!value.is_structured()) continue;
    for (const Json& child : value) open.push_back(&child);
  }
  return found;
}

}  // namespace

GltfAbout read_gltf_about(const Blob& bytes, const GltfDocument& document) {
  const GltfContainer container = open_gltf_container(bytes);
  const Json root = parse_json(bytes.text().substr(container.json.offset, container.json.size));
  GltfAbout about;
  const Json& asset = member(root, "asset");
  about.asset = {text_of(asset, "version"), text_of(asset, "generator"), text_of(asset, "copyright")};
  for (const Json& name : array_member(root, "extensionsRequired"))
    if (name.is_string()) about.extensions_required.push_back(name.get<std::string>());
  for (const auto& [name, pointer] : undeclared_extensions(root)) about.extensions_undeclared.push_back(name);
  about.scene_names = texts_of(array_member(root, "scenes"), "name");
  about.skin_names = texts_of(array_member(root, "skins"), "name");
  about.texture_names = texts_of(array_member(root, "textures"), "name");
  about.image_names = texts_of(array_member(root, "images"), "name");
  about.image_media_types = texts_of(array_member(root, "images"), "mimeType");
  for (const Json& material : array_member(root, "materials"))
    about.material_extensions.push_back(keys_of(member(material, "extensions")));
  const Json& accessors = array_member(root, "accessors");
  for (std::size_t i = 0; i < accessors.size(); ++i) {
    const auto components = static_cast<std::size_t>(component_count(document.accessors[i].type));
    about.ranges.push_back({numbers_of(member(accessors[i], "min"), components),
                            numbers_of(member(accessors[i], "max"), components)});
  }
  for (const char* place : {"meshes", "nodes", "materials", "textures", "extensions"})
    for (const int view : views_below(member(root, place), document.buffer_views.size()))
      about.extension_views.push_back(view);
  return about;
}

}  // namespace furnace
