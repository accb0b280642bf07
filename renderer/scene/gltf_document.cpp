#include "renderer/scene/gltf_document.hpp"

#include <algorithm>

#include "renderer/scene/gltf_container.hpp"
#include "renderer/scene/gltf_read.hpp"
#include "renderer/scene/model_format.hpp"

namespace furnace {

namespace {

template <class T>
bool contains(const std::vector<T>& list, std::string_view name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

// "2.0" -> {2, 0}
struct Version {
  int major = 0, minor = 0;
};

Version read_version(const JsonObject& asset, std::string_view key) {
  const std::string text = asset.required_string(key);
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const std::size_t dot = text.find('.');
  const bool well_formed = dot != std::string::npos && dot > 0 && dot < 4 && text.size() > dot + 1 &&
                           text.size() < dot + 5 && std::all_of(text.begin(), text.begin() + dot, is_digit) &&
                           std::all_of(text.begin() + dot + 1, text.end(), is_digit);
  if (!well_formed) asset.refuse(key, "must be a version like \"2.0\"");
  return {std::stoi(text.substr(0, dot)), std::stoi(text.substr(dot + 1))};
}

void check_version(const JsonObject& root) {
  const JsonObject asset = root.required_object("asset");
  if (read_version(asset, "version").major != 2) asset.refuse("version", "only glTF 2.x is read");
  if (!asset.has("minVersion")) return;
  const Version least = read_version(asset, "minVersion");
  if (least.major != 2 || least.minor > 0) asset.refuse("minVersion", "only glTF 2.0 is read");
}

void check_required_extensions(const JsonObject& root) {
  const std::vector<std::string_view> supported = supported_gltf_extensions();
  const std::vector<std::string> required = root.strings("extensionsRequired");
  for (std::size_t i = 0; i < required.size(); ++i) {
    if (contains(supported, required[i])) continue;
    fail(ErrorCode::kUnprocessable,
         "the model requires the extension " + shortened(required[i]) + ", which is not supported",
         root.pointer_to("extensionsRequired") + "/" + std::to_string(i));
  }
}

GltfCounts count_objects(const JsonObject& root) {
  const auto lights = root.extension("KHR_lights_punctual");
  const auto variants = root.extension("KHR_materials_variants");
  return {root.size_of("buffers"),
          root.size_of("bufferViews"),
          root.size_of("accessors"),
          root.size_of("images"),
          root.size_of("samplers"),
          root.size_of("textures"),
          root.size_of("materials"),
          root.size_of("meshes"),
          root.size_of("skins"),
          root.size_of("cameras"),
          root.size_of("nodes"),
          root.size_of("scenes"),
          lights ? lights->size_of("lights") : 0,
          variants ? variants->size_of("variants") : 0};
}

template <class T, class Read>
std::vector<T> read_all(const JsonObject& root, std::string_view key, Read&& read) {
  std::vector<T> result;
  result.reserve(static_cast<std::size_t>(root.size_of(key)));
  root.each(key, [&](const JsonObject& json) { result.push_back(read(json)); });
  return result;
}

void check_buffer_sizes(const GltfDocument& document, const ImportLimits& limits) {
  std::uint64_t total = 0;
  for (const GltfBuffer& buffer : document.buffers) {
    total += std::min(buffer.byte_length, std::uint64_t{1} << 50);
    if (total > static_cast<std::uint64_t>(limits.max_buffer_bytes)) {
      fail(ErrorCode::kTooLarge,
           "the buffers together exceed the limit of " + std::to_string(limits.max_buffer_bytes) + " bytes",
           "/buffers");
    }
  }
}

// Accessors whose numbers a compressed mesh brings.
std::vector<bool> decoded_accessors(const GltfDocument& document) {
  std::vector<bool> decoded(document.accessors.size(), false);
  for (const GltfMesh& mesh : document.meshes) {
    for (const GltfPrimitive& primitive : mesh.primitives) {
      if (!primitive.draco) continue;
      if (primitive.indices) decoded[static_cast<std::size_t>(*primitive.indices)] = true;
      for (const auto& [semantic, id] : primitive.draco->attributes) {
        decoded[static_cast<std::size_t>(primitive.attributes.at(semantic))] = true;
      }
    }
  }
  return decoded;
}

void check_implied_elements(const GltfDocument& document) {
  const std::vector<bool> decoded = decoded_accessors(document);
  std::uint64_t implied = 0;
  for (std::size_t i = 0; i < document.accessors.size(); ++i) {
    const GltfAccessor& accessor = document.accessors[i];
    if (accessor.buffer_view || decoded[i]) continue;
    implied += std::min(accessor.count, kMaxImpliedElements + 1);
    if (implied > kMaxImpliedElements) {
      fail(ErrorCode::kTooLarge, "accessors without a bufferView have too many elements",
           "/accessors/" + std::to_string(i) + "/count");
    }
  }
}

}  // namespace

std::size_t component_bytes(ComponentType type) {
  switch (type) {
    case ComponentType::kByte:
    case ComponentType::kUnsignedByte:
      return 1;
    case ComponentType::kShort:
    case ComponentType::kUnsignedShort:
      return 2;
    case ComponentType::kUnsignedInt:
    case ComponentType::kFloat:
      return 4;
  }
  return 4;
}

int component_count(ElementType type) {
  constexpr std::array<int, 7> counts{1, 2, 3, 4, 4, 9, 16};
  return counts[static_cast<std::size_t>(type)];
}

std::size_t element_bytes(ElementType type, ComponentType component) {
  const std::size_t size = component_bytes(component);
  // glTF 2.0, section 3.6.2.4: each column of a matrix starts on a multiple of 4 bytes.
  const auto column = [&](std::size_t rows) { return (rows * size + 3) / 4 * 4; };
  switch (type) {
    case ElementType::kMat2:
      return 2 * column(2);
    case ElementType::kMat3:
      return 3 * column(3);
    case ElementType::kMat4:
      return 4 * column(4);
    default:
      return static_cast<std::size_t>(component_count(type)) * size;
  }
}

std::uint64_t span_bytes(std::uint64_t count, std::uint64_t stride, ElementType type,
                         ComponentType component) {
  if (count == 0) return 0;
  const std::size_t rows = type == ElementType::kMat2 ? 2 : type == ElementType::kMat3 ? 3 : 4;
  // The padding after a matrix's last column may be missing at the end.
  const std::size_t padding = type < ElementType::kMat2 ? 0 : (4 - rows * component_bytes(component) % 4) % 4;
  return stride * (count - 1) + element_bytes(type, component) - padding;
}

// Whatever is no other format comes here.
void check_is_gltf(std::string_view document) {
  const std::string_view text = without_mark(document);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != text.npos && (text[first] == '{' || text[first] == '[' || text.starts_with("glTF"))) return;
  const std::string_view known = foreign_format(text);
  fail(ErrorCode::kUnprocessable, "is no model that is read here (glTF, GLB, OBJ, STL or PLY)" +
                                      (first == text.npos ? ": it is empty"
                                       : known.empty()    ? ""
                                                          : ": it is " + std::string(known)));
}

GltfJson parse_gltf(const Blob& bytes, const ImportLimits& limits) {
  check_is_gltf(bytes.text());
  const GltfContainer container = open_gltf_container(bytes);
  if (container.json.size > static_cast<std::size_t>(limits.max_json_bytes)) {
    fail(ErrorCode::kTooLarge,
         "the JSON exceeds the limit of " + std::to_string(limits.max_json_bytes) + " bytes");
  }
  return {parse_json(bytes.text().substr(container.json.offset, container.json.size)), container.binary};
}

GltfDocument read_gltf_document(const Blob& bytes, const ImportLimits& limits) {
  return read_gltf_document(parse_gltf(bytes, limits), limits);
}

GltfDocument read_gltf_document(const GltfJson& json, const ImportLimits& limits) {
  const JsonObject root(json.root, "");
  check_version(root);
  check_required_extensions(root);
  const GltfCounts counts = count_objects(root);
  if (counts.nodes > limits.max_nodes) {
    fail(ErrorCode::kTooLarge, "more than " + std::to_string(limits.max_nodes) + " nodes", "/nodes");
  }

  GltfDocument document;
  document.binary = json.binary;
  document.extensions_used = root.strings("extensionsUsed");
  document.quantized = contains(document.extensions_used, "KHR_mesh_quantization");
  document.buffers = read_all<GltfBuffer>(root, "buffers", read_buffer);
  document.buffer_views = read_all<GltfBufferView>(root, "bufferViews", [&](const JsonObject& object) {
    return read_buffer_view(object, document.buffers);
  });
  document.accessors = read_all<GltfAccessor>(root, "accessors", [&](const JsonObject& object) {
    return read_accessor(object, document.buffer_views);
  });
  check_buffer_sizes(document, limits);

  document.images = read_all<GltfImage>(root, "images",
                                        [&](const JsonObject& object) { return read_image(object, counts); });
  const auto samplers = read_all<SamplerDesc>(root, "samplers", read_sampler);
  document.textures = read_all<GltfTexture>(
      root, "textures", [&](const JsonObject& object) { return read_texture(object, counts, samplers); });
  document.materials = read_all<GltfMaterial>(
      root, "materials", [&](const JsonObject& object) { return read_material(object, counts); });
  if (const auto variants = root.extension("KHR_materials_variants"))
    document.variants = read_all<std::string>(
        *variants, "variants", [](const JsonObject& object) { return object.required_string("name"); });

  document.meshes =
      read_all<GltfMesh>(root, "meshes", [&](const JsonObject& object) { return read_mesh(object, counts); });
  document.skins =
      read_all<GltfSkin>(root, "skins", [&](const JsonObject& object) { return read_skin(object, counts); });
  document.cameras = read_all<CameraNode>(root, "cameras", read_camera);
  if (const auto lights = root.extension("KHR_lights_punctual"))
    document.lights = read_all<std::optional<Light>>(*lights, "lights", [&](const JsonObject& object) {
      return read_light(object, document.light_notes);
    });
  document.nodes =
      read_all<GltfNode>(root, "nodes", [&](const JsonObject& object) { return read_node(object, counts); });
  link_nodes(document.nodes, limits);
  document.scenes = read_all<GltfScene>(
      root, "scenes", [&](const JsonObject& object) { return read_scene(object, document.nodes); });
  document.animations = read_all<GltfAnimation>(
      root, "animations", [&](const JsonObject& object) { return read_animation(object, counts); });
  check_implied_elements(document);
  document.default_scene = root.reference("scene", "scene", counts.scenes);
  return document;
}

}  // namespace furnace
