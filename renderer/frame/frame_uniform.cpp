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

// (ndc.x, ndc.y, 1) -> world direction through that point of the picture.
glm::dmat4 world_from_ray(const View& view, const FramePlan& plan, glm::vec2 jitter_px) {
  glm::dmat4 clip_from_view(view.clip_from_view);
  if (view.orthographic) {
    const double aspect = double(plan.picture.width) / plan.picture.height;
    clip_from_view = glm::dmat4(perspective_reversed(kOrthographicBackgroundFovRad, aspect, 1, 2));
  }
  const double shift_x = 2.0 * jitter_px.x / plan.picture.width;
  const double shift_y = -2.0 * jitter_px.y / plan.picture.height;
  // Off-centre projections look along (P[2][0], P[2][1]) too.
  glm::dmat3 view_from_ray(0);
  view_from_ray[0][0] = 1 / clip_from_view[0][0];
  view_from_ray[1][1] = 1 / clip_from_view[1][1];
  view_from_ray[2] = {(clip_from_view[2][0] - shift_x) / clip_from_view[0][0],
                      (clip_from_view[2][1] - shift_y) / clip_from_view[1][1], -1};
  const glm::dmat3 world_from_view = glm::transpose(glm::dmat3(view.view_from_world));
  return glm::dmat4(world_from_view * view_from_ray);
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

}  // namespace

gpu::FrameBlock pack_frame(const FramePlan& plan, const View& view, const PreparedEnvironment& environment,
                           const Tile& tile, std::size_t subframe) {
  const glm::vec2 jitter_px = plan.jitter_px[subframe];
  gpu::FrameBlock block{};
  const glm::dmat4 tile_from_clip = tile_from_picture(plan.picture, tile);
  block.clip_from_world = glm::mat4(tile_from_clip * jittered_from_clip(plan.picture, jitter_px) *
                                    glm::dmat4(view.clip_from_view) * glm::dmat4(view.view_from_world));
  const glm::dmat4 ray = world_from_ray(view, plan, jitter_px);
  block.world_from_ray = glm::mat4(glm::dmat4(glm::dmat3(ray) * ray_from_tile(tile_from_clip)));
  block.environment_from_world =
      glm::mat4(glm::rotate(glm::dmat4(1), -plan.environment_rotation_rad, glm::dvec3(0, 1, 0)));
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
  block.atlas_gain = float(plan.environment_intensity / atlas.scale);
  block.sky_gain = float(plan.environment_intensity / environment.sky_scale);

  block.pixel_footprint = float(1 / std::sqrt(double(plan.jitter_px.size())));
  // Two pixels at 512 px, in proportion elsewhere.
  block.point_size_samples = 2 * std::max(1.f, float(plan.picture.height) / 256.f);
  block.exposure = float(plan.exposure);
  block.ndc_per_pixel_x = 2.f / float(tile.size.width);
  block.ndc_per_pixel_y = -2.f / float(tile.size.height);
  const double sky_texel_rad = 2 * kPi / environment.sky.extent.width;
  const double pixel_rad = 2 * glm::length(glm::dvec3(ray[1])) / plan.picture.height;
  block.sky_lod = float(std::log2(pixel_rad / sky_texel_rad));
  // A surface seen at 80 degrees from its normal changes so much in depth from sample to sample.
  constexpr double kSlope = 6;
  block.depth_tolerance = float(kSlope * pixel_rad);
  return block;
}

}  // namespace furnace
