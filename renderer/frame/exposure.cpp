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

FramePlan plan_meter(RenderSpec spec, int max_tile_px) {
  constexpr int kSidePx = 256;
  OutputSpec& output = spec.output;
  const double scale = std::min(1.0, double(kSidePx) / std::max(output.width, output.height));
  output.width = std::max(1, int(std::lround(output.width * scale)));
  output.height = std::max(1, int(std::lround(output.height * scale)));
  output.samples = 1;
  output.format = OutputFormat::kExr;
  output.exr_type = SampleType::kFloat32;
  output.grade = {};
  spec.environment.visibility = EnvironmentVisibility::kOff;
  spec.camera.metering = UnmeteredExposure{};
  spec.camera.exposure_ev = 0;
  if (!std::holds_alternative<EnvironmentBackground>(spec.environment.background))
    spec.environment.background = TransparentBackground{};
  return plan_frame(spec, max_tile_px);
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
