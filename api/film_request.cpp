#include "api/film_request.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace furnace::api {
namespace {

// Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 5.1.
double ev100_of(double f_number, double shutter_s, double iso) {
  return std::log2(f_number * f_number / shutter_s) - std::log2(iso / 100);
}

void read_exposure(const Value& camera, CameraSpec& spec, Faults& faults) {
  read(camera["exposureEv"], spec.exposure_ev);
  bool automatic = false;
  read(camera["autoExposure"], automatic);
  if (automatic) spec.metering = AutoExposure{};
  if (const Value ev100 = camera["ev100"]) spec.metering = PhysicalExposure{ev100.number()};
  const Value aperture = camera["aperture"], shutter = camera["shutterSeconds"], iso = camera["iso"];
  if (aperture && shutter) {
    double sensitivity = 100;
    read(iso, sensitivity);
    spec.metering = PhysicalExposure{ev100_of(aperture.number(), shutter.number(), sensitivity)};
  } else if (aperture) {
    faults.add(ErrorCode::kUnprocessable, aperture, "needs shutterSeconds beside it");
  } else if (shutter || iso) {
    faults.add(ErrorCode::kUnprocessable, shutter ? shutter : iso,
               shutter ? "needs aperture beside it" : "needs aperture and shutterSeconds beside it");
  }
}

void read_intrinsics(const Value& value, IntrinsicsCamera& spec, Faults& faults) {
  for (const auto& [key, number] :
       {std::pair{"fx", &spec.focal_px.x}, std::pair{"fy", &spec.focal_px.y},
        std::pair{"cx", &spec.principal_px.x}, std::pair{"cy", &spec.principal_px.y},
        std::pair{"width", &spec.picture_px.x}, std::pair{"height", &spec.picture_px.y}})
    read(value[key], *number);
  read(value["translation"], spec.translation);
  if (const Value rotation = value["rotation"]) spec.rotation = read_rotation(rotation, faults);
  // Rows downwards, depth forwards: half a turn about the camera's own X.
  if (const Value axes = value["axes"]; axes && axes.text() == "opencv")
    spec.rotation *= glm::quat(0, 1, 0, 0);
}

void read_depth_of_field(const Value& value, DepthOfField& spec, Faults& faults) {
  read(value["fStop"], spec.f_stop);
  if (const Value height = value["sensorHeightMillimetres"]) spec.sensor_height_m = height.number() * 1e-3;
  read(value["apertureDiameterMetres"], spec.aperture_diameter_m);
  read(value["focusDistanceMetres"], spec.focus_distance_m);
  read(value["focusPoint"], spec.focus_point);
  constexpr int kFewestBlades = 3;
  read(value["blades"], spec.blades);
  if (spec.blades > 0 && spec.blades < kFewestBlades)
    faults.add(ErrorCode::kUnprocessable, value["blades"],
               fmt::format("{} blades enclose nothing; 0 is a round opening, else at least {}", spec.blades,
                           kFewestBlades));
  read_degrees(value["bladeRotationDegrees"], spec.blade_rotation_rad);
}

// Half a turn, as most film cameras have it.
constexpr double kShutterAngleDeg = 180;

struct FilterRow {
  std::string_view name;
  PixelFilterKind kind;
  double radius_px;  // where the request states none
};

// The radii usual for them: pbrt's of the Gaussian (its sigma is a third) and of Mitchell and Netravali's, whose cubic is
// made for it.
constexpr FilterRow kFilters[] = {{"box", PixelFilterKind::kBox, 0.5},
                                  {"gaussian", PixelFilterKind::kGaussian, 1.5},
                                  {"blackman-harris", PixelFilterKind::kBlackmanHarris, 1.5},
                                  {"mitchell", PixelFilterKind::kMitchell, 2}};

void read_pixel_filter(const Value& value, PixelFilter& spec) {
  const Value name = value.type() == JsonType::kObject ? value["type"] : value;
  for (const FilterRow& row : kFilters)
    if (name && row.name == name.text()) spec = {row.kind, row.radius_px};
  if (value.type() == JsonType::kObject) read(value["radiusPixels"], spec.radius_px);
}

void read_bloom(const Value& value, Bloom& spec) {
  read(value["intensity"], spec.intensity);
  read(value["radius"], spec.radius);
  read(value["threshold"], spec.threshold);
  static constexpr Choice<BloomSource> kSources[] = {{"all", BloomSource::kAll},
                                                     {"emission", BloomSource::kEmission}};
  read_choice(value["source"], kSources, spec.source);
}

void read_sequence(const Value& value, Sequence& spec) {
  if (const Value frames = value["frames"]) read(frames, spec.frames.emplace());
  read(value["framesPerSecond"], spec.frames_per_second);
  read_degrees(value["turntableDegrees"], spec.turntable_rad);
  static constexpr Choice<Sequence::Container> kContainers[] = {
      {"animation", Sequence::Container::kAnimation}, {"zip", Sequence::Container::kArchive}};
  read_choice(value["container"], kContainers, spec.container);
  read(value["loops"], spec.loops);
}

FilmLayer film_layer_of(const Value& name) {
  const auto* row = std::find_if(kFilmLayers.begin(), kFilmLayers.end(),
                                 [&](const FilmLayerRow& known) { return known.name == name.text(); });
  FURNACE_CHECK(row != kFilmLayers.end(), "{} is not handled", name.text());
  return row->layer;
}

void read_layers(const Value& output, OutputSpec& spec) {
  const Value names = output["layers"], shown = output["show"];
  for (std::size_t i = 0; i < names.size(); ++i) spec.layers.push_back(film_layer_of(names.at(i)));
  std::sort(spec.layers.begin(), spec.layers.end());
  if (shown && shown.text() != "beauty") spec.shown = film_layer_of(shown);
}

void check_limits(const Value& output, const RequestLimits& limits, const OutputSpec& spec, Faults& faults) {
  const std::pair<std::string_view, int> sides[] = {{"width", spec.width}, {"height", spec.height}};
  bool sides_fit = true;
  for (const auto& [key, side_px] : sides) {
    if (side_px <= limits.max_side_px) continue;
    sides_fit = false;
    faults.add(ErrorCode::kTooLarge, output[key],
               fmt::format("{} px are more than this server's {} px a side", side_px, limits.max_side_px));
  }
  if (const std::int64_t area_px = Extent{spec.width, spec.height}.area();
      sides_fit && area_px > limits.max_area_px)
    faults.add(ErrorCode::kTooLarge, output,
               fmt::format("{} x {} = {} px are more than this server's {} px a picture", spec.width,
                           spec.height, area_px, limits.max_area_px));
  std::int64_t layer_bytes = 0;
  for (const FilmLayer layer : spec.layers) layer_bytes += bytes_per_px(layer);
  layer_bytes *= Extent{spec.width, spec.height}.area();
  if (sides_fit && layer_bytes > limits.max_layer_bytes)
    faults.add(ErrorCode::kTooLarge, output["layers"],
               fmt::format("{} layers of {} x {} px take {} bytes, more than this server's {}",
                           spec.layers.size(), spec.width, spec.height, layer_bytes, limits.max_layer_bytes));
  if (const int frames = spec.sequence ? spec.sequence->frames.value_or(0) : 0; frames > 0) {
    const Value place = output["sequence"]["frames"];
    if (frames > limits.max_frames)
      faults.add(ErrorCode::kTooLarge, place,
                 fmt::format("{} frames are more than this server's {}", frames, limits.max_frames));
    else if (const std::int64_t px = Extent{spec.width, spec.height}.area() * frames;
             sides_fit && px > limits.max_sequence_px)
      faults.add(ErrorCode::kTooLarge, place,
                 fmt::format("{} frames of {} x {} px are {} px, more than this server's {}", frames,
                             spec.width, spec.height, px, limits.max_sequence_px));
  }
  if (spec.samples > limits.max_samples)
    faults.add(ErrorCode::kTooLarge, output[output["samples"] ? "samples" : "quality"],
               fmt::format("{} samples are more than this server's {}", spec.samples, limits.max_samples));
}

}  // namespace

void read_camera(const Value& value, CameraSpec& spec, Faults& faults) {
  const Value orbit = value["orbit"], look_at = value["lookAt"], gltf = value["gltf"],
              intrinsics = value["intrinsics"], fov = value["fovYDegrees"];
  if (gltf) {
    auto& which = spec.view.emplace<GltfCamera>().which;
    if (gltf.type() == JsonType::kText)
      which = std::string(gltf.text());
    else
      which = gltf.integer();
  } else if (intrinsics) {
    read_intrinsics(intrinsics, spec.view.emplace<IntrinsicsCamera>(), faults);
  } else if (look_at) {
    auto& camera = spec.view.emplace<LookAtCamera>();
    read(look_at["eye"], camera.eye);
    read(look_at["target"], camera.target);
    read(look_at["up"], camera.up);
    read(look_at["heightMetres"], camera.height_m);
    read_degrees(fov, camera.fov_y_rad);
    if (const Value height = look_at["heightMetres"]; height && fov)
      faults.add(ErrorCode::kUnprocessable, fov,
                 "parallel rays have no field of view; leave it out, or heightMetres");
  } else {
    auto& camera = spec.view.emplace<OrbitCamera>();
    read_degrees(orbit["azimuthDegrees"], camera.azimuth_rad);
    read_degrees(orbit["elevationDegrees"], camera.elevation_rad);
    read(orbit["fit"], camera.fit);
    read(orbit["orthographic"], camera.orthographic);
    read_degrees(fov, camera.fov_y_rad);
  }
  read_exposure(value, spec, faults);
  if (const Value lens = value["depthOfField"])
    read_depth_of_field(lens, spec.depth_of_field.emplace(), faults);
}

void read_output(const Value& value, const RequestLimits& limits, OutputSpec& spec, Faults& faults) {
  read(value["width"], spec.width);
  read(value["height"], spec.height);
  if (const Value name = value["format"])
    for (const FormatRow& row : kFormats)
      if (row.name == name.text()) spec.format = row.format;
  static constexpr Choice<SampleType> kTypes[] = {{"half", SampleType::kFloat16},
                                                  {"float", SampleType::kFloat32}};
  read_choice(value["exrType"], kTypes, spec.exr_type);
  static constexpr Choice<ExrCompression> kCompressions[] = {{"none", ExrCompression::kNone},
                                                             {"zip", ExrCompression::kZip},
                                                             {"piz", ExrCompression::kPiz},
                                                             {"dwaa", ExrCompression::kDwaa}};
  if (const Value compression = value["exrCompression"])
    read_choice(compression, kCompressions, spec.exr_compression.emplace());
  read(value["bitDepth"], spec.bit_depth);
  read(value["compressionQuality"], spec.compression_quality);
  read(value["lossless"], spec.lossless);
  read(value["dither"], spec.dither);
  static constexpr Choice<ToneMap> kCurves[] = {
      {"pbr-neutral", ToneMap::kPbrNeutral}, {"aces", ToneMap::kAces},     {"agx", ToneMap::kAgx},
      {"reinhard", ToneMap::kReinhard},      {"linear", ToneMap::kLinear}, {"none", ToneMap::kNone}};
  read_choice(value["toneMap"], kCurves, spec.tone_map);
  read(value["whiteBalanceKelvin"], spec.grade.white_balance_kelvin);
  read(value["whiteBalanceTint"], spec.grade.white_balance_tint);
  read(value["contrast"], spec.grade.contrast);
  read(value["saturation"], spec.grade.saturation);
  if (const Value filter = value["pixelFilter"]) read_pixel_filter(filter, spec.pixel_filter);
  if (const Value bloom = value["bloom"]) read_bloom(bloom, spec.bloom.emplace());
  const Value quality = value["quality"];
  spec.samples = samples_for_quality(quality ? quality.text() : kDefaultQuality);
  read(value["samples"], spec.samples);
  read_layers(value, spec);
  if (const Value sequence = value["sequence"]) read_sequence(sequence, spec.sequence.emplace());
  check_limits(value, limits, spec, faults);
}

void read_motion(const Value& camera, const std::optional<Sequence>& sequence, CameraMotion& spec,
                 Faults& faults) {
  const Value value = camera["motionBlur"];
  if (!value) return;
  const Value seconds = value["shutterSeconds"] ? value["shutterSeconds"] : camera["shutterSeconds"];
  const Value angle = value["shutterAngleDegrees"];
  if (angle && !sequence) {
    faults.add(ErrorCode::kUnprocessable, angle,
               "is a share of the time from one frame to the next, so it needs output.sequence; give "
               "shutterSeconds in its place");
  } else if (sequence && (angle || !seconds)) {
    double angle_deg = kShutterAngleDeg;
    read(angle, angle_deg);
    spec.shutter_s = angle_deg / 360 / sequence->frames_per_second;
  } else if (seconds) {
    spec.shutter_s = seconds.number();
  } else {
    faults.add(ErrorCode::kUnprocessable, value,
               "needs shutterSeconds: a single picture has no frames to open the shutter between");
  }
}

}  // namespace furnace::api
