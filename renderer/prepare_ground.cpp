#include "renderer/prepare_ground.hpp"

#include <algorithm>
#include <utility>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/occluder.hpp"

namespace furnace {
namespace {

constexpr int kLeastLights = 128, kMostLights = 1024;
constexpr int kLeastPlaces = 16, kMostPlaces = 128;

// A run of the list, which is spread as well as all of it, and stands for all of its light.
std::vector<LightDirection> part_of(const std::vector<LightDirection>& lights, LightPart part) {
  const std::size_t count = lights.size() / std::size_t(part.count);
  const auto first = lights.begin() + std::ptrdiff_t(count * std::size_t(part.index));
  std::vector<LightDirection> run(first, first + std::ptrdiff_t(count));
  for (LightDirection& light : run) {
    for (double& share : light.irradiance) share *= part.count;
  }
  return run;
}

// The environment's light and that of directional lights, in world space: about `count` directions.
std::vector<LightDirection> light_on_ground(const PreparedScene& scene, double rotation_rad, int count,
                                            LightPart part) {
  const int all_parts = count * part.count;
  std::vector<std::vector<LightDirection>> all = {
      in_world(part_of(ground_light(scene.environment->sky.texels, all_parts), part), scene, rotation_rad)};
  for (const Light& light : scene.lights) {
    if (light.kind != LightKind::kDirectional || !light.casts_shadow) continue;
    const glm::dvec3 &d = light.direction, &e = light.intensity;
    all.push_back(part_of(
        ground_light({-d.x, -d.y, -d.z}, {e.x, e.y, e.z}, light.angular_radius_rad, all_parts), part));
  }
  return joined_by_light(std::move(all), count);
}

}  // namespace

glm::dvec3 vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

glm::dmat3 turned_about_y(double angle_rad) {
  return glm::dmat3(glm::rotate(glm::dmat4(1), angle_rad, glm::dvec3(0, 1, 0)));
}

std::vector<LightDirection> in_world(std::vector<LightDirection> sources, const PreparedScene& scene,
                                     double rotation_rad) {
  const glm::dmat3 world_from_environment = turned_about_y(rotation_rad);
  for (LightDirection& source : sources) {
    const glm::dvec3 turned = world_from_environment * vector_of(source.towards);
    source.towards = {turned.x, turned.y, turned.z};
    for (double& share : source.irradiance)
      share *= scene.environment_intensity / scene.environment->sky.scale;
  }
  return sources;
}

PreparedGround GroundWork::without_shadow() const {
  PreparedGround ground;
  ground.bounds = bounds_;
  if (ground.bounds.empty()) ground.bounds = {glm::vec3(-0.5f), glm::vec3(0.5f)};  // as it is framed
  ground.level_m = wanted_.level_m.value_or(double(ground.bounds.min.y));
  return ground;
}

PreparedGround GroundWork::with_shadow(const ContentHash& scene_key, const PreparedScene& scene,
                                       LightPart part) {
  PreparedGround ground = without_shadow();
  if (!wanted_.shadow) return ground;
  // Sub-frames of finer pictures are worth finer penumbrae.
  const int lights = std::clamp(kLeastLights * samples_ / (4 * part.count), kLeastLights, kMostLights);
  const ContentHash key = HashBuilder()
                              .add("ground")
                              .add(scene_key)
                              .add(scene.environment->key)
                              .add(rotation_rad_)
                              .add(scene.environment_intensity)  // against the scene's own lights
                              .add(ground.level_m)
                              .add(std::int64_t(lights))
                              .add(std::int64_t(part.index))
                              .add(std::int64_t(part.count))
                              .finish();
  ground.shadow_key = key;
  if (resident_.contains(key)) return ground;
  ground.light = std::make_shared<const std::vector<LightDirection>>(
      light_on_ground(scene, rotation_rad_, lights, part));
  for (const Light& light : scene.lights) {
    if (light.kind != LightKind::kDirectional)
      ground.lamps.push_back(light);
    else if (!light.casts_shadow)
      ground.free_irradiance += light.intensity * std::max(-light.direction.y, 0.0);
  }
  ground.places = std::max(kMostPlaces / part.count, kLeastPlaces);
  ground.first_place = part.index * ground.places;
  ground.occluders = occluders_of(scene.meshes);
  return ground;
}

std::vector<GroundWork::Indices> GroundWork::occluders_of(const std::vector<PreparedMesh>& meshes) {
  std::vector<const PreparedMesh*> missing;
  for (const PreparedMesh& mesh : meshes) {
    if (mesh.mesh->topology == Topology::kTriangles && occluders_.try_emplace(mesh.key).second)
      missing.push_back(&mesh);
  }
  constexpr double kSimplifyCostUs = 5'000;
  pool_.parallel_for(missing.size(), kSimplifyCostUs, [&](std::size_t i) {
    occluders_.find(missing[i]->key)->second = std::make_shared<const std::vector<std::uint32_t>>(
        occluder_indices(*missing[i]->mesh, kGroundOccluder));
  });
  std::vector<Indices> occluders;
  for (const PreparedMesh& mesh : meshes) {
    const auto known = occluders_.find(mesh.key);
    occluders.push_back(known == occluders_.end() ? nullptr : known->second);
  }
  return occluders;
}

}  // namespace furnace
