#include "api/model_report.hpp"

#include <array>
#include <charconv>
#include <numbers>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace furnace::api {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Report = ModelReport;

constexpr std::array<std::string_view, 7> kModes{"points",    "lines",          "line-loop",   "line-strip",
                                                 "triangles", "triangle-strip", "triangle-fan"};

std::string_view alpha_mode_name(AlphaMode mode) {
  return mode == AlphaMode::kOpaque ? "OPAQUE" : mode == AlphaMode::kMask ? "MASK" : "BLEND";
}

std::string_view topology_name(Topology topology) {
  return topology == Topology::kPoints ? "points" : topology == Topology::kLines ? "lines" : "triangles";
}

std::string_view light_kind_name(const std::optional<LightKind>& kind) {
  if (!kind) return "unknown";
  return *kind == LightKind::kDirectional ? "directional" : *kind == LightKind::kSpot ? "spot" : "point";
}

std::string_view wrap_name(Wrap wrap) {
  return wrap == Wrap::kRepeat           ? "repeat"
         : wrap == Wrap::kMirroredRepeat ? "mirrored-repeat"
                                         : "clamp-to-edge";
}

// The shortest decimal of the float itself: 0.1, not 0.10000000149.
double shortest(float value) {
  const std::string text = fmt::format("{}", value);
  double number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

OrderedJson vector_json(const glm::vec3& v) {
  return {shortest(v.x), shortest(v.y), shortest(v.z)};
}

OrderedJson bounds_json(const Bounds& bounds) {
  return {{"min", vector_json(bounds.min)}, {"max", vector_json(bounds.max)}};
}

void put_text(OrderedJson& json, const char* key, std::string_view text) {
  if (!text.empty()) json[key] = text;
}

void put_count(OrderedJson& json, const char* key, std::int64_t count) {
  if (count != 0) json[key] = count;
}

template <class T>
void put(OrderedJson& json, const char* key, const std::optional<T>& value) {
  if (value) json[key] = *value;
}

// Writes lists and remembers which were cut. Threads: one. Owns: the row "more".
class Writer {
 public:
  template <class T, class Make>
  OrderedJson list(const std::string& pointer, const ReportList<T>& list, Make&& make) {
    OrderedJson json = OrderedJson::array();
    for (std::size_t i = 0; i < list.items.size(); ++i)
      json.push_back(make(list.items[i], fmt::format("{}/{}", pointer, i)));
    if (list.more > 0) more_[pointer] = list.more;
    return json;
  }
  template <class T>
  OrderedJson list(const std::string& pointer, const ReportList<T>& plain) {
    return list(pointer, plain, [](const T& item, const std::string&) { return OrderedJson(item); });
  }
  const OrderedJson& more() const { return more_; }

  OrderedJson primitive(const Report::Primitive& primitive, const std::string& pointer) {
    OrderedJson json = {{"mode", kModes[static_cast<std::size_t>(primitive.mode)]},
                        {"vertices", primitive.vertices},
                        {std::string(topology_name(primitive.topology)), primitive.elements}};
    put(json, "indices", primitive.index_component);
    json["attributes"] = list(pointer + "/attributes", primitive.attributes,
                              [](const Report::Attribute& attribute, const std::string&) {
                                OrderedJson row = {{"semantic", attribute.semantic},
                                                   {"type", attribute.type},
                                                   {"component", attribute.component}};
                                if (attribute.normalized) row["normalized"] = true;
                                return row;
                              });
    put_count(json, "morphTargets", primitive.morph_targets);
    put(json, "material", primitive.material);
    if (primitive.declared) json["declaredBounds"] = bounds_json(*primitive.declared);
    if (primitive.bounds) json["bounds"] = bounds_json(*primitive.bounds);
    return json;
  }

  OrderedJson mesh(const Report::MeshInfo& mesh, const std::string& pointer) {
    OrderedJson json = OrderedJson::object();
    put_text(json, "name", mesh.name);
    json["nodes"] = mesh.nodes;
    json["primitives"] =
        list(pointer + "/primitives", mesh.primitives,
             [&](const Report::Primitive& item, const std::string& at) { return primitive(item, at); });
    return json;
  }

  OrderedJson material(const Report::MaterialInfo& material, const std::string& pointer) {
    OrderedJson json = OrderedJson::object();
    put_text(json, "name", material.name);
    json["alphaMode"] = alpha_mode_name(material.alpha_mode);
    json["doubleSided"] = material.double_sided;
    json["extensions"] = list(pointer + "/extensions", material.extensions);
    json["textures"] = list(pointer + "/textures", material.textures,
                            [](const Report::TextureUseInfo& use, const std::string&) {
                              OrderedJson row = {{"use", use.use}, {"texture", use.texture}};
                              put(row, "image", use.image);
                              row["uvSet"] = use.uv_set;
                              if (use.transformed) row["transformed"] = true;
                              return row;
                            });
    return json;
  }

  OrderedJson animation(const Report::AnimationInfo& animation, const std::string& pointer) {
    OrderedJson json = OrderedJson::object();
    put_text(json, "name", animation.name);
    json["durationSeconds"] = shortest(static_cast<float>(animation.duration_s));
    json["channels"] = list(pointer + "/channels", animation.channels,
                            [](const Report::ChannelInfo& channel, const std::string&) {
                              OrderedJson row = OrderedJson::object();
                              row["target"] = channel.target;
                              row["interpolation"] = channel.interpolation;
                              row["keyframes"] = channel.keyframes;
                              return row;
                            });
    return json;
  }

 private:
  OrderedJson more_ = OrderedJson::object();
};

OrderedJson asset_json(const Report::Asset& asset) {
  OrderedJson json = {{"container", asset.container}};
  put_text(json, "version", asset.version);
  put_text(json, "generator", asset.generator);
  put_text(json, "copyright", asset.copyright);
  return json;
}

OrderedJson texture_json(const Report::TextureInfo& texture, const std::string&) {
  OrderedJson json = OrderedJson::object();
  put_text(json, "name", texture.name);
  put(json, "image", texture.image);
  const SamplerDesc& sampler = texture.sampler;
  json["wrap"] = {wrap_name(sampler.wrap_u), wrap_name(sampler.wrap_v)};
  json["filter"] = sampler.mag == Filter::kNearest ? "nearest" : "linear";
  json["mipMaps"] = sampler.mip != MipFilter::kNone;
  return json;
}

OrderedJson image_json(const Report::ImageInfo& image, const std::string&) {
  OrderedJson json = OrderedJson::object();
  put_text(json, "name", image.name);
  put_text(json, "uri", image.uri);
  put(json, "bufferView", image.buffer_view);
  put_text(json, "mediaType", image.media_type);
  if (image.missing) {
    json["missing"] = true;
    return json;
  }
  json["format"] = image.format.empty() ? "unknown" : image.format;
  put_count(json, "width", image.width);
  put_count(json, "height", image.height);
  put_count(json, "channels", image.channels);
  put_count(json, "bitDepth", image.bits);
  json["encodedBytes"] = image.encoded_bytes;
  put_count(json, "decodedBytes", image.decoded_bytes);
  put_count(json, "gpuBytes", image.gpu_bytes);
  return json;
}

OrderedJson camera_json(const CameraNode& camera, const std::string&) {
  OrderedJson json = OrderedJson::object();
  put_text(json, "name", camera.name);
  json["type"] = camera.orthographic ? "orthographic" : "perspective";
  if (camera.orthographic) {
    json["widthMetres"] = 2 * camera.half_width;
    json["heightMetres"] = 2 * camera.half_height;
  } else {
    json["fovYDegrees"] = shortest(static_cast<float>(camera.fov_y_rad * 180 / std::numbers::pi));
    put(json, "aspectRatio", camera.aspect_ratio);
  }
  json["nearMetres"] = camera.z_near;
  put(json, "farMetres", camera.z_far);
  return json;
}

OrderedJson drawn_json(const Report::Drawn& drawn) {
  OrderedJson json = OrderedJson::object();
  put(json, "scene", drawn.scene);
  put(json, "variant", drawn.variant);
  json["nodes"] = drawn.nodes;
  json["instances"] = drawn.instances;
  json["meshes"] = drawn.meshes;
  json["materials"] = drawn.materials;
  json["images"] = drawn.images;
  json["vertices"] = drawn.vertices;
  json["triangles"] = drawn.triangles;
  json["lines"] = drawn.lines;
  json["points"] = drawn.points;
  if (!drawn.bounds.empty()) json["bounds"] = bounds_json(drawn.bounds);
  return json;
}

OrderedJson bytes_json(const Report::Bytes& bytes) {
  return {{"document", bytes.document},
          {"json", bytes.json},
          {"buffers", bytes.buffers},
          {"imagesEncoded", bytes.images_encoded},
          {"imagesDecoded", bytes.images_decoded},
          {"imagesGpu", bytes.images_gpu},
          {"meshes", bytes.meshes}};
}

OrderedJson unused_json(const Report::Unused& unused, Writer& writer) {
  OrderedJson json = OrderedJson::object();
  const auto add = [&](const char* key, const ReportList<int>& indices) {
    if (indices.size() > 0) json[key] = writer.list(fmt::format("/unused/{}", key), indices);
  };
  add("nodes", unused.nodes);
  add("meshes", unused.meshes);
  add("materials", unused.materials);
  add("textures", unused.textures);
  add("images", unused.images);
  add("skins", unused.skins);
  add("cameras", unused.cameras);
  add("accessors", unused.accessors);
  add("bufferViews", unused.buffer_views);
  return json;
}

OrderedJson scenes_json(const Report& report, Writer& writer) {
  int index = 0;
  return writer.list("/scenes", report.scenes, [&](const Report::SceneInfo& scene, const std::string&) {
    OrderedJson json = OrderedJson::object();
    put_text(json, "name", scene.name);
    json["nodes"] = scene.nodes;
    if (report.default_scene == index++) json["default"] = true;
    return json;
  });
}

OrderedJson skin_json(const Report::SkinInfo& skin, const std::string&) {
  OrderedJson json = OrderedJson::object();
  put_text(json, "name", skin.name);
  json["joints"] = skin.joints;
  return json;
}

OrderedJson light_json(const Report::LightInfo& light, const std::string&) {
  OrderedJson json = OrderedJson::object();
  put_text(json, "name", light.name);
  json["type"] = light_kind_name(light.kind);
  return json;
}

OrderedJson notes_json(const std::vector<Note>& notes) {
  OrderedJson list = OrderedJson::array();
  for (const Note& note : notes)
    list.push_back({{"code", note.code}, {"pointer", note.pointer}, {"message", note.message}});
  return list;
}

}  // namespace

std::string model_report_json(const ModelReport& report) {
  Writer writer;
  OrderedJson json = {{"hash", report.hash.hex()},
                      {"asset", asset_json(report.asset)},
                      {"drawn", drawn_json(report.drawn)},
                      {"notes", notes_json(report.notes)}};
  json["scenes"] = scenes_json(report, writer);
  json["nodes"] = report.nodes;
  json["vertices"] = report.vertices;
  json["meshes"] =
      writer.list("/meshes", report.meshes,
                  [&](const Report::MeshInfo& mesh, const std::string& at) { return writer.mesh(mesh, at); });
  json["materials"] = writer.list(
      "/materials", report.materials,
      [&](const Report::MaterialInfo& item, const std::string& at) { return writer.material(item, at); });
  json["textures"] = writer.list("/textures", report.textures, texture_json);
  json["images"] = writer.list("/images", report.images, image_json);
  json["animations"] = writer.list(
      "/animations", report.animations,
      [&](const Report::AnimationInfo& item, const std::string& at) { return writer.animation(item, at); });
  json["skins"] = writer.list("/skins", report.skins, skin_json);
  json["cameras"] = writer.list("/cameras", report.cameras, camera_json);
  json["lights"] = writer.list("/lights", report.lights, light_json);
  json["variants"] = writer.list("/variants", report.variants);
  json["extensions"] = {
      {"used", writer.list("/extensions/used", report.extensions.used)},
      {"required", writer.list("/extensions/required", report.extensions.required)},
      {"unsupported", writer.list("/extensions/unsupported", report.extensions.unsupported)}};
  json["missingFiles"] = writer.list("/missingFiles", report.missing_files);
  json["bytes"] = bytes_json(report.bytes);
  json["unused"] = unused_json(report.unused, writer);
  if (!writer.more().empty()) json["more"] = writer.more();
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace furnace::api
