#include "server/commands/render_options.hpp"

#include <charconv>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "renderer/base/error.hpp"
#include "renderer/image/color.hpp"
#include "api/document.hpp"

namespace furnace {
namespace {

std::string json_text(std::string_view text) {
  return api::quoted(text, text.size());
}

// The members of one JSON object, those that are there.
class Members {
 public:
  void add_raw(std::string_view key, std::string_view json) {
    members_.push_back(fmt::format("\"{}\":{}", key, json));
  }
  void add(std::string_view key, const std::optional<std::string>& text) {
    if (text) add_raw(key, json_text(*text));
  }
  template <class Number>
  void add(std::string_view key, const std::optional<Number>& number) {
    if (number) add_raw(key, fmt::format("{}", *number));
  }
  void add_object(std::string_view key, const Members& members) {
    if (!members.members_.empty()) add_raw(key, members.text());
  }
  std::string text() const { return fmt::format("{{{}}}", fmt::join(members_, ",")); }

 private:
  std::vector<std::string> members_;
};

double linear_of_hex(std::string_view two_digits) {
  int value = 0;
  const auto [end, fault] =
      std::from_chars(two_digits.data(), two_digits.data() + two_digits.size(), value, 16);
  if (fault != std::errc{} || end != two_digits.data() + two_digits.size()) {
    fail(ErrorCode::kUnprocessable, "--background: environment, transparent or a colour such as #e8e4df");
  }
  return linear_from_srgb(value / 255.0);
}

Members background_members(std::string_view background) {
  Members members;
  if (!background.starts_with('#')) {
    members.add("type", std::optional(std::string(background)));
    return members;
  }
  const std::string_view digits = background.substr(1);
  if (digits.size() != 6) linear_of_hex("");
  members.add("type", std::optional<std::string>("color"));
  members.add_raw("color",
                  fmt::format("[{},{},{}]", linear_of_hex(digits.substr(0, 2)),
                              linear_of_hex(digits.substr(2, 2)), linear_of_hex(digits.substr(4, 2))));
  return members;
}

// A name of digits alone is taken for an index.
AnimationClip clip_of(const RenderOptions& options) {
  AnimationClip clip;
  clip.time.seconds = options.time_seconds.value_or(0);
  if (!options.animation) return clip;
  const std::string& name = *options.animation;
  constexpr std::size_t kMostDigits = 6;
  const bool is_index = !name.empty() && name.size() <= kMostDigits &&
                        name.find_first_not_of("0123456789") == std::string::npos;
  if (is_index) {
    clip.which = std::stoi(name);
  } else {
    clip.which = name;
  }
  return clip;
}

bool describes_sequence(const RenderOptions& options) {
  return options.frames || options.frames_per_second || options.turntable_degrees;
}

bool names_clip(const RenderOptions& options) {
  return options.animation || options.time_seconds;
}

// Frames with nothing that is said to move are those of the model's first animation.
bool animates(const RenderOptions& options) {
  return names_clip(options) ||
         ((describes_sequence(options) || options.container) && !options.turntable_degrees);
}

void apply_sequence(const RenderOptions& options, Sequence& sequence) {
  if (options.frames) sequence.frames = options.frames;
  if (options.frames_per_second) sequence.frames_per_second = *options.frames_per_second;
  if (options.turntable_degrees) sequence.turntable_rad = glm::radians(*options.turntable_degrees);
  if (options.container)
    sequence.container =
        *options.container == "zip" ? Sequence::Container::kArchive : Sequence::Container::kAnimation;
}

Members clip_members(const AnimationClip& clip) {
  Members members;
  if (const int* index = std::get_if<int>(&clip.which))
    members.add("index", std::optional(*index));
  else
    members.add("name", std::optional(std::get<std::string>(clip.which)));
  members.add("timeSeconds", std::optional(clip.time.seconds));
  return members;
}

bool turns_camera(const RenderOptions& options) {
  return options.azimuth_degrees || options.elevation_degrees;
}

bool meters(const RenderOptions& options) {
  return options.ev100 || options.aperture || options.shutter_seconds || options.iso || options.auto_exposure;
}

}  // namespace

std::string request_document(const RenderOptions& options, const std::string& model) {
  Members scene, environment, orbit, camera, depth_of_field, motion_blur, output, bloom, sequence, request;
  if (!model.empty()) {
    scene.add("model", std::optional(model));
    scene.add("gltfScene", options.gltf_scene);
    scene.add("variant", options.variant);
    if (animates(options)) scene.add_object("animation", clip_members(clip_of(options)));
    scene.add("upAxis", options.up_axis);
  }
  scene.add("shadingModel", options.shading_model);
  environment.add("map", options.environment);
  environment.add("rotationDegrees", options.rotation_degrees);
  environment.add("sun", options.sun);
  environment.add("visibility", options.visibility);
  Members background;
  if (options.background) background = background_members(*options.background);
  background.add("blurDegrees", options.blur_degrees);
  environment.add_object("background", background);
  if (options.ground) environment.add_raw("ground", "{}");
  orbit.add("azimuthDegrees", options.azimuth_degrees);
  orbit.add("elevationDegrees", options.elevation_degrees);
  camera.add_object("orbit", orbit);
  camera.add("exposureEv", options.exposure_ev);
  camera.add("ev100", options.ev100);
  camera.add("aperture", options.aperture);
  camera.add("shutterSeconds", options.shutter_seconds);
  camera.add("iso", options.iso);
  if (options.auto_exposure) camera.add_raw("autoExposure", "true");
  depth_of_field.add("fStop", options.f_stop);
  depth_of_field.add("focusDistanceMetres", options.focus_distance_m);
  camera.add_object("depthOfField", depth_of_field);
  motion_blur.add("shutterSeconds", options.motion_blur_seconds);
  camera.add_object("motionBlur", motion_blur);
  output.add("width", options.width);
  output.add("height", options.height);
  output.add("format", options.format);
  output.add("bitDepth", options.bit_depth);
  output.add("exrType", options.exr_type);
  output.add("exrCompression", options.exr_compression);
  output.add("compressionQuality", options.compression_quality);
  if (options.lossless) output.add_raw("lossless", "true");
  if (options.dither) output.add_raw("dither", "true");
  output.add("toneMap", options.tone_map);
  output.add("whiteBalanceKelvin", options.white_balance_kelvin);
  output.add("whiteBalanceTint", options.white_balance_tint);
  output.add("contrast", options.contrast);
  output.add("saturation", options.saturation);
  bloom.add("intensity", options.bloom_intensity);
  output.add_object("bloom", bloom);
  output.add("pixelFilter", options.pixel_filter);
  if (!options.layers.empty()) {
    std::vector<std::string> names;
    for (const std::string& layer : options.layers) names.push_back(json_text(layer));
    output.add_raw("layers", fmt::format("[{}]", fmt::join(names, ",")));
  }
  output.add("show", options.show);
  if (!model.empty()) {
    sequence.add("frames", options.frames);
    sequence.add("framesPerSecond", options.frames_per_second);
    sequence.add("turntableDegrees", options.turntable_degrees);
    sequence.add("container", options.container);
    output.add_object("sequence", sequence);
  }
  output.add("quality", options.quality);
  output.add("samples", options.samples);
  request.add_object("scene", scene);
  request.add_object("environment", environment);
  request.add_object("camera", camera);
  request.add_object("output", output);
  return request.text();
}

void apply_options(const RenderOptions& options, const RenderSpec& said, RenderSpec& spec) {
  if (options.gltf_scene) spec.scene.gltf_scene = *options.gltf_scene;
  if (options.variant) spec.scene.variant = options.variant;
  const bool is_told = !spec.scene.animations.empty() || spec.output.sequence;
  if (names_clip(options) || (animates(options) && !is_told)) spec.scene.animations = {clip_of(options)};
  if (options.up_axis) spec.scene.up_axis = *options.up_axis == "z" ? UpAxis::kZ : UpAxis::kY;
  if (options.shading_model) spec.scene.shading_model = said.scene.shading_model;
  if (options.environment) spec.environment.map = said.environment.map;
  if (options.rotation_degrees) spec.environment.rotation_rad = said.environment.rotation_rad;
  if (options.background || options.blur_degrees) spec.environment.background = said.environment.background;
  if (options.sun) spec.environment.sun = said.environment.sun;
  if (options.visibility) spec.environment.visibility = said.environment.visibility;
  if (options.ground) spec.environment.ground = said.environment.ground;
  if (turns_camera(options)) spec.camera.view = said.camera.view;
  if (options.exposure_ev) spec.camera.exposure_ev = said.camera.exposure_ev;
  if (meters(options)) spec.camera.metering = said.camera.metering;
  if (options.f_stop || options.focus_distance_m) spec.camera.depth_of_field = said.camera.depth_of_field;
  if (options.motion_blur_seconds) spec.camera.motion = said.camera.motion;
  if (options.bloom_intensity) spec.output.bloom = said.output.bloom;
  if (options.pixel_filter) spec.output.pixel_filter = said.output.pixel_filter;
  const ColorGrade& grade = said.output.grade;
  ColorGrade& to = spec.output.grade;
  if (options.white_balance_kelvin) to.white_balance_kelvin = grade.white_balance_kelvin;
  if (options.white_balance_tint) to.white_balance_tint = grade.white_balance_tint;
  if (options.contrast) to.contrast = grade.contrast;
  if (options.saturation) to.saturation = grade.saturation;
  if (options.width) spec.output.width = said.output.width;
  if (options.height) spec.output.height = said.output.height;
  if (options.format) spec.output.format = said.output.format;
  if (options.bit_depth) spec.output.bit_depth = said.output.bit_depth;
  if (options.exr_type) spec.output.exr_type = said.output.exr_type;
  if (options.exr_compression) spec.output.exr_compression = said.output.exr_compression;
  if (options.compression_quality) spec.output.compression_quality = said.output.compression_quality;
  if (options.lossless) spec.output.lossless = said.output.lossless;
  if (options.dither) spec.output.dither = said.output.dither;
  if (options.tone_map) spec.output.tone_map = said.output.tone_map;
  if (!options.layers.empty()) spec.output.layers = said.output.layers;
  if (describes_sequence(options) || options.container) {
    if (!spec.output.sequence) spec.output.sequence.emplace();
    apply_sequence(options, *spec.output.sequence);
  }
  if (options.show) spec.output.shown = said.output.shown;
  if (options.quality || options.samples) spec.output.samples = said.output.samples;
}

}  // namespace furnace
