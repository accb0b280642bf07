// Sums over the sphere of an equirect, by definitions of their own.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/image/image.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {

inline glm::dvec3 direction(const Image& image, double row, double column) {
  const double theta = kPi * (row + 0.5) / image.extent.height;
  const double phi = 2 * kPi * ((column + 0.5) / image.extent.width - 0.5);
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

// Sums visit(direction) * radiance * solid angle over all texels.
template <class Weight>
glm::dvec3 integrate(const Image& image, Weight&& weight) {
  std::vector<glm::dvec2> around;
  for (int column = 0; column < image.extent.width; ++column) {
    const double phi = 2 * kPi * ((column + 0.5) / image.extent.width - 0.5);
    around.emplace_back(std::cos(phi), std::sin(phi));
  }
  glm::dvec3 sum(0);
  const float* rgb = image.samples<float>().data();
  for (int row = 0; row < image.extent.height; ++row) {
    const double texel_sr =
        2 * kPi / image.extent.width *
        (std::cos(kPi * row / image.extent.height) - std::cos(kPi * (row + 1) / image.extent.height));
    const double theta = kPi * (row + 0.5) / image.extent.height;
    for (int column = 0; column < image.extent.width; ++column, rgb += 3) {
      const glm::dvec2 level = std::sin(theta) * around[column];
      sum += texel_sr * weight(glm::dvec3(level.x, std::cos(theta), level.y)) *
             glm::dvec3(rgb[0], rgb[1], rgb[2]);
    }
  }
  return sum;
}

// What a white Lambert surface with this normal shows.
inline glm::dvec3 irradiance_over_pi(const Image& image, const glm::dvec3& normal) {
  return integrate(image, [&](const glm::dvec3& d) { return std::max(0.0, glm::dot(d, normal)) / kPi; });
}

}  // namespace furnace
