#include "renderer/frame/exposure.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/base/check.hpp"
#include "renderer/image/color.hpp"

namespace furnace {

// Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 5.1: saturation-based sensitivity
// (ISO 12232) of a lens that passes 0.65 of the light puts 1.2 * 2^EV100 cd/m2 at white.
double exposure_ev_of_ev100(double ev100) {
  return -(ev100 + std::log2(1.2));
}

FramePlan plan_meter(const RenderSpec& spec, int max_tile_px) {
  constexpr int kSidePx = 256;
  FramePlan plan = scaled_plan(plan_frame(spec, max_tile_px), kSidePx);
  set_samples(plan, 1, {});
  plan.film_type = SampleType::kFloat32;
  plan.exposure_ev = 0;
  plan.exposure = 1;
  plan.grade.reset();
  plan.bloom.reset();
  plan.layers = {};
  plan.sky_shadows = false;
  if (!std::holds_alternative<EnvironmentBackground>(spec.environment.background)) {
    plan.background_top = plan.background_bottom = glm::vec4(0);
    plan.opaque = false;
  }
  return plan;
}

// Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images", eq. 1 and 2.
double metered_ev(const Image& picture) {
  FURNACE_CHECK(picture.type == SampleType::kFloat32 && picture.channels == 4,
                "a metered picture of {} channels", picture.channels);
  constexpr double kKey = 0.18;
  // Of what is seen in cd/m2: the threshold of the dark-adapted eye, and the sun. What is darker tells nothing.
  constexpr double kDarkest = 1e-6, kBrightest = 1.6e9;
  const auto samples = picture.samples<float>();
  double sum = 0, weight = 0;
  for (std::size_t i = 0; i < samples.size(); i += 4) {
    const double alpha = samples[i + 3];
    const double luminance = luminance_rec709(samples[i], samples[i + 1], samples[i + 2]);
    if (!(alpha > 0) || !(luminance >= kDarkest * alpha)) continue;
    sum += alpha * std::log2(std::min(luminance / alpha, kBrightest));
    weight += alpha;
  }
  if (weight == 0) return 0;
  return std::round(100 * (std::log2(kKey) - sum / weight)) / 100;
}

}  // namespace furnace
