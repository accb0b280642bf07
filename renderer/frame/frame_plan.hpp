// What one frame will do, decided before any GL call: a pure function of the request and the context's limits.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/frame/layer_plan.hpp"
#include "renderer/image/image.hpp"
#include "renderer/scene/framing.hpp"
#include "renderer/scene/render_spec.hpp"

namespace furnace {

// A rectangle of the picture, px from its top left.
struct Tile {
  int x = 0, y = 0;
  Extent size;
};

struct PlannedGrade {
  glm::mat3 white_balance{1};  // linear Rec.709
  float contrast = 1, saturation = 1;
};

// See bloom.hpp.
struct PlannedBloom {
  BloomSource source = BloomSource::kAll;
  float intensity = 0, threshold = 0;  // share; exposed radiance
  Image glow;  // exposed radiance of the whole picture before `intensity`, RGBA kFloat32
};

struct FramePlan {
  Extent picture;
  std::vector<Tile>
      tiles;         // cover the picture without overlap, row by row; all but the last of a row equally large
  Extent tile_size;  // of the largest tile: the size of the render targets
  std::vector<glm::vec2>
      jitter_px;  // one offset per sub-frame, within the filter's radius; of a box filter their mean is 0
  std::vector<float> weights;  // of each sub-frame; their sum is 1
  // Premultiplied linear radiance before exposure, at the picture's upper and lower edge; 0 where an environment is seen.
  glm::vec4 background_top{0}, background_bottom{0};
  double environment_rotation_rad = 0, background_rotation_rad = 0;
  double shadow_strength = 1;  // of the ground
  bool sky_shadows = false;    // as sky_is_shadowed()
  std::optional<GroundProjection> projection;
  double exposure_ev = 0;             // stops, of all that the camera asks for
  double exposure = 1;                // multiplier, 2^exposure_ev
  std::optional<PlannedGrade> grade;  // none: radiance stays as it is
  std::optional<PlannedBloom> bloom;
  bool glow_only = false;  // what is drawn is no picture, but what glows of it
  LayerPlan layers;
  ToneMap tone_map = ToneMap::kPbrNeutral;
  SampleType film_type = SampleType::kUint8;  // kUint8/16: tone-mapped sRGB; kFloat16/32: linear
  bool dither = false;                        // of a film of kUint8
  bool opaque = true;                         // no transparent pixel can come out

  // Whether the filter takes some sub-frames away.
  bool has_lobes() const {
    return std::any_of(weights.begin(), weights.end(), [](float weight) { return weight < 0; });
  }
  bool scene_linear() const { return film_type == SampleType::kFloat16 || film_type == SampleType::kFloat32; }
};

// Place i of a fixed sequence that fills [-0.5, 0.5)^2 evenly however far it goes; place 0 is the middle.
glm::vec2 r2_offset(int i);

// The parts of a plan that its size and its samples decide.
void set_picture(FramePlan& plan, Extent picture, Extent largest_tile);
void set_samples(FramePlan& plan, int count, const PixelFilter& filter);

// The same picture, at most so many px a side, in tiles no larger than the plan's.
FramePlan scaled_plan(FramePlan plan, int max_side_px);

// Pixels are drawn in tiles of at most `max_tile_px` a side, so that memory does not grow with the picture. `auto_ev` is what a
// meter said (stops), for a camera with automatic exposure.
FramePlan plan_frame(const RenderSpec& spec, int max_tile_px, double auto_ev = 0);

}  // namespace furnace
