// The options of `furnace render` as a request document: the command line says nothing that JSON could not.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/scene/render_spec.hpp"

namespace furnace {

struct RenderOptions {
  std::optional<int> width, height, samples;
  std::optional<std::string> quality, tone_map, format, exr_type, exr_compression;
  std::optional<int> bit_depth, compression_quality;
  bool lossless = false, dither = false;
  std::optional<double> ev100, aperture, shutter_seconds, iso;
  bool auto_exposure = false;
  std::optional<double> white_balance_kelvin, white_balance_tint, contrast, saturation;
  std::optional<double> f_stop, focus_distance_m, motion_blur_seconds, bloom_intensity;
  std::optional<std::string> pixel_filter;
  std::vector<std::string> layers;
  std::optional<std::string> show;
  std::optional<double> azimuth_degrees, elevation_degrees, exposure_ev, rotation_degrees;
  std::optional<std::string> environment;  // a reference: "builtin:studio", "part:environment"
  std::optional<std::string> background;   // environment, transparent or #rrggbb
  std::optional<double> blur_degrees;      // of the background
  std::optional<std::string> sun;
  std::optional<std::string> visibility;
  std::optional<int> gltf_scene;         // index
  std::optional<std::string> variant;    // of the model's materials, by name
  std::optional<std::string> animation;  // of the model, by name or index
  std::optional<double> time_seconds;    // of the animation
  std::optional<int> frames;
  std::optional<double> frames_per_second, turntable_degrees;
  std::optional<std::string> container;  // of the frames
  std::optional<std::string> up_axis;    // of a model that is no glTF: y or z
  std::optional<std::string> shading_model;
  bool ground = false;
};

// The document that says what `options` say, about `model` (a reference) unless that is empty.
// Errors: kUnprocessable for a background that cannot be read.
std::string request_document(const RenderOptions& options, const std::string& model);

// Puts what `options` name into `spec`, from `said`: the parsed request_document(options, "").
void apply_options(const RenderOptions& options, const RenderSpec& said, RenderSpec& spec);

}  // namespace furnace
