#include "renderer/frame/covered_pixels.hpp"

#include <algorithm>
#include <cmath>

namespace furnace {
namespace {

gl::PixelRect grown(const gl::PixelRect& rect, int margin_px, Extent tile) {
  if (rect.empty()) return rect;
  const int left = std::max(rect.x - margin_px, 0), top = std::max(rect.y - margin_px, 0);
  return {left, top, std::min(rect.x + rect.width + margin_px, tile.width) - left,
          std::min(rect.y + rect.height + margin_px, tile.height) - top};
}

}  // namespace

gl::PixelRect covered_pixels(const gpu::FrameBlock& frame, Extent tile, const Draw& draw) {
  const glm::mat4 clip_from_model = frame.clip_from_world * draw.world_from_model;
  const Bounds& bounds = draw.mesh->bounds;
  glm::vec2 low(1), high(-1);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 at(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                       corner & 4 ? bounds.max.z : bounds.min.z);
    const glm::vec4 clip = clip_from_model * glm::vec4(at, 1);
    if (!(clip.w > 0) || clip.z > clip.w) return {0, 0, tile.width, tile.height};
    low = glm::min(low, glm::vec2(clip) / clip.w);
    high = glm::max(high, glm::vec2(clip) / clip.w);
  }
  low = glm::clamp(low, -1.f, 1.f);
  high = glm::clamp(high, -1.f, 1.f);
  // A pixel more on each side, for rounding.
  const auto pixel = [](float ndc, int length) { return int(std::floor((ndc + 1) * 0.5f * float(length))); };
  const int left = std::max(pixel(low.x, tile.width) - 1, 0),
            right = std::min(pixel(high.x, tile.width) + 2, tile.width);
  const int top = std::max(pixel(-high.y, tile.height) - 1, 0),
            bottom = std::min(pixel(-low.y, tile.height) + 2, tile.height);
  return {left, top, std::max(right - left, 0), std::max(bottom - top, 0)};
}

gl::PixelRect veiled_pixels(const gpu::FrameBlock& frame, Extent tile, const GpuScene& scene) {
  gl::PixelRect all;
  for (const Draw& draw : scene.blended) all = joined(all, covered_pixels(frame, tile, draw));
  // Points are as large as this, lines two samples wide.
  const int margin_px = int(std::ceil(std::max(frame.point_size_samples, 2.f) / 4)) + 1;
  for (const Draw& draw : scene.strokes)
    all = joined(all, grown(covered_pixels(frame, tile, draw), margin_px, tile));
  return all;
}

}  // namespace furnace
