#include "renderer/scene/gradient.hpp"

#include <algorithm>

namespace furnace {

std::vector<GradientStop> default_gradient() {
  return {{-90, {0.28, 0.27, 0.26}}, {-1, glm::dvec3(0.42)}, {1, glm::dvec3(1.20)}, {90, {0.62, 0.85, 1.25}}};
}

double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

glm::dvec3 gradient_radiance(const GradientEnvironment& gradient, double elevation_deg) {
  const std::vector<GradientStop>& stops = gradient.stops;
  std::size_t i = 1;
  while (i + 1 < stops.size() && elevation_deg > stops[i].elevation_deg) ++i;
  const GradientStop &below = stops[i - 1], &above = stops[i];
  const double from = below.elevation_deg, to = above.elevation_deg;
  if (from == to) return (elevation_deg < from ? below : above).radiance;
  const double t = gradient.blend == GradientBlend::kSmooth
                       ? smoothstep(from, to, elevation_deg)
                       : std::clamp((elevation_deg - from) / (to - from), 0.0, 1.0);
  return below.radiance + t * (above.radiance - below.radiance);
}

}  // namespace furnace
