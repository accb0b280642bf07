// One picture, completely described by values: what every door (HTTP, command line, tests) hands to the
// renderer.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "renderer/image/encode.hpp"
#include "renderer/image/environment_layout.hpp"
#include "renderer/image/image.hpp"
#include "renderer/scene/film_layer.hpp"
#include "renderer/scene/gltf_import.hpp"
#include "renderer/scene/light.hpp"
#include "renderer/scene/material.hpp"
#include "renderer/scene/model_format.hpp"
#include "renderer/scene/procedural_environment.hpp"

namespace furnace {

struct BuiltinName {
  std::string name;  // without "builtin:"
};

struct KeepTexture {};
struct NoTexture {};
struct TextureFile {
  Blob encoded;  // what decode_texture reads
  int uv_set = 0;
  SamplerDesc sampler;
  UvTransform transform;
};
using TextureOverride = std::variant<KeepTexture, NoTexture, TextureFile>;

// A material in a request: a preset or plain values, over the defaults or over a model's own material of the
// same name. Units and ranges are those of Material. A metallic or roughness, or a texture of them, makes a
// specular-glossiness material one of metallic-roughness.
struct MaterialOverride {
  std::optional<std::string> preset;
  std::optional<ShadingModel> model;
  std::optional<glm::vec4> base_color;
  std::optional<float> metallic, perceptual_roughness, emissive_strength, normal_scale, occlusion_strength,
      alpha_cutoff;
  std::optional<glm::vec3> emissive;
  std::optional<AlphaMode> alpha_mode;
  std::optional<bool> double_sided, unlit;

  std::optional<float> ior, specular;
  std::optional<glm::vec3> specular_color;
  std::optional<float> clearcoat, clearcoat_perceptual_roughness, clearcoat_normal_scale;
  std::optional<glm::vec3> sheen_color;
  std::optional<float> sheen_perceptual_roughness;
  std::optional<float> anisotropy, anisotropy_rotation_rad;
  std::optional<float> iridescence, iridescence_ior, iridescence_thickness_min_nm,
      iridescence_thickness_max_nm;
  std::optional<float> transmission, thickness_m, attenuation_distance_m, dispersion;
  std::optional<glm::vec3> attenuation_color;
  std::optional<float> diffuse_transmission;
  std::optional<glm::vec3> diffuse_transmission_color;

  std::array<TextureOverride, kTextureUses> textures;  // by TextureUse
};

struct NodeSpec {
  std::string mesh;                      // built-in mesh name
  std::optional<std::string> name = {};  // of its matte; none: its JSON pointer
  std::optional<std::string>
      material;                    // key of SceneSpec::materials or a preset name; none: default_material()
  glm::vec3 translation{0};        // m
  glm::quat rotation{1, 0, 0, 0};  // w x y z
  glm::vec3 scale{1};
};

struct SceneSpec {
  std::shared_ptr<const ModelBundle> model;  // may be null: then nodes only
  int gltf_scene = -1;                       // as ImportOptions::scene
  std::optional<std::string> variant;        // of the model's materials, by name
  std::vector<AnimationClip> animations;     // of the model, as ImportOptions::animations
  std::optional<UpAxis> up_axis;             // of a model that is no glTF; none: as import_model
  std::vector<NodeSpec> nodes;
  std::map<std::string, MaterialOverride> materials;
  ShadingModel shading_model = ShadingModel::kPbr;  // of materials that state none
  std::vector<Light> lights;                        // beside those of the model
  bool model_lights = true;                         // whether the model's own shine
};

struct EnvironmentFile {
  Blob bytes;  // .hdr or .exr
  EnvironmentLayout layout = EnvironmentLayout::kAuto;
};
struct EnvironmentColor {
  glm::vec3 radiance{1};
};

using EnvironmentMapSpec =
    std::variant<BuiltinName, EnvironmentFile, EnvironmentColor, ProceduralEnvironment>;

// What is seen behind the scene. Colours are linear radiance as shown, that is after exposure.
struct EnvironmentBackground {
  std::optional<EnvironmentMapSpec> map;  // none: the map that lights, at its intensity
  std::optional<double> rotation_rad;     // none: with the map that lights
  double intensity = 1;                   // multiplier, >= 0
  double blur_rad = 0;                    // standard deviation along each axis, [0, pi]: ibl/blur.hpp
};
struct ColorBackground {
  glm::vec3 color{0};
};
struct GradientBackground {
  glm::vec3 top{1}, bottom{0};  // of the picture, linear between
};
struct TransparentBackground {};

using BackgroundSpec =
    std::variant<EnvironmentBackground, ColorBackground, GradientBackground, TransparentBackground>;

// The lower half of the environment laid out as a floor, as if it had been photographed from `height_m` above it.
struct GroundProjection {
  double height_m = 1.6;
  double radius_m = 20;  // of the dome that carries the rest, > height_m
};

// A horizontal plane that shows nothing but what the scene keeps from it: shadows.
struct GroundSpec {
  bool shadow = true;
  double shadow_strength = 1;                  // [0, 1]
  std::optional<double> level_m;               // world y; none: the scene's lowest point
  std::optional<GroundProjection> projection;  // of the background
};

// Whether the suns of a map are taken out of it and given as directional lights; kAuto: wherever some are found.
enum class SunMode { kAuto, kKeep, kExtract };

// Whether the scene keeps the environment's light from itself: in each sub-frame from some directions more, so that many
// converge to the shadow of all of it; kAuto: from kVisibilitySamples sub-frames on.
enum class EnvironmentVisibility { kAuto, kOn, kOff };
inline constexpr int kVisibilitySamples = 16;  // of "high" quality

struct EnvironmentSpec {
  EnvironmentMapSpec map = BuiltinName{"studio"};
  double rotation_rad = 0;  // about +Y, counter-clockwise seen from above: turns the environment as an object
  double intensity = 1;     // multiplier, >= 0
  // When given, the map is scaled so that it lights a horizontal plane with this many lux, then by `intensity`.
  std::optional<double> illuminance_lux;
  SunMode sun = SunMode::kAuto;
  EnvironmentVisibility visibility = EnvironmentVisibility::kAuto;
  BackgroundSpec background;
  std::optional<GroundSpec> ground;
};

struct OrbitCamera {
  double azimuth_rad = 0.61;    // 0 looks from +Z, pi/2 from +X
  double elevation_rad = 0.26;  // towards +Y, (-pi/2, pi/2) inclusive
  double fit = 1.05;            // 1: the bounds just touch the frame; larger leaves a margin
  double fov_y_rad = 0.5236;
  bool orthographic = false;  // parallel rays, framed as exactly; fov_y_rad has no effect
};
struct LookAtCamera {
  glm::vec3 eye{0}, target{0}, up{0, 1, 0};  // m
  double fov_y_rad = 0.5236;
  std::optional<double> height_m = {};  // of the picture: parallel rays; fov_y_rad has no effect
};
// A calibrated pinhole: what structure from motion and camera calibration give.
struct IntrinsicsCamera {
  glm::dvec2 focal_px{1};  // fx, fy of the calibrated picture, > 0
  glm::dvec2 principal_px{
      0};  // cx, cy from its upper left corner, y down; the first pixel's centre is (0.5, 0.5)
  glm::dvec2 picture_px{1};  // its width and height; a picture of another size shows as much of the height
  glm::vec3 translation{0};  // m, of the camera in the world
  glm::quat rotation{1, 0, 0, 0};  // w x y z, world from camera: looks along -Z, +Y up
};
struct GltfCamera {
  std::variant<int, std::string> which = 0;  // index or name
};

// Radiance is multiplied by 2^exposure_ev whatever is metered.
struct UnmeteredExposure {};
struct PhysicalExposure {
  double ev100 = 0;  // stops, for ISO 100: renderer/frame/exposure.hpp
};
struct AutoExposure {};  // by the picture's own mean

// A thin lens in place of the pinhole: what is not at the distance of focus is blurred. Of an opening with an f-number the
// focal length is the one whose field of view on the sensor is the camera's, focused at infinity.
struct DepthOfField {
  double f_stop = 2.8;                        // focal length over diameter
  double sensor_height_m = 0.024;             // of 35 mm film
  std::optional<double> aperture_diameter_m;  // in place of f_stop
  std::optional<double> focus_distance_m;     // along the viewing direction
  std::optional<glm::vec3> focus_point;       // in place of a distance; neither: the middle of the scene
  int blades = 0;                 // 0: a round opening; else corners of a regular polygon inscribed in it
  double blade_rotation_rad = 0;  // counter-clockwise as seen by the camera; 0: a corner points up
};

// How long what moves is seen. Clips move by their own time, of which the shutter's middle is what they state.
struct CameraMotion {
  double shutter_s = 0;        // of the clips' time, >= 0; 0: an instant
  double frame_s = 0;          // from one frame of a sequence to the next; 0: a single picture
  double turn_rad_per_s = 0;   // of the camera about a vertical axis, towards larger azimuths
  glm::dvec3 turn_about_m{0};  // on that axis

  // What motion vectors look back.
  double interval_s() const { return shutter_s > 0 ? shutter_s : frame_s; }
};

struct CameraSpec {
  std::variant<OrbitCamera, LookAtCamera, GltfCamera, IntrinsicsCamera> view = OrbitCamera{};
  std::variant<UnmeteredExposure, PhysicalExposure, AutoExposure> metering;
  double exposure_ev = 0;  // stops, more than what is metered
  std::optional<DepthOfField> depth_of_field = {};
  CameraMotion motion = {};
};

enum class OutputFormat { kPng, kExr, kJpeg, kWebp, kWebm };
enum class ToneMap {
  kPbrNeutral,
  kLinear,
  kNone,
  kAces,
  kAgx,
  kReinhard,
};  // kLinear clips; kNone: scene radiance straight to the transfer function

// What is done to exposed radiance before the tone curve.
struct ColorGrade {
  double white_balance_kelvin = 6504;  // of the light that shall look white, [1667, 25000]
  double white_balance_tint = 0;       // of that light: above the daylight locus, 1/3000 of CIE 1960 v
  double contrast = 1;                 // exponent about mid grey, >= 0
  double saturation = 1;               // >= 0; 0: grey

  bool operator==(const ColorGrade&) const = default;
};

enum class PixelFilterKind { kBox, kGaussian, kBlackmanHarris, kMitchell };

// What several sub-frames of a pixel are weighted by: renderer/frame/pixel_filter.hpp.
struct PixelFilter {
  PixelFilterKind kind = PixelFilterKind::kBox;
  double radius_px = 0.5;  // 0 beyond, along each axis
};

enum class BloomSource { kAll, kEmission };

// The share `intensity` of what exceeds the threshold is spread around the place it came from: renderer/frame/bloom.hpp.
struct Bloom {
  double intensity = 0.25;  // [0, 1]
  double radius = 0.1;      // of the picture's height
  BloomSource source = BloomSource::kAll;
  double threshold = 1;  // exposed radiance
};

// Several pictures in place of one: the clips play on, the camera goes round.
struct Sequence {
  enum class Container { kAnimation, kArchive };  // APNG, animated WebP or WebM; a ZIP of single files
  std::optional<int> frames;                      // none: as many as the longest clip has at this rate
  double frames_per_second = 24;
  double turntable_rad = 0;  // the camera's way round over all frames, towards larger azimuths
  Container container = Container::kAnimation;
  int loops = 0;  // 0: for ever; of a WebM the player says
};

struct OutputSpec {
  int width = 1024, height = 1024;  // px
  OutputFormat format = OutputFormat::kPng;
  int bit_depth = 8;  // of a PNG: 8 or 16
  SampleType exr_type = SampleType::kFloat16;
  std::optional<ExrCompression> exr_compression;  // none: as encode_exr chooses
  int compression_quality = 90;                   // of JPEG, WebM, and WebP that is not lossless, 1 to 100
  bool lossless = false;                          // of a WebP
  bool dither = false;                            // of 8 bits: rounds by a pattern instead of to the nearest
  ToneMap tone_map = ToneMap::kPbrNeutral;
  ColorGrade grade;
  PixelFilter pixel_filter;
  std::optional<Bloom> bloom;
  int samples = 1;                 // sub-frames, each with the context's MSAA
  std::vector<FilmLayer> layers;   // beside the picture, of an EXR: in the order of their rows, each once
  std::optional<FilmLayer> shown;  // in place of the picture; no matte
  std::optional<Sequence> sequence;
};

struct RenderSpec {
  SceneSpec scene;
  EnvironmentSpec environment;
  CameraSpec camera;
  OutputSpec output;
  bool strict = false;  // any Note is an error
};

// Why a file of the format cannot hold such a picture; "" when it can.
std::string format_fault(const RenderSpec& spec);
// Why there can be no such sequence; "" when there can.
std::string sequence_fault(const RenderSpec& spec);
// Why its layers cannot be kept in such a file; "" when they can.
std::string layers_fault(const OutputSpec& output);

// Raised when the same canonical bytes would mean another picture.
inline constexpr int kRenderSpecVersion = 7;

// Hash of the canonical form: equal for two specs that describe the same picture, whatever JSON they came
// from.
ContentHash spec_hash(const RenderSpec& spec);
// Of a part: equal for two descriptions of the same environment.
ContentHash procedural_hash(const ProceduralEnvironment& environment);

}  // namespace furnace
