#include "api/render_request.hpp"

#include "api/contract.hpp"
#include "api/film_request.hpp"
#include "api/light_request.hpp"
#include "api/material_request.hpp"
#include "api/model_reference.hpp"
#include "api/procedural_request.hpp"
#include "api/request_values.hpp"
#include "api/validate.hpp"
#include "renderer/scene/procedural.hpp"
#include "renderer/scene/transform.hpp"
#include "renderer/base/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace furnace::api {
namespace {

constexpr std::string_view kBuiltin = "builtin:";

std::vector<std::string> strings(const std::vector<std::string_view>& names) {
  return {names.begin(), names.end()};
}

bool is_preset(std::string_view name) {
  return material_preset(name).has_value();
}

class Reader {
 public:
  Reader(const AssetResolver& assets, const RequestLimits& limits) : assets_(assets), limits_(limits) {}

  RenderSpec read_request(const Value& root, OutputFormat unstated_format) {
    RenderSpec spec;
    read_scene(root["scene"], spec.scene);
    read_environment(root["environment"], spec.environment);
    read_camera(root["camera"], spec.camera, faults_);
    spec.output.format = unstated_format;
    read_output(root["output"], limits_, spec.output, faults_);
    read_motion(root["camera"], spec.output.sequence, spec.camera.motion, faults_);
    if (const std::string fault = format_fault(spec); !fault.empty())
      faults_.add(ErrorCode::kUnprocessable, root["output"]["format"] ? root["output"]["format"] : root,
                  fault);
    if (const std::string fault = layers_fault(spec.output); !fault.empty())
      faults_.add(ErrorCode::kUnprocessable, root["output"]["layers"], fault);
    if (const std::string fault = sequence_fault(spec); !fault.empty())
      faults_.add(ErrorCode::kUnprocessable, root["output"]["sequence"], fault);
    read(root["strict"], spec.strict);
    faults_.throw_if_any();
    return spec;
  }

 private:
  void read_scene(const Value& scene, SceneSpec& spec) {
    for (const auto& [name, value] : scene["materials"].members())
      spec.materials.emplace(name, read_material(value, assets_, faults_));
    read_shading_model(scene["shadingModel"], spec.shading_model);
    if (const Value model = scene["model"]) read_model(model, scene["files"], spec);
    const Value nodes = scene["nodes"];
    for (std::size_t i = 0; i < nodes.size(); ++i) spec.nodes.push_back(read_node(nodes.at(i), spec));
    const Value lights = scene["lights"];
    for (std::size_t i = 0; i < lights.size(); ++i)
      spec.lights.push_back(read_light(lights.at(i), assets_, faults_));
    read(scene["modelLights"], spec.model_lights);
    if (!scene["model"] && !nodes) spec.nodes.push_back(default_node(kDefaultMesh));
    read(scene["gltfScene"], spec.gltf_scene);
    read(scene["variant"], spec.variant);
    read_animations(scene, spec);
    static constexpr Choice<UpAxis> kUpAxes[] = {{"y", UpAxis::kY}, {"z", UpAxis::kZ}};
    if (const Value up = scene["upAxis"]) read_choice(up, kUpAxes, spec.up_axis.emplace());
    check_model_fields(scene, spec);
  }

  // A file that could not be read has been told, and has no format.
  void check_model_fields(const Value& scene, const SceneSpec& spec) {
    const Value model = scene["model"];
    const bool is_file = model && !model.text().starts_with(kBuiltin);
    const bool is_gltf = is_file && (!spec.model || spec.model->format == ModelFormat::kGltf);
    const bool is_other = is_file && (!spec.model || spec.model->format != ModelFormat::kGltf);
    const auto needs = [&](const char* key, bool has, std::string_view what) {
      if (scene[key] && !has)
        faults_.add(ErrorCode::kUnprocessable, scene[key],
                    fmt::format("needs {} as \"model\"; leave it out or name one", what));
    };
    needs("gltfScene", is_gltf, "a glTF file");
    needs("variant", is_gltf, "a glTF file");
    needs("animation", is_gltf, "a glTF file");
    needs("animations", is_gltf, "a glTF file");
    needs("upAxis", is_other, "an OBJ, STL or PLY file");
    needs("files", is_file, "a file");
  }

  void read_animations(const Value& scene, SceneSpec& spec) {
    const Value one = scene["animation"], several = scene["animations"];
    if (one) spec.animations.push_back(read_clip(one));
    if (one && several)
      faults_.add(ErrorCode::kUnprocessable, several, "stands in place of \"animation\"; leave one out");
    for (std::size_t i = 0; i < several.size(); ++i) spec.animations.push_back(read_clip(several.at(i)));
  }

  AnimationClip read_clip(const Value& value) {
    AnimationClip clip;
    if (const Value name = value["name"]) clip.which = std::string(name.text());
    if (const Value index = value["index"]) read(index, clip.which.emplace<int>());
    if (value["name"] && value["index"])
      faults_.add(ErrorCode::kUnprocessable, value["index"], "stands in place of \"name\"; leave one out");
    read(value["timeSeconds"], clip.time.seconds);
    read(value["loop"], clip.time.loop);
    return clip;
  }

  static NodeSpec default_node(std::string_view mesh) {
    NodeSpec node;
    node.mesh = mesh;
    node.material = kDefaultPreset;
    return node;
  }

  void read_model(const Value& model, const Value& files, SceneSpec& spec) {
    if (const auto name = builtin_name(model, builtin_mesh_names(), "mesh"))
      spec.nodes.push_back(default_node(*name));
    else if (!model.text().starts_with(kBuiltin))
      spec.model = read_model_reference(model, files, assets_, faults_);
  }

  // The name after "builtin:", or none for another scheme or (told) an unknown name.
  std::optional<std::string> builtin_name(const Value& reference, const std::vector<std::string_view>& known,
                                          std::string_view noun) {
    std::string_view name = reference.text();
    if (!name.starts_with(kBuiltin)) return std::nullopt;
    name.remove_prefix(kBuiltin.size());
    if (std::find(known.begin(), known.end(), name) != known.end()) return std::string(name);
    faults_.add(ErrorCode::kUnprocessable, reference,
                fmt::format("there is no built-in {} {}{} (built in: {})", noun, api::quoted(name),
                            did_you_mean(name, strings(known)), fmt::join(known, ", ")));
    return std::nullopt;
  }

  NodeSpec read_node(const Value& value, const SceneSpec& scene) {
    NodeSpec node;
    node.mesh = value["mesh"].text().substr(kBuiltin.size());  // one of the schema's names
    read(value["name"], node.name);
    read(value["material"], node.material);
    if (node.material && !faults_.full()) check_material_name(value["material"], scene);
    read(value["translation"], node.translation);
    read(value["scale"], node.scale);
    if (const Value rotation = value["rotation"]) node.rotation = read_rotation(rotation, faults_);
    return node;
  }

  void check_material_name(const Value& material, const SceneSpec& scene) {
    const std::string name(material.text());
    if (scene.materials.contains(name) || is_preset(name)) return;
    std::vector<std::string> known = strings(material_preset_names());
    for (const auto& [key, unused] : scene.materials) known.push_back(key);
    faults_.add(ErrorCode::kUnprocessable, material,
                fmt::format("{} is neither in scene.materials nor a preset{}", api::quoted(name),
                            did_you_mean(name, known)));
  }

  void read_environment(const Value& value, EnvironmentSpec& spec) {
    if (const Value map = value["map"]) read_map(map, spec.map);
    read_layout(value, spec.map);
    read_degrees(value["rotationDegrees"], spec.rotation_rad);
    read(value["intensity"], spec.intensity);
    read(value["illuminanceLux"], spec.illuminance_lux);
    static constexpr Choice<SunMode> kSuns[] = {
        {"auto", SunMode::kAuto}, {"keep", SunMode::kKeep}, {"extract", SunMode::kExtract}};
    read_choice(value["sun"], kSuns, spec.sun);
    static constexpr Choice<EnvironmentVisibility> kVisibilities[] = {{"auto", EnvironmentVisibility::kAuto},
                                                                      {"on", EnvironmentVisibility::kOn},
                                                                      {"off", EnvironmentVisibility::kOff}};
    read_choice(value["visibility"], kVisibilities, spec.visibility);
    read_background(value["background"], spec.background);
    if (const Value ground = value["ground"]) read_ground(ground, spec.ground.emplace());
    if (const Value projection = value["ground"]["projection"];
        projection && !std::holds_alternative<EnvironmentBackground>(spec.background))
      faults_.add(ErrorCode::kUnprocessable, projection,
                  "projects the environment, which this background does not show; leave it out");
  }

  void read_background(const Value& value, BackgroundSpec& spec) {
    const Value type = value["type"];
    const std::string_view kind = type ? type.text() : "environment";
    if (kind == "environment") {
      auto& background = spec.emplace<EnvironmentBackground>();
      if (const Value map = value["map"]) read_map(map, background.map.emplace());
      EnvironmentMapSpec no_file = BuiltinName{};
      read_layout(value, background.map ? *background.map : no_file);
      if (const Value rotation = value["rotationDegrees"])
        read_degrees(rotation, background.rotation_rad.emplace());
      read(value["intensity"], background.intensity);
      read_degrees(value["blurDegrees"], background.blur_rad);
    } else if (kind == "color") {
      read(value["color"], spec.emplace<ColorBackground>().color);
    } else if (kind == "gradient") {
      auto& gradient = spec.emplace<GradientBackground>();
      read(value["top"], gradient.top);
      read(value["bottom"], gradient.bottom);
    } else {
      FURNACE_CHECK(kind == "transparent", "{} is not handled", kind);
      spec.emplace<TransparentBackground>();
    }
  }

  void read_ground(const Value& value, GroundSpec& spec) {
    read(value["shadow"], spec.shadow);
    read(value["shadowStrength"], spec.shadow_strength);
    read(value["levelMetres"], spec.level_m);
    if (const Value projection = value["projection"]) {
      auto& to = spec.projection.emplace();
      read(projection["heightMetres"], to.height_m);
      // So near that the horizon lies a little low, so far that the floor reaches well round the scene.
      constexpr double kRadiusOfHeight = 12;
      to.radius_m = kRadiusOfHeight * to.height_m;
      read(projection["radiusMetres"], to.radius_m);
      if (to.radius_m <= to.height_m)
        faults_.add(
            ErrorCode::kUnprocessable, projection,
            fmt::format("radiusMetres ({}) must be larger than heightMetres ({})", to.radius_m, to.height_m));
    }
  }

  void read_map(const Value& map, EnvironmentMapSpec& spec) {
    if (map.type() == JsonType::kObject) {
      if (auto procedural = read_procedural(map, faults_))
        spec = *std::move(procedural);
      else
        read(map["color"], spec.emplace<EnvironmentColor>().radiance);
    } else if (auto name = builtin_name(map, builtin_environment_names(), "environment")) {
      spec = BuiltinName{std::move(*name)};
    } else if (!map.text().starts_with(kBuiltin)) {
      faults_.collect(map,
                      [&] { spec = EnvironmentFile{assets_.read(std::string(map.text()), map.pointer())}; });
    }
  }

  // Of the map that `value` names.
  void read_layout(const Value& value, EnvironmentMapSpec& map) {
    const Value layout = value["layout"];
    if (!layout) return;
    static constexpr Choice<EnvironmentLayout> kLayouts[] = {
        {"auto", EnvironmentLayout::kAuto},
        {"equirect", EnvironmentLayout::kEquirect},
        {"horizontal-cross", EnvironmentLayout::kHorizontalCross},
        {"vertical-cross", EnvironmentLayout::kVerticalCross},
        {"horizontal-strip", EnvironmentLayout::kHorizontalStrip},
        {"vertical-strip", EnvironmentLayout::kVerticalStrip}};
    EnvironmentLayout read = EnvironmentLayout::kAuto;
    read_choice(layout, kLayouts, read);
    const Value name = value["map"];
    const bool names_file = name && name.type() != JsonType::kObject && !name.text().starts_with(kBuiltin);
    if (auto* file = std::get_if<EnvironmentFile>(&map))
      file->layout = read;
    else if (!names_file)
      faults_.add(ErrorCode::kUnprocessable, layout,
                  "says how a map lies in its file, and the map is none; leave it out");
  }

  const AssetResolver& assets_;
  const RequestLimits& limits_;
  Faults faults_;
};

const FormatRow& row_of(OutputFormat format) {
  const auto* found = std::find_if(kFormats.begin(), kFormats.end(),
                                   [&](const FormatRow& row) { return row.format == format; });
  FURNACE_CHECK(found != kFormats.end(), "no row for format {}", static_cast<int>(format));
  return *found;
}

}  // namespace

std::string_view name_of(OutputFormat format) {
  return row_of(format).name;
}

std::string_view media_type_of(OutputFormat format) {
  return row_of(format).media_type;
}

std::string_view media_type_of(const OutputSpec& output) {
  if (output.sequence && output.sequence->container == Sequence::Container::kArchive) return kZip;
  if (output.sequence && output.format == OutputFormat::kPng) return kAnimatedPng;
  return media_type_of(output.format);
}

int samples_for_quality(std::string_view quality) {
  const auto* found = std::find_if(kQualityLevels.begin(), kQualityLevels.end(),
                                   [&](const QualityLevel& level) { return level.name == quality; });
  FURNACE_CHECK(found != kQualityLevels.end(), "no quality {}", quality);
  return found->samples;
}

RenderSpec parse_render_request(std::string_view json, const AssetResolver& assets,
                                const RequestLimits& limits, OutputFormat unstated_format) {
  static const Schema schema(render_request_schema());
  const Document document = Document::parse(json, {limits.max_json_depth, limits.max_json_bytes});
  fail_if_any(schema.problems(document));
  return Reader(assets, limits).read_request(document.root(), unstated_format);
}

}  // namespace furnace::api
