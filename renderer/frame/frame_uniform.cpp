#include "renderer/frame/frame_uniform.hpp"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/base/check.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

// An orthographic camera has one viewing direction; its background is that of a pinhole of this field of view.
constexpr double kOrthographicBackgroundFovRad = 0.8;

glm::dmat4 jittered_from_clip(Extent picture, glm::vec2 jitter_px) {
  // Rows grow downwards, clip space upwards.
  return glm::translate(
      glm::dmat4(1), glm::dvec3(2.0 * jitter_px.x / picture.width, -2.0 * jitter_px.y / picture.height, 0));
}

// The tile's part of clip space, widened to the whole of it.
glm::dmat4 tile_from_picture(Extent picture, const Tile& tile) {
  const glm::dvec2 size(tile.size.width, tile.size.height);
  const glm::dvec2 scale(picture.width / size.x, picture.height / size.y);
  const glm::dvec2 shift((picture.width - 2.0 * tile.x) / size.x - 1,
                         1 - (picture.height - 2.0 * tile.y) / size.y);
  return glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(shift, 0)), glm::dvec3(scale, 1));
}

// The ray of each point of the picture, linear in (ndc.x, ndc.y, 1).
struct PictureRays {
  glm::dmat3 origin{0};     // world, m
  glm::dmat3 direction{0};  // world, not normalised
};

PictureRays rays_through(const glm::dmat4& clip_from_view, const View& view, Extent picture,
                         glm::vec2 jitter_px) {
  const double shift_x = 2.0 * jitter_px.x / picture.width;
  const double shift_y = -2.0 * jitter_px.y / picture.height;
  const glm::dmat3 world_from_view = glm::transpose(glm::dmat3(view.view_from_world));
  const double scale_x = 1 / clip_from_view[0][0], scale_y = 1 / clip_from_view[1][1];
  PictureRays rays;
  rays.origin[2] = glm::dvec3(view.eye);
  if (clip_from_view[2][3] == 0) {  // parallel
    const glm::dvec3 shift(-(clip_from_view[3][0] + shift_x) * scale_x,
                           -(clip_from_view[3][1] + shift_y) * scale_y, 0);
    rays.origin[0] = world_from_view[0] * scale_x;
    rays.origin[1] = world_from_view[1] * scale_y;
    rays.origin[2] += world_from_view * shift;
    rays.direction[2] = -world_from_view[2];
    return rays;
  }
  // Off-centre projections look along (P[2][0], P[2][1]) too.
  rays.direction[0] = world_from_view[0] * scale_x;
  rays.direction[1] = world_from_view[1] * scale_y;
  rays.direction[2] = world_from_view * glm::dvec3((clip_from_view[2][0] - shift_x) * scale_x,
                                                   (clip_from_view[2][1] - shift_y) * scale_y, -1);
  return rays;
}

// The rays on which the background is seen.
PictureRays background_rays(const View& view, const FramePlan& plan, glm::vec2 jitter_px) {
  glm::dmat4 clip_from_view(view.clip_from_view);
  if (view.orthographic && !plan.projection) {
    const double aspect = double(plan.picture.width) / plan.picture.height;
    clip_from_view = glm::dmat4(perspective_reversed(kOrthographicBackgroundFovRad, aspect, 1, 2));
  }
  return rays_through(clip_from_view, view, plan.picture, jitter_px);
}

// (ndc.x, ndc.y, 1) -> (u, v, 1) * z in `map` of the plane y = level_m, z > 0 where the ray comes down to it.
// On a ray o + t d the plane is met at t = (level - o.y) / d.y; times -d.y everything is linear in the ndc.
glm::dmat3 map_from_ndc(const PictureRays& rays, double level_m, const GroundRectangle& map) {
  const bool parallel = rays.direction[0] == glm::dvec3(0) && rays.direction[1] == glm::dvec3(0);
  glm::dmat3 ground(0);  // (x, z, 1) * z
  if (parallel) {
    const glm::dvec3 d = rays.direction[2];
    if (d.y >= 0) return ground;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 o = rays.origin[i];
      const double drop = (i == 2 ? level_m : 0) - o.y;
      ground[i] = {o.x + drop * d.x / d.y, o.z + drop * d.z / d.y, i == 2 ? 1 : 0};
    }
  } else {
    const glm::dvec3 o = rays.origin[2];
    const double drop = level_m - o.y;
    if (drop >= 0) return ground;  // an eye below the ground does not see it
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 d = rays.direction[i];
      ground[i] = {-(o.x * d.y + drop * d.x), -(o.z * d.y + drop * d.z), -d.y};
    }
  }
  const glm::dvec2 size = map.high - map.low;
  for (int i = 0; i < 3; ++i) {
    ground[i].x = (ground[i].x - map.low.x * ground[i].z) / size.x;
    ground[i].y = (ground[i].y - map.low.y * ground[i].z) / size.y;
  }
  return ground;
}

glm::mat4 rotation_undone(double rotation_rad) {
  return glm::mat4(glm::rotate(glm::dmat4(1), -rotation_rad, glm::dvec3(0, 1, 0)));
}

// (ndc of the tile, 1) -> (ndc of the picture, 1)
glm::dmat3 ray_from_tile(const glm::dmat4& tile_from_clip) {
  glm::dmat3 tile_from_ray(1);
  for (int axis = 0; axis < 2; ++axis) {
    tile_from_ray[axis][axis] = tile_from_clip[axis][axis];
    tile_from_ray[2][axis] = tile_from_clip[3][axis];
  }
  return glm::inverse(tile_from_ray);
}

// What is seen behind transmissive surfaces. `view`: from the middle of the lens, as the mean of the sub-frames.
void pack_backdrop(const FramePlan& plan, const View& view, const PreparedScene& scene,
                   gpu::FrameBlock& block) {
  const glm::dmat4 place_from_clip =
      glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(0.5, 0.5, 0)), glm::dvec3(0.5, -0.5, 1));
  block.backdrop_from_world =
      glm::mat4(place_from_clip * glm::dmat4(view.clip_from_view) * glm::dmat4(view.view_from_world));
  block.background_top = plan.background_top;
  block.background_bottom = plan.background_bottom;
  const double lit = scene.environment_intensity;
  if (scene.background == nullptr) {
    block.backdrop_kind = plan.opaque ? gpu::BACKDROP_COLOR : gpu::BACKDROP_TRANSPARENT;
  } else if (scene.background->key == scene.environment->seen().key && lit > 0) {
    block.backdrop_kind = gpu::BACKDROP_LIGHT;
    block.background_share = float(scene.background_intensity / lit);
  } else {
    block.backdrop_kind = gpu::BACKDROP_MAP;
  }
}

}  // namespace

gpu::FrameBlock pack_frame(const FramePlan& plan, const View& camera, const PreparedScene& scene,
                           const GroundRectangle* ground_map, const Tile& tile, std::size_t subframe) {
  const int subframes = int(plan.jitter_px.size());
  const bool pinhole = camera.lens.radius_m == 0 || subframes == 1;
  const View view =
      pinhole ? camera : through_lens(camera, lens_place(camera.lens, int(subframe), subframes));
  const PreparedEnvironment& environment = *scene.environment;
  const glm::vec2 jitter_px = plan.jitter_px[subframe];
  gpu::FrameBlock block{};
  const glm::dmat4 tile_from_clip = tile_from_picture(plan.picture, tile);
  const glm::dmat3 ray_from_ndc = ray_from_tile(tile_from_clip);
  block.clip_from_world = glm::mat4(tile_from_clip * jittered_from_clip(plan.picture, jitter_px) *
                                    glm::dmat4(view.clip_from_view) * glm::dmat4(view.view_from_world));
  const PictureRays rays = background_rays(view, plan, jitter_px);
  block.world_from_ray = glm::mat4(glm::dmat4(rays.direction * ray_from_ndc));
  block.environment_from_world = rotation_undone(plan.environment_rotation_rad);
  block.background_from_world = rotation_undone(plan.background_rotation_rad);
  if (plan.projection && scene.ground) {
    const glm::dvec3 middle = glm::dvec3(scene.ground->bounds.min + scene.ground->bounds.max) * 0.5;
    glm::dmat3 origin = rays.origin;
    origin[2] -= glm::dvec3(middle.x, scene.ground->level_m + plan.projection->height_m, middle.z);
    block.origin_from_ndc = glm::mat4(glm::dmat4(origin * ray_from_ndc));
    block.dome_radius = float(plan.projection->radius_m);
    block.dome_height = float(plan.projection->height_m);
  }
  if (scene.ground && ground_map != nullptr) {
    const PictureRays true_rays =
        rays_through(glm::dmat4(view.clip_from_view), view, plan.picture, jitter_px);
    block.ground_from_ndc =
        glm::mat4(glm::dmat4(map_from_ndc(true_rays, scene.ground->level_m, *ground_map) * ray_from_ndc));
    block.shadow_strength = float(plan.shadow_strength);
  }
  pack_backdrop(plan, camera, scene, block);
  block.eye_world = glm::vec4(view.eye, view.orthographic ? 0 : 1);
  block.towards_viewer_world = glm::vec4(glm::transpose(glm::mat3(view.view_from_world))[2], 0);

  const OctahedralAtlas& atlas = environment.atlas;
  FURNACE_CHECK(atlas.level_tiles.size() <= std::size(block.level_tiles), "{} levels",
                atlas.level_tiles.size());
  for (std::size_t i = 0; i < atlas.level_tiles.size(); ++i) {
    const AtlasTile& tile = atlas.level_tiles[i];
    block.level_tiles[i] = {float(tile.x), float(tile.y), float(tile.inner),
                            float(level_coordinate(atlas.level_roughness[i]))};
  }
  block.level_count = gpu::uint(atlas.level_tiles.size());
  const AtlasTile& irradiance = atlas.irradiance_tile;
  block.irradiance_tile = {float(irradiance.x), float(irradiance.y), float(irradiance.inner), 0};
  block.atlas_texel_u = 1.f / float(atlas.texels.extent.width);
  block.atlas_texel_v = 1.f / float(atlas.texels.extent.height);
  block.atlas_gain = float(scene.environment_intensity / atlas.scale);
  block.sky_gain = float(scene.environment_intensity / environment.sky.scale);

  block.pixel_footprint = float(1 / std::sqrt(double(plan.jitter_px.size())));
  // Two pixels at 512 px, in proportion elsewhere.
  block.point_size_samples = 2 * std::max(1.f, float(plan.picture.height) / 256.f);
  block.exposure = float(plan.exposure);
  block.ndc_per_pixel_x = 2.f / float(tile.size.width);
  block.ndc_per_pixel_y = -2.f / float(tile.size.height);
  const double pixel_rad = 2 * glm::length(rays.direction[1]) / plan.picture.height;
  if (scene.background != nullptr) {
    const double texel_rad = 2 * kPi / scene.background->texels.extent.width;
    block.background_lod = float(std::log2(pixel_rad / texel_rad));
    block.background_gain = float(scene.background_intensity / scene.background->scale);
  }
  // A surface seen at 80 degrees from its normal changes so much in depth from sample to sample.
  constexpr double kSlope = 6;
  block.depth_tolerance = float(kSlope * pixel_rad);
  return block;
}

}  // namespace furnace
