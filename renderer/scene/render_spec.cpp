#include "renderer/scene/render_spec.hpp"

#include <algorithm>

namespace furnace {
namespace {

// Every struct is taken apart by structured bindings, which name all its members: a member that is added to
// one of them does not compile here until it is hashed.
class CanonicalHash {
 public:
  void add(std::string_view text) { builder_.add(text); }
  void add(const std::string& text) { builder_.add(std::string_view(text)); }
  void add(const ContentHash& hash) { builder_.add(hash); }
  void add(bool value) { builder_.add(std::int64_t{value}); }
  void add(int value) { builder_.add(std::int64_t{value}); }
  void add(double value) { builder_.add(value); }
  void add(float value) { builder_.add(double{value}); }
  void add(const glm::vec2& v) { add_all(v.x, v.y); }
  void add(const glm::vec3& v) { add_all(v.x, v.y, v.z); }
  void add(const glm::dvec3& v) { add_all(v.x, v.y, v.z); }
  void add(const glm::vec4& v) { add_all(v.x, v.y, v.z, v.w); }
  void add(const glm::quat& q) { add_all(q.w, q.x, q.y, q.z); }

  template <class Enum>
  requires std::is_enum_v<Enum>
  void add(Enum value) { add(static_cast<int>(value)); }

  template <class T>
  void add(const std::optional<T>& value) {
    add(value.has_value());
    if (value) add(*value);
  }

  template <class T>
  void add(const std::vector<T>& values) {
    builder_.add(static_cast<std::int64_t>(values.size()));
    for (const T& value : values) add(value);
  }

  template <class T, std::size_t kCount>
  void add(const std::array<T, kCount>& values) {
    for (const T& value : values) add(value);
  }

  template <class T>
  void add(const std::map<std::string, T>& values) {
    builder_.add(static_cast<std::int64_t>(values.size()));
    for (const auto& [key, value] : values) add_all(key, value);
  }

  template <class... T>
  void add(const std::variant<T...>& value) {
    builder_.add(static_cast<std::int64_t>(value.index()));
    std::visit([this](const auto& alternative) { this->add(alternative); }, value);
  }

  void add(const std::shared_ptr<const ModelBundle>& model) {
    add(model != nullptr);
    if (model) add(model->hash);
  }

  void add(const KeepTexture&) {}
  void add(const NoTexture&) {}

  void add(const SamplerDesc& value) {
    const auto& [wrap_u, wrap_v, mag, min, mip] = value;
    add_all(wrap_u, wrap_v, mag, min, mip);
  }

  void add(const UvTransform& value) {
    const auto& [offset, rotation_rad, scale] = value;
    add_all(offset, rotation_rad, scale);
  }

  void add(const TextureFile& value) {
    const auto& [encoded, uv_set, sampler, transform] = value;
    add_all(encoded.hash(), uv_set, sampler, transform);
  }

  void add(const MaterialOverride& value) {
    const auto& [preset, model, base_color, metallic, roughness, emissive_strength, normal_scale,
                 occlusion_strength, alpha_cutoff, emissive, alpha_mode, double_sided, unlit, ior, specular,
                 specular_color, clearcoat, clearcoat_roughness, clearcoat_normal_scale, sheen_color,
                 sheen_roughness, anisotropy, anisotropy_rotation_rad, iridescence, iridescence_ior,
                 iridescence_min_nm, iridescence_max_nm, transmission, thickness_m, attenuation_distance_m,
                 dispersion, attenuation_color, diffuse_transmission, diffuse_transmission_color, textures] =
        value;
    add_all(preset, model, base_color, metallic, roughness, emissive_strength, normal_scale,
            occlusion_strength, alpha_cutoff, emissive, alpha_mode, double_sided, unlit, ior, specular,
            specular_color, clearcoat, clearcoat_roughness, clearcoat_normal_scale, sheen_color,
            sheen_roughness, anisotropy, anisotropy_rotation_rad, iridescence, iridescence_ior,
            iridescence_min_nm, iridescence_max_nm, transmission, thickness_m, attenuation_distance_m,
            dispersion, attenuation_color, diffuse_transmission, diffuse_transmission_color, textures);
  }

  void add(const NodeSpec& value) {
    const auto& [mesh, name, material, translation, rotation, scale] = value;
    add_all(mesh, name, material, translation, rotation, scale);
  }

  void add(const std::shared_ptr<const LightProfile>& value) {
    add(value != nullptr);
    if (value != nullptr) add(value->hash);
  }

  void add(const Light& value) {
    const auto& [kind, name, position, direction, intensity, range_m, inner_cone_rad, outer_cone_rad,
                 radius_m, angular_radius_rad, width_m, height_m, roll_rad, two_sided, profile,
                 casts_shadow] = value;
    add_all(kind, name, position, direction, intensity, range_m, inner_cone_rad, outer_cone_rad, radius_m,
            angular_radius_rad, width_m, height_m, roll_rad, two_sided, profile, casts_shadow);
  }

  void add(const AnimationClip& value) {
    const auto& [which, time] = value;
    add_all(which, time.seconds, time.loop);
  }

  void add(const SceneSpec& value) {
    const auto& [model, gltf_scene, variant, animations, up_axis, nodes, materials, shading_model, lights,
                 model_lights] = value;
    add_all(model, gltf_scene, variant, animations, up_axis, nodes, materials, shading_model, lights,
            model_lights);
  }

  void add(const BuiltinName& value) {
    const auto& [name] = value;
    add(name);
  }

  void add(const EnvironmentFile& value) {
    const auto& [bytes, layout] = value;
    add(bytes.hash());
    if (layout != EnvironmentLayout::kAuto) add(layout);
  }

  void add(const EnvironmentColor& value) {
    const auto& [radiance] = value;
    add(radiance);
  }

  void add(const GradientStop& value) {
    const auto& [elevation_deg, radiance] = value;
    add_all(elevation_deg, radiance);
  }

  void add(const GradientEnvironment& value) {
    const auto& [stops, blend] = value;
    add_all(stops, blend);
  }

  void add(const OvercastEnvironment& value) {
    const auto& [zenith_luminance, ground_albedo] = value;
    add_all(zenith_luminance, ground_albedo);
  }

  void add(const ClearSkyEnvironment& value) {
    const auto& [turbidity, ground_albedo, sun_elevation_rad, sun_azimuth_rad, sun_disc, sun_radius_rad,
                 calibration] = value;
    add_all(turbidity, ground_albedo, sun_elevation_rad, sun_azimuth_rad, sun_disc, sun_radius_rad,
            calibration);
  }

  void add(const SoftBox& value) {
    const auto& [shape, azimuth_rad, elevation_rad, roll_rad, width_rad, height_rad, color, luminance,
                 feather, hotspot] = value;
    add_all(shape, azimuth_rad, elevation_rad, roll_rad, width_rad, height_rad, color, luminance, feather,
            hotspot);
  }

  void add(const StudioEnvironment& value) {
    const auto& [room, lights] = value;
    add_all(room, lights);
  }

  void add(const EnvironmentBackground& value) {
    const auto& [map, rotation_rad, intensity, blur_rad] = value;
    add_all(map, rotation_rad, intensity, blur_rad);
  }

  void add(const ColorBackground& value) {
    const auto& [color] = value;
    add(color);
  }

  void add(const GradientBackground& value) {
    const auto& [top, bottom] = value;
    add_all(top, bottom);
  }

  void add(const TransparentBackground&) {}

  void add(const GroundProjection& value) {
    const auto& [height_m, radius_m] = value;
    add_all(height_m, radius_m);
  }

  void add(const GroundSpec& value) {
    const auto& [shadow, shadow_strength, level_m, projection] = value;
    add_all(shadow, shadow_strength, level_m, projection);
  }

  void add(const EnvironmentSpec& value) {
    const auto& [map, rotation_rad, intensity, illuminance_lux, sun, visibility, background, ground] = value;
    add_all(map, rotation_rad, intensity, illuminance_lux, sun, visibility, background, ground);
  }

  void add(const OrbitCamera& value) {
    const auto& [azimuth_rad, elevation_rad, fit, fov_y_rad, orthographic] = value;
    add_all(azimuth_rad, elevation_rad, fit, fov_y_rad, orthographic);
  }

  void add(const LookAtCamera& value) {
    const auto& [eye, target, up, fov_y_rad, height_m] = value;
    add_all(eye, target, up, fov_y_rad, height_m);
  }

  void add(const IntrinsicsCamera& value) {
    const auto& [focal_px, principal_px, picture_px, translation, rotation] = value;
    add_all(focal_px.x, focal_px.y, principal_px.x, principal_px.y, picture_px.x, picture_px.y, translation,
            rotation);
  }

  void add(const GltfCamera& value) {
    const auto& [which] = value;
    add(which);
  }

  void add(const UnmeteredExposure&) {}

  void add(const PhysicalExposure& value) {
    const auto& [ev100] = value;
    add(ev100);
  }

  void add(const AutoExposure&) {}

  void add(const DepthOfField& value) {
    const auto& [f_stop, sensor_height_m, aperture_diameter_m, focus_distance_m, focus_point, blades,
                 blade_rotation_rad] = value;
    add_all(f_stop, sensor_height_m, aperture_diameter_m, focus_distance_m, focus_point, blades,
            blade_rotation_rad);
  }

  void add(const CameraMotion& value) {
    const auto& [shutter_s, frame_s, turn_rad_per_s, turn_about_m] = value;
    add_all(shutter_s, frame_s, turn_rad_per_s, turn_about_m);
  }

  void add(const CameraSpec& value) {
    const auto& [view, metering, exposure_ev, depth_of_field, motion] = value;
    add_all(view, metering, exposure_ev, depth_of_field, motion);
  }

  void add(const ColorGrade& value) {
    const auto& [white_balance_kelvin, white_balance_tint, contrast, saturation] = value;
    add_all(white_balance_kelvin, white_balance_tint, contrast, saturation);
  }

  void add(const PixelFilter& value) {
    const auto& [kind, radius_px] = value;
    add_all(kind, radius_px);
  }

  void add(const Bloom& value) {
    const auto& [intensity, radius, source, threshold] = value;
    add_all(intensity, radius, source, threshold);
  }

  void add(const Sequence& value) {
    const auto& [frames, frames_per_second, turntable_rad, container, loops] = value;
    add_all(frames, frames_per_second, turntable_rad, container, loops);
  }

  void add(const OutputSpec& value) {
    const auto& [width, height, format, bit_depth, exr_type, exr_compression, compression_quality, lossless,
                 dither, tone_map, grade, pixel_filter, bloom, samples, layers, shown, sequence] = value;
    add_all(width, height, format, bit_depth, exr_type, exr_compression, compression_quality, lossless,
            dither, tone_map, grade, pixel_filter, bloom, samples, layers, shown, sequence);
  }

  void add(const RenderSpec& value) {
    const auto& [scene, environment, camera, output, strict] = value;
    add_all(scene, environment, camera, output, strict);
  }

  template <class... T>
  void add_all(const T&... values) {
    (add(values), ...);
  }

  ContentHash finish() { return builder_.finish(); }

 private:
  HashBuilder builder_;
};

template <class T>
ContentHash versioned_hash(std::string_view kind, const T& value) {
  CanonicalHash hash;
  hash.add(kind);
  hash.add(kRenderSpecVersion);
  hash.add(value);
  return hash.finish();
}

}  // namespace

std::string format_fault(const RenderSpec& spec) {
  const OutputSpec& output = spec.output;
  if (output.format == OutputFormat::kJpeg &&
      std::holds_alternative<TransparentBackground>(spec.environment.background))
    return "a JPEG cannot be transparent; ask for png, webp or exr, or for another background";
  if (output.format == OutputFormat::kWebp && std::max(output.width, output.height) > kMaxWebpSidePx)
    return "a WebP has at most " + std::to_string(kMaxWebpSidePx) + " px a side; ask for another format";
  if (output.format == OutputFormat::kWebm && !output.sequence)
    return "a WebM is a video: give it a sequence, or ask for another format";
  return {};
}

std::string layers_fault(const OutputSpec& output) {
  if (output.layers.empty()) return {};
  if (output.format != OutputFormat::kExr)
    return "only an EXR keeps layers beside the picture; ask for format exr, or show one of them alone";
  if (output.exr_compression == ExrCompression::kDwaa)
    return "dwaa would change the numbers of layers; ask for another exrCompression";
  return {};
}

std::string sequence_fault(const RenderSpec& spec) {
  if (!spec.output.sequence) return {};
  const Sequence& sequence = *spec.output.sequence;
  const bool plays = !spec.scene.animations.empty(), turns = sequence.turntable_rad != 0;
  if (!plays && !turns) return "nothing moves: give it turntableDegrees, or the scene an animation";
  if (!plays && !sequence.frames) return "needs frames: nothing but an animation has a length of its own";
  const auto& view = spec.camera.view;
  if (turns && !std::holds_alternative<OrbitCamera>(view) && !std::holds_alternative<LookAtCamera>(view))
    return "only an orbit or lookAt camera can go round; leave out turntableDegrees or the camera";
  const OutputFormat format = spec.output.format;
  const bool is_video = format == OutputFormat::kWebm;
  if (sequence.container == Sequence::Container::kArchive)
    return is_video ? "a ZIP of frames holds pictures; ask for another format, or leave out container" : "";
  if (is_video && sequence.loops != 0) return "a WebM does not say how often it is played; leave out loops";
  if (!is_video && format != OutputFormat::kPng && format != OutputFormat::kWebp)
    return "only png, webp and webm hold an animation; ask for one of them, or for container zip";
  return {};
}

ContentHash spec_hash(const RenderSpec& spec) {
  return versioned_hash("furnace render spec", spec);
}

ContentHash procedural_hash(const ProceduralEnvironment& environment) {
  return versioned_hash("furnace procedural environment", environment);
}

}  // namespace furnace
