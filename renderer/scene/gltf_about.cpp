#include "renderer/scene/gltf_about.hpp"

#include <algorithm>

#include "renderer/scene/gltf_json.hpp"

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

GltfInterpolation read_interpolation(const JsonObject& json) {
  const std::string name = json.string("interpolation", "LINEAR");
  if (name == "LINEAR") return GltfInterpolation::kLinear;
  if (name == "STEP") return GltfInterpolation::kStep;
  if (name == "CUBICSPLINE") return GltfInterpolation::kCubicSpline;
  json.refuse("interpolation", "must be LINEAR, STEP or CUBICSPLINE");
}

GltfAnimation read_animation(const JsonObject& json, int accessors, int nodes) {
  GltfAnimation animation;
  json.each("samplers", [&](const JsonObject& sampler) {
    animation.samplers.push_back({sampler.required_reference("input", "accessor", accessors),
                                  sampler.required_reference("output", "accessor", accessors),
                                  read_interpolation(sampler)});
  });
  const int samplers = static_cast<int>(animation.samplers.size());
  json.each("channels", [&](const JsonObject& channel) {
    const JsonObject target = channel.required_object("target");
    animation.channels.push_back({channel.required_reference("sampler", "sampler", samplers),
                                  target.reference("node", "node", nodes), target.required_string("path")});
  });
  return animation;
}

void read_animations(const Json& list, const GltfDocument& document, GltfAbout& about) {
  const int accessors = static_cast<int>(document.accessors.size());
  const int nodes = static_cast<int>(document.nodes.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    GltfAnimation animation;
    try {
      animation = read_animation(JsonObject(list[i], "/animations/" + std::to_string(i)), accessors, nodes);
    } catch (const Error& error) {
      about.notes.push_back({"animation-unreadable", error.pointer, error.message});
    }
    animation.name = text_of(list[i], "name");
    about.animations.push_back(std::move(animation));
  }
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
  read_animations(array_member(root, "animations"), document, about);
  for (const char* place : {"meshes", "nodes", "materials", "textures", "extensions"})
    for (const int view : views_below(member(root, place), document.buffer_views.size()))
      about.extension_views.push_back(view);
  return about;
}

}  // namespace furnace
