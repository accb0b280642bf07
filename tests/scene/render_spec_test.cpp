#include "renderer/scene/render_spec.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>

namespace furnace {
namespace {

std::shared_ptr<const ModelBundle> model_of(std::uint8_t first_hash_byte) {
  auto model = std::make_shared<ModelBundle>();
  model->hash.bytes[0] = first_hash_byte;
  return model;
}

// Every optional and every list is filled, so that each field can be changed on its own.
RenderSpec full_spec() {
  RenderSpec spec;
  spec.scene.model = model_of(1);
  spec.scene.nodes = {NodeSpec{.mesh = "cube", .material = "gold"},
                      NodeSpec{.mesh = "sphere", .material = "red"}};
  MaterialOverride& material = spec.scene.materials["red"];
  material.preset = "plastic-red";
  material.base_color = glm::vec4(0.5f);
  material.metallic = material.perceptual_roughness = material.emissive_strength = 0.5f;
  material.normal_scale = material.occlusion_strength = 0.5f;
  material.alpha_cutoff = 0.25f;
  material.emissive = glm::vec3(0.5f);
  material.alpha_mode = AlphaMode::kMask;
  material.double_sided = material.unlit = false;
  return spec;
}

struct Mutation {
  const char* field;
  std::function<void(RenderSpec&)> apply;
};

MaterialOverride& red(RenderSpec& spec) {
  return spec.scene.materials.at("red");
}
TextureFile& texture(RenderSpec& spec, TextureUse use = TextureUse::kBaseColor) {
  return red(spec).textures[std::size_t(use)].emplace<TextureFile>();
}
NodeSpec& node(RenderSpec& spec) {
  return spec.scene.nodes[0];
}
OrbitCamera& orbit(RenderSpec& spec) {
  return std::get<OrbitCamera>(spec.camera.view);
}
Light& light(RenderSpec& spec) {
  return spec.scene.lights.emplace_back();
}

EnvironmentBackground& seen(RenderSpec& spec) {
  return std::get<EnvironmentBackground>(spec.environment.background);
}

GroundSpec& ground(RenderSpec& spec) {
  return spec.environment.ground.emplace();
}

LookAtCamera& look(RenderSpec& spec) {
  if (!std::holds_alternative<LookAtCamera>(spec.camera.view)) spec.camera.view = LookAtCamera{};
  return std::get<LookAtCamera>(spec.camera.view);
}

template <class T>
T& map(RenderSpec& spec) {
  auto* procedural = std::get_if<ProceduralEnvironment>(&spec.environment.map);
  if (procedural == nullptr) procedural = &spec.environment.map.emplace<ProceduralEnvironment>();
  return std::holds_alternative<T>(*procedural) ? std::get<T>(*procedural) : procedural->emplace<T>();
}

IntrinsicsCamera& calibrated(RenderSpec& spec) {
  if (!std::holds_alternative<IntrinsicsCamera>(spec.camera.view)) spec.camera.view = IntrinsicsCamera{};
  return std::get<IntrinsicsCamera>(spec.camera.view);
}

const std::vector<Mutation> kMutations = {
    {"intrinsics", [](RenderSpec& s) { calibrated(s); }},
    {"intrinsics focal x", [](RenderSpec& s) { calibrated(s).focal_px.x = 2; }},
    {"intrinsics focal y", [](RenderSpec& s) { calibrated(s).focal_px.y = 2; }},
    {"intrinsics principal x", [](RenderSpec& s) { calibrated(s).principal_px.x = 2; }},
    {"intrinsics principal y", [](RenderSpec& s) { calibrated(s).principal_px.y = 2; }},
    {"intrinsics width", [](RenderSpec& s) { calibrated(s).picture_px.x = 2; }},
    {"intrinsics height", [](RenderSpec& s) { calibrated(s).picture_px.y = 2; }},
    {"intrinsics translation", [](RenderSpec& s) { calibrated(s).translation.z = 2; }},
    {"intrinsics rotation", [](RenderSpec& s) { calibrated(s).rotation.y = 0.5f; }},
    {"nothing", [](RenderSpec&) {}},
    {"model", [](RenderSpec& s) { s.scene.model = model_of(2); }},
    {"no model", [](RenderSpec& s) { s.scene.model = nullptr; }},
    {"model without a hash", [](RenderSpec& s) { s.scene.model = model_of(0); }},
    {"gltf scene", [](RenderSpec& s) { s.scene.gltf_scene = 0; }},
    {"up axis", [](RenderSpec& s) { s.scene.up_axis = UpAxis::kY; }},
    {"other up axis", [](RenderSpec& s) { s.scene.up_axis = UpAxis::kZ; }},
    {"one node less", [](RenderSpec& s) { s.scene.nodes.pop_back(); }},
    {"nodes swapped", [](RenderSpec& s) { std::swap(s.scene.nodes[0], s.scene.nodes[1]); }},
    {"node mesh", [](RenderSpec& s) { node(s).mesh = "torus"; }},
    {"node material", [](RenderSpec& s) { node(s).material = "red"; }},
    {"node without material", [](RenderSpec& s) { node(s).material.reset(); }},
    {"node with empty material", [](RenderSpec& s) { node(s).material = ""; }},
    {"node translation x", [](RenderSpec& s) { node(s).translation.x = 1; }},
    {"node translation y", [](RenderSpec& s) { node(s).translation.y = 1; }},
    {"node translation z", [](RenderSpec& s) { node(s).translation.z = 1; }},
    {"node rotation w", [](RenderSpec& s) { node(s).rotation.w = 0.5f; }},
    {"node rotation x", [](RenderSpec& s) { node(s).rotation.x = 0.5f; }},
    {"node rotation y", [](RenderSpec& s) { node(s).rotation.y = 0.5f; }},
    {"node rotation z", [](RenderSpec& s) { node(s).rotation.z = 0.5f; }},
    {"node scale", [](RenderSpec& s) { node(s).scale.y = 2; }},
    {"no material", [](RenderSpec& s) { s.scene.materials.clear(); }},
    {"material key",
     [](RenderSpec& s) {
       s.scene.materials = {{"rot", s.scene.materials.at("red")}};
     }},
    {"material added", [](RenderSpec& s) { s.scene.materials["other"]; }},
    {"preset", [](RenderSpec& s) { red(s).preset = "chalk"; }},
    {"no preset", [](RenderSpec& s) { red(s).preset.reset(); }},
    {"base color", [](RenderSpec& s) { red(s).base_color->a = 1; }},
    {"no base color", [](RenderSpec& s) { red(s).base_color.reset(); }},
    {"metallic", [](RenderSpec& s) { red(s).metallic = 0; }},
    {"no metallic", [](RenderSpec& s) { red(s).metallic.reset(); }},
    {"roughness", [](RenderSpec& s) { red(s).perceptual_roughness = 0; }},
    {"no roughness", [](RenderSpec& s) { red(s).perceptual_roughness.reset(); }},
    {"emissive strength", [](RenderSpec& s) { red(s).emissive_strength = 0; }},
    {"no emissive strength", [](RenderSpec& s) { red(s).emissive_strength.reset(); }},
    {"normal scale", [](RenderSpec& s) { red(s).normal_scale = 0; }},
    {"no normal scale", [](RenderSpec& s) { red(s).normal_scale.reset(); }},
    {"occlusion strength", [](RenderSpec& s) { red(s).occlusion_strength = 0; }},
    {"no occlusion strength", [](RenderSpec& s) { red(s).occlusion_strength.reset(); }},
    {"alpha cutoff", [](RenderSpec& s) { red(s).alpha_cutoff = 0; }},
    {"no alpha cutoff", [](RenderSpec& s) { red(s).alpha_cutoff.reset(); }},
    {"emissive", [](RenderSpec& s) { red(s).emissive->b = 0; }},
    {"no emissive", [](RenderSpec& s) { red(s).emissive.reset(); }},
    {"alpha mode", [](RenderSpec& s) { red(s).alpha_mode = AlphaMode::kOpaque; }},
    {"no alpha mode", [](RenderSpec& s) { red(s).alpha_mode.reset(); }},
    {"double sided", [](RenderSpec& s) { red(s).double_sided = true; }},
    {"no double sided", [](RenderSpec& s) { red(s).double_sided.reset(); }},
    {"unlit", [](RenderSpec& s) { red(s).unlit = true; }},
    {"no unlit", [](RenderSpec& s) { red(s).unlit.reset(); }},
    {"variant", [](RenderSpec& s) { s.scene.variant = "a"; }},
    {"other variant", [](RenderSpec& s) { s.scene.variant = "b"; }},
    {"shading model", [](RenderSpec& s) { s.scene.shading_model = ShadingModel::kPhong; }},
    {"material's model", [](RenderSpec& s) { red(s).model = ShadingModel::kPbr; }},
    {"ior", [](RenderSpec& s) { red(s).ior = 0; }},
    {"specular", [](RenderSpec& s) { red(s).specular = 0; }},
    {"clearcoat", [](RenderSpec& s) { red(s).clearcoat = 0; }},
    {"clearcoat perceptual roughness", [](RenderSpec& s) { red(s).clearcoat_perceptual_roughness = 0; }},
    {"clearcoat normal scale", [](RenderSpec& s) { red(s).clearcoat_normal_scale = 0; }},
    {"sheen perceptual roughness", [](RenderSpec& s) { red(s).sheen_perceptual_roughness = 0; }},
    {"anisotropy", [](RenderSpec& s) { red(s).anisotropy = 0; }},
    {"anisotropy rotation rad", [](RenderSpec& s) { red(s).anisotropy_rotation_rad = 0; }},
    {"iridescence", [](RenderSpec& s) { red(s).iridescence = 0; }},
    {"iridescence ior", [](RenderSpec& s) { red(s).iridescence_ior = 0; }},
    {"iridescence thickness min nm", [](RenderSpec& s) { red(s).iridescence_thickness_min_nm = 0; }},
    {"iridescence thickness max nm", [](RenderSpec& s) { red(s).iridescence_thickness_max_nm = 0; }},
    {"transmission", [](RenderSpec& s) { red(s).transmission = 0; }},
    {"thickness m", [](RenderSpec& s) { red(s).thickness_m = 0; }},
    {"attenuation distance m", [](RenderSpec& s) { red(s).attenuation_distance_m = 0; }},
    {"dispersion", [](RenderSpec& s) { red(s).dispersion = 0; }},
    {"diffuse transmission", [](RenderSpec& s) { red(s).diffuse_transmission = 0; }},
    {"specular color", [](RenderSpec& s) { red(s).specular_color = glm::vec3(1); }},
    {"sheen color", [](RenderSpec& s) { red(s).sheen_color = glm::vec3(1); }},
    {"attenuation color", [](RenderSpec& s) { red(s).attenuation_color = glm::vec3(1); }},
    {"diffuse transmission color", [](RenderSpec& s) { red(s).diffuse_transmission_color = glm::vec3(1); }},
    {"texture", [](RenderSpec& s) { texture(s); }},
    {"texture of another use", [](RenderSpec& s) { texture(s, TextureUse::kDiffuseTransmissionColor); }},
    {"no texture", [](RenderSpec& s) { red(s).textures[0] = NoTexture{}; }},
    {"texture bytes", [](RenderSpec& s) { texture(s).encoded = Blob(std::string("other")); }},
    {"texture UV set", [](RenderSpec& s) { texture(s).uv_set = 1; }},
    {"texture wrap u", [](RenderSpec& s) { texture(s).sampler.wrap_u = Wrap::kClampToEdge; }},
    {"texture wrap v", [](RenderSpec& s) { texture(s).sampler.wrap_v = Wrap::kClampToEdge; }},
    {"texture magnified", [](RenderSpec& s) { texture(s).sampler.mag = Filter::kNearest; }},
    {"texture minified", [](RenderSpec& s) { texture(s).sampler.min = Filter::kNearest; }},
    {"texture levels", [](RenderSpec& s) { texture(s).sampler.mip = MipFilter::kNearest; }},
    {"texture offset", [](RenderSpec& s) { texture(s).transform.offset.y = 1; }},
    {"texture rotation", [](RenderSpec& s) { texture(s).transform.rotation_rad = 1; }},
    {"texture scale", [](RenderSpec& s) { texture(s).transform.scale.x = 2; }},
    {"a light", [](RenderSpec& s) { light(s); }},
    {"light's kind", [](RenderSpec& s) { light(s).kind = LightKind::kSpot; }},
    {"light's name", [](RenderSpec& s) { light(s).name = "a"; }},
    {"light's position", [](RenderSpec& s) { light(s).position.x = 1; }},
    {"light's direction", [](RenderSpec& s) { light(s).direction = {0, 1, 0}; }},
    {"light's intensity", [](RenderSpec& s) { light(s).intensity.g = 0; }},
    {"light's range", [](RenderSpec& s) { light(s).range_m = 1; }},
    {"inner cone", [](RenderSpec& s) { light(s).inner_cone_rad = 0.1; }},
    {"outer cone", [](RenderSpec& s) { light(s).outer_cone_rad = 0.1; }},
    {"light's radius", [](RenderSpec& s) { light(s).radius_m = 0.1; }},
    {"light's angular radius", [](RenderSpec& s) { light(s).angular_radius_rad = 0.1; }},
    {"no shadow", [](RenderSpec& s) { light(s).casts_shadow = false; }},
    {"no lights of the model", [](RenderSpec& s) { s.scene.model_lights = false; }},
    {"environment name", [](RenderSpec& s) { s.environment.map = BuiltinName{"overcast"}; }},
    {"environment file", [](RenderSpec& s) { s.environment.map = EnvironmentFile{Blob(std::string("a"))}; }},
    {"other file", [](RenderSpec& s) { s.environment.map = EnvironmentFile{Blob(std::string("b"))}; }},
    {"environment color", [](RenderSpec& s) { s.environment.map = EnvironmentColor{}; }},
    {"other color", [](RenderSpec& s) { s.environment.map = EnvironmentColor{{1, 1, 0.5f}}; }},
    {"gradient", [](RenderSpec& s) { map<GradientEnvironment>(s); }},
    {"gradient stop", [](RenderSpec& s) { map<GradientEnvironment>(s).stops[0].elevation_deg = -80; }},
    {"gradient stop radiance", [](RenderSpec& s) { map<GradientEnvironment>(s).stops[0].radiance.b = 9; }},
    {"gradient stop less", [](RenderSpec& s) { map<GradientEnvironment>(s).stops.pop_back(); }},
    {"gradient blend", [](RenderSpec& s) { map<GradientEnvironment>(s).blend = GradientBlend::kSmooth; }},
    {"overcast", [](RenderSpec& s) { map<OvercastEnvironment>(s); }},
    {"zenith luminance", [](RenderSpec& s) { map<OvercastEnvironment>(s).zenith_luminance = 9; }},
    {"ground albedo of overcast", [](RenderSpec& s) { map<OvercastEnvironment>(s).ground_albedo = 0.9; }},
    {"clear sky", [](RenderSpec& s) { map<ClearSkyEnvironment>(s); }},
    {"turbidity", [](RenderSpec& s) { map<ClearSkyEnvironment>(s).turbidity = 9; }},
    {"ground albedo of clear sky", [](RenderSpec& s) { map<ClearSkyEnvironment>(s).ground_albedo = 0.9; }},
    {"sun elevation", [](RenderSpec& s) { map<ClearSkyEnvironment>(s).sun_elevation_rad = 1; }},
    {"sun azimuth", [](RenderSpec& s) { map<ClearSkyEnvironment>(s).sun_azimuth_rad = 1; }},
    {"sun disc", [](RenderSpec& s) { map<ClearSkyEnvironment>(s).sun_disc = false; }},
    {"sun radius", [](RenderSpec& s) { map<ClearSkyEnvironment>(s).sun_radius_rad = 0.02; }},
    {"calibration",
     [](RenderSpec& s) { map<ClearSkyEnvironment>(s).calibration = SkyCalibration::kPhysical; }},
    {"studio", [](RenderSpec& s) { map<StudioEnvironment>(s); }},
    {"studio room", [](RenderSpec& s) { map<StudioEnvironment>(s).room.stops[0].elevation_deg = -80; }},
    {"second light", [](RenderSpec& s) { map<StudioEnvironment>(s).lights.emplace_back(); }},
    {"light shape", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].shape = LightShape::kDisc; }},
    {"light azimuth_rad", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].azimuth_rad = 1; }},
    {"light elevation_rad", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].elevation_rad = 1; }},
    {"light roll_rad", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].roll_rad = 1; }},
    {"light width_rad", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].width_rad = 1; }},
    {"light height_rad", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].height_rad = 1; }},
    {"light color", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].color = glm::dvec3(1, 0, 0); }},
    {"light luminance", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].luminance = 1; }},
    {"light feather", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].feather = 1; }},
    {"light hotspot", [](RenderSpec& s) { map<StudioEnvironment>(s).lights[0].hotspot = 2; }},
    {"environment rotation", [](RenderSpec& s) { s.environment.rotation_rad = 1; }},
    {"environment visibility", [](RenderSpec& s) { s.environment.visibility = EnvironmentVisibility::kOn; }},
    {"no environment visibility",
     [](RenderSpec& s) { s.environment.visibility = EnvironmentVisibility::kOff; }},
    {"intensity", [](RenderSpec& s) { s.environment.intensity = 2; }},
    {"illuminance", [](RenderSpec& s) { s.environment.illuminance_lux = 1000; }},
    {"suns kept", [](RenderSpec& s) { s.environment.sun = SunMode::kKeep; }},
    {"suns extracted", [](RenderSpec& s) { s.environment.sun = SunMode::kExtract; }},
    {"transparent background", [](RenderSpec& s) { s.environment.background = TransparentBackground{}; }},
    {"black background", [](RenderSpec& s) { s.environment.background = ColorBackground{}; }},
    {"background color", [](RenderSpec& s) { s.environment.background = ColorBackground{{0, 1, 0}}; }},
    {"gradient", [](RenderSpec& s) { s.environment.background = GradientBackground{}; }},
    {"gradient's top", [](RenderSpec& s) { s.environment.background = GradientBackground{{0, 1, 0}, {}}; }},
    {"gradient's bottom",
     [](RenderSpec& s) { s.environment.background = GradientBackground{{1, 1, 1}, {0, 1, 0}}; }},
    {"background map", [](RenderSpec& s) { seen(s).map = BuiltinName{"studio"}; }},
    {"other background map", [](RenderSpec& s) { seen(s).map = BuiltinName{"sky"}; }},
    {"background rotation", [](RenderSpec& s) { seen(s).rotation_rad = 0; }},
    {"background intensity", [](RenderSpec& s) { seen(s).intensity = 2; }},
    {"background blur", [](RenderSpec& s) { seen(s).blur_rad = 0.1; }},
    {"ground", [](RenderSpec& s) { s.environment.ground = GroundSpec{}; }},
    {"ground without shadow", [](RenderSpec& s) { ground(s).shadow = false; }},
    {"shadow strength", [](RenderSpec& s) { ground(s).shadow_strength = 0.5; }},
    {"ground level", [](RenderSpec& s) { ground(s).level_m = 0; }},
    {"ground projection", [](RenderSpec& s) { ground(s).projection = GroundProjection{}; }},
    {"projection height", [](RenderSpec& s) { ground(s).projection = GroundProjection{.height_m = 2}; }},
    {"projection radius", [](RenderSpec& s) { ground(s).projection = GroundProjection{.radius_m = 9}; }},
    {"azimuth", [](RenderSpec& s) { orbit(s).azimuth_rad = 1; }},
    {"elevation", [](RenderSpec& s) { orbit(s).elevation_rad = 1; }},
    {"fit", [](RenderSpec& s) { orbit(s).fit = 1; }},
    {"orbit field of view", [](RenderSpec& s) { orbit(s).fov_y_rad = 1; }},
    {"orthographic", [](RenderSpec& s) { orbit(s).orthographic = true; }},
    {"look-at", [](RenderSpec& s) { look(s); }},
    {"eye", [](RenderSpec& s) { look(s).eye.x = 1; }},
    {"target", [](RenderSpec& s) { look(s).target.x = 1; }},
    {"up", [](RenderSpec& s) { look(s).up.x = 1; }},
    {"look-at field of view", [](RenderSpec& s) { look(s).fov_y_rad = 1; }},
    {"glTF camera", [](RenderSpec& s) { s.camera.view = GltfCamera{}; }},
    {"glTF camera 1", [](RenderSpec& s) { s.camera.view = GltfCamera{1}; }},
    {"glTF camera by name", [](RenderSpec& s) { s.camera.view = GltfCamera{"front"}; }},
    {"exposure", [](RenderSpec& s) { s.camera.exposure_ev = 1; }},
    {"EV100", [](RenderSpec& s) { s.camera.metering = PhysicalExposure{}; }},
    {"EV100 of daylight", [](RenderSpec& s) { s.camera.metering = PhysicalExposure{15}; }},
    {"automatic exposure", [](RenderSpec& s) { s.camera.metering = AutoExposure{}; }},
    {"depth of field", [](RenderSpec& s) { s.camera.depth_of_field.emplace(); }},
    {"f-number", [](RenderSpec& s) { s.camera.depth_of_field.emplace().f_stop = 4; }},
    {"sensor height", [](RenderSpec& s) { s.camera.depth_of_field.emplace().sensor_height_m = 0.01; }},
    {"aperture diameter",
     [](RenderSpec& s) { s.camera.depth_of_field.emplace().aperture_diameter_m = 0.01; }},
    {"focus distance", [](RenderSpec& s) { s.camera.depth_of_field.emplace().focus_distance_m = 1; }},
    {"focus point", [](RenderSpec& s) { s.camera.depth_of_field.emplace().focus_point = glm::vec3(1); }},
    {"blades", [](RenderSpec& s) { s.camera.depth_of_field.emplace().blades = 5; }},
    {"blade rotation", [](RenderSpec& s) { s.camera.depth_of_field.emplace().blade_rotation_rad = 1; }},
    {"pixel filter", [](RenderSpec& s) { s.output.pixel_filter.kind = PixelFilterKind::kMitchell; }},
    {"filter radius", [](RenderSpec& s) { s.output.pixel_filter.radius_px = 1; }},
    {"bloom", [](RenderSpec& s) { s.output.bloom.emplace(); }},
    {"bloom intensity", [](RenderSpec& s) { s.output.bloom.emplace().intensity = 0.5; }},
    {"bloom radius", [](RenderSpec& s) { s.output.bloom.emplace().radius = 0.2; }},
    {"bloom of emission", [](RenderSpec& s) { s.output.bloom.emplace().source = BloomSource::kEmission; }},
    {"bloom threshold", [](RenderSpec& s) { s.output.bloom.emplace().threshold = 2; }},
    {"white balance", [](RenderSpec& s) { s.output.grade.white_balance_kelvin = 2856; }},
    {"tint", [](RenderSpec& s) { s.output.grade.white_balance_tint = 10; }},
    {"contrast", [](RenderSpec& s) { s.output.grade.contrast = 1.1; }},
    {"saturation", [](RenderSpec& s) { s.output.grade.saturation = 1.1; }},
    {"width", [](RenderSpec& s) { s.output.width = 512; }},
    {"height", [](RenderSpec& s) { s.output.height = 512; }},
    {"format", [](RenderSpec& s) { s.output.format = OutputFormat::kExr; }},
    {"EXR type", [](RenderSpec& s) { s.output.exr_type = SampleType::kFloat32; }},
    {"JPEG", [](RenderSpec& s) { s.output.format = OutputFormat::kJpeg; }},
    {"WebP", [](RenderSpec& s) { s.output.format = OutputFormat::kWebp; }},
    {"dither", [](RenderSpec& s) { s.output.dither = true; }},
    {"bit depth", [](RenderSpec& s) { s.output.bit_depth = 16; }},
    {"EXR compression", [](RenderSpec& s) { s.output.exr_compression = ExrCompression::kZip; }},
    {"compression quality", [](RenderSpec& s) { s.output.compression_quality = 80; }},
    {"lossless", [](RenderSpec& s) { s.output.lossless = true; }},
    {"tone map", [](RenderSpec& s) { s.output.tone_map = ToneMap::kNone; }},
    {"samples", [](RenderSpec& s) { s.output.samples = 16; }},
    {"layers", [](RenderSpec& s) { s.output.layers = {FilmLayer::kDepth}; }},
    {"other layers", [](RenderSpec& s) { s.output.layers = {FilmLayer::kNormal}; }},
    {"shown", [](RenderSpec& s) { s.output.shown = FilmLayer::kDepth; }},
    {"node name", [](RenderSpec& s) { s.scene.nodes[0].name = "a"; }},
    {"strict", [](RenderSpec& s) { s.strict = true; }},
};

TEST(SpecHash, EveryFieldMakesItsOwnDifference) {
  std::map<ContentHash, const char*> seen;
  for (const Mutation& mutation : kMutations) {
    RenderSpec spec = full_spec();
    mutation.apply(spec);
    const auto [other, fresh] = seen.emplace(spec_hash(spec), mutation.field);
    EXPECT_TRUE(fresh) << '"' << mutation.field << "\" hashes like \"" << other->second << '"';
  }
}

TEST(FormatFault, NamesWhatAFormatCannotHold) {
  RenderSpec spec;
  spec.output.width = 16384;
  for (const OutputFormat format : {OutputFormat::kPng, OutputFormat::kExr, OutputFormat::kJpeg}) {
    spec.output.format = format;
    EXPECT_EQ(format_fault(spec), "");
  }
  spec.output.format = OutputFormat::kWebp;
  EXPECT_NE(format_fault(spec).find("16383"), std::string::npos);
  spec.output.width = 16383;
  spec.environment.background = TransparentBackground{};
  EXPECT_EQ(format_fault(spec), "");
  spec.output.format = OutputFormat::kJpeg;
  EXPECT_NE(format_fault(spec).find("transparent"), std::string::npos);
}

TEST(RenderSpec, OnlyAnExrThatLosesNothingKeepsLayers) {
  OutputSpec output;
  EXPECT_EQ(layers_fault(output), "");
  output.layers = {FilmLayer::kDepth};
  EXPECT_NE(layers_fault(output).find("EXR"), std::string::npos);
  output.format = OutputFormat::kExr;
  EXPECT_EQ(layers_fault(output), "");
  output.exr_compression = ExrCompression::kDwaa;
  EXPECT_NE(layers_fault(output).find("dwaa"), std::string::npos);
}

TEST(SpecHash, EqualSpecsAreEqual) {
  for (const Mutation& mutation : kMutations) {
    RenderSpec a = full_spec(), b = full_spec();
    mutation.apply(a);
    mutation.apply(b);
    EXPECT_EQ(spec_hash(a), spec_hash(b)) << mutation.field;
  }
  EXPECT_EQ(spec_hash(RenderSpec{}), spec_hash(RenderSpec{}));
}

TEST(SpecHash, OrderOfInsertionIntoAMapDoesNotMatter) {
  RenderSpec a, b;
  a.scene.materials["x"].metallic = 1;
  a.scene.materials["y"].metallic = 0;
  b.scene.materials["y"].metallic = 0;
  b.scene.materials["x"].metallic = 1;
  EXPECT_EQ(spec_hash(a), spec_hash(b));
}

TEST(SpecHash, ZeroHasNoSign) {
  RenderSpec a, b;
  a.camera.exposure_ev = 0.0;
  b.camera.exposure_ev = -0.0;
  a.environment.background = ColorBackground{};
  b.environment.background = ColorBackground{glm::vec3(-0.0f)};
  EXPECT_EQ(spec_hash(a), spec_hash(b));
}

TEST(SpecHash, NeighbouringStringsDoNotRunTogether) {
  RenderSpec a, b;
  a.scene.nodes = {NodeSpec{.mesh = "ab", .material = "c"}};
  b.scene.nodes = {NodeSpec{.mesh = "a", .material = "bc"}};
  EXPECT_NE(spec_hash(a), spec_hash(b));
}

TEST(SpecHash, AModelIsItsBytesNotItsAddress) {
  RenderSpec a, b;
  a.scene.model = model_of(7);
  b.scene.model = model_of(7);
  EXPECT_EQ(spec_hash(a), spec_hash(b));
}

}  // namespace
}  // namespace furnace
