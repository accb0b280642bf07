// Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images": how different two pictures look to who flips
// between them, 0 to 1 a pixel. For pictures in [0, 1], of a monitor 0.7 m away that is 0.7 m and 3840 pixels wide.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/image/image.hpp"

namespace furnace::reference {

// Linear Rec.709 in [0, 1], row by row.
struct Picture {
  Extent extent;
  std::vector<glm::dvec3> pixels;

  // Beyond the border its nearest pixel.
  const glm::dvec3& at(int x, int y) const {
    const int i = std::clamp(x, 0, extent.width - 1), j = std::clamp(y, 0, extent.height - 1);
    return pixels[std::size_t(j) * std::size_t(extent.width) + std::size_t(i)];
  }
};

namespace flip {

const double kPixelsPerDegree = 0.7 * 3840 / 0.7 * std::numbers::pi / 180;

// IEC 61966-2-1:1999; rows of XYZ from linear RGB. The white of every space here is that of (1, 1, 1).
inline glm::dmat3 xyz_from_rgb() {
  return glm::transpose(glm::dmat3(0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750,
                                   0.0193339, 0.1191920, 0.9503041));
}

inline glm::dvec3 relative_xyz(const glm::dvec3& rgb) {
  const glm::dvec3 white = xyz_from_rgb() * glm::dvec3(1);
  return xyz_from_rgb() * rgb / white;
}

inline glm::dvec3 ycxcz(const glm::dvec3& rgb) {
  const glm::dvec3 t = relative_xyz(rgb);
  return {116 * t.y - 16, 500 * (t.x - t.y), 200 * (t.y - t.z)};
}

inline glm::dvec3 rgb_from_ycxcz(const glm::dvec3& c) {
  const double y = (c.x + 16) / 116;
  const glm::dvec3 white = xyz_from_rgb() * glm::dvec3(1);
  return glm::inverse(xyz_from_rgb()) * (glm::dvec3(y + c.y / 500, y, y - c.z / 200) * white);
}

// CIELAB with the Hunt effect: dark colours differ less.
inline glm::dvec3 hunt_lab(const glm::dvec3& rgb) {
  const auto f = [](double t) {
    constexpr double kDelta = 6.0 / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const glm::dvec3 t = relative_xyz(rgb);
  const double lightness = 116 * f(t.y) - 16;
  return {lightness, 0.01 * lightness * 500 * (f(t.x) - f(t.y)), 0.01 * lightness * 200 * (f(t.y) - f(t.z))};
}

inline double hyab(const glm::dvec3& a, const glm::dvec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

// Sum over a square of `weight(dx, dy)` times the picture.
inline Picture filtered(const Picture& picture, int radius,
                        const std::function<glm::dvec3(int, int)>& weight) {
  const int side = 2 * radius + 1;
  std::vector<glm::dvec3> weights;
  for (int k = 0; k < side * side; ++k) weights.push_back(weight(k % side - radius, k / side - radius));
  Picture out{picture.extent, {}};
  for (int y = 0; y < picture.extent.height; ++y) {
    for (int x = 0; x < picture.extent.width; ++x) {
      glm::dvec3 sum(0);
      for (int k = 0; k < side * side; ++k)
        sum += weights[std::size_t(k)] * picture.at(x + k % side - radius, y + k / side - radius);
      out.pixels.push_back(sum);
    }
  }
  return out;
}

// Section 4.1.1: what the eye resolves of each channel, table 1.
inline Picture as_seen(const Picture& rgb) {
  Picture opponent{rgb.extent, {}};
  for (const glm::dvec3& pixel : rgb.pixels) opponent.pixels.push_back(ycxcz(pixel));
  constexpr double kA[3][2] = {{1, 0}, {1, 0}, {34.1, 13.5}};
  constexpr double kB[3][2] = {{0.0047, 1e-5}, {0.0053, 1e-5}, {0.04, 0.025}};
  const double pi2 = std::numbers::pi * std::numbers::pi;
  const int radius = int(std::ceil(3 * std::sqrt(kB[2][0] / (2 * pi2)) * kPixelsPerDegree));
  const auto unscaled = [&](int x, int y) {
    const double degrees2 = (x * x + y * y) / (kPixelsPerDegree * kPixelsPerDegree);
    glm::dvec3 weight(0);
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 2; ++k)
        weight[c] += kA[c][k] * std::sqrt(std::numbers::pi / kB[c][k]) * std::exp(-pi2 * degrees2 / kB[c][k]);
    }
    return weight;
  };
  glm::dvec3 sum(0);
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) sum += unscaled(x, y);
  }
  Picture seen = filtered(opponent, radius, [&](int x, int y) { return unscaled(x, y) / sum; });
  for (glm::dvec3& pixel : seen.pixels) pixel = hunt_lab(glm::clamp(rgb_from_ycxcz(pixel), 0.0, 1.0));
  return seen;
}

// Section 4.1.3: small differences keep their order, large ones are pressed into the last twentieth.
inline double color_difference(const glm::dvec3& a, const glm::dvec3& b) {
  constexpr double kQ = 0.7, kP = 0.4, kT = 0.95;
  static const double largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kQ);
  const double difference = std::pow(hyab(a, b), kQ);
  if (difference < kP * largest) return kT / (kP * largest) * difference;
  return kT + (difference - kP * largest) / (largest - kP * largest) * (1 - kT);
}

// Section 4.2: strength of edges (x) and of points (y) in the lightness.
inline std::vector<glm::dvec2> features(const Picture& rgb) {
  Picture lightness{rgb.extent, {}};
  for (const glm::dvec3& pixel : rgb.pixels) lightness.pixels.emplace_back((ycxcz(pixel).x + 16) / 116);
  constexpr double kWidthDegrees = 0.082;
  const double sigma = 0.5 * kWidthDegrees * kPixelsPerDegree;
  const int radius = int(std::ceil(3 * sigma));
  const auto gauss = [&](double x, double y) { return std::exp(-(x * x + y * y) / (2 * sigma * sigma)); };
  const auto edge = [&](double x, double y) { return -x * gauss(x, y); };
  const auto point = [&](double x, double y) { return (x * x / (sigma * sigma) - 1) * gauss(x, y); };
  // Positive weights sum to 1, negative ones to -1.
  const auto scales = [&](const auto& kernel) {
    std::array<double, 2> sums{};
    for (int y = -radius; y <= radius; ++y) {
      for (int x = -radius; x <= radius; ++x) sums[kernel(x, y) > 0] += std::abs(kernel(x, y));
    }
    return [kernel, sums](double x, double y) { return kernel(x, y) / sums[kernel(x, y) > 0]; };
  };
  const auto scaled_edge = scales(edge);
  const auto scaled_point = scales(point);
  const Picture along_x = filtered(
      lightness, radius, [&](int x, int y) { return glm::dvec3(scaled_edge(x, y), scaled_point(x, y), 0); });
  const Picture along_y = filtered(
      lightness, radius, [&](int x, int y) { return glm::dvec3(scaled_edge(y, x), scaled_point(y, x), 0); });
  std::vector<glm::dvec2> found;
  for (std::size_t i = 0; i < rgb.pixels.size(); ++i) {
    const glm::dvec3 &x = along_x.pixels[i], &y = along_y.pixels[i];
    found.emplace_back(std::hypot(x.x, y.x), std::hypot(x.y, y.y));
  }
  return found;
}

}  // namespace flip

// The mean over all pixels; the pictures are of one size.
inline double flip_mean(const Picture& reference, const Picture& test) {
  const Picture seen_reference = flip::as_seen(reference), seen_test = flip::as_seen(test);
  const std::vector<glm::dvec2> features_reference = flip::features(reference),
                                features_test = flip::features(test);
  double sum = 0;
  for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
    const double color = flip::color_difference(seen_reference.pixels[i], seen_test.pixels[i]);
    const glm::dvec2 change = glm::abs(features_reference[i] - features_test[i]);
    const double feature = std::sqrt(std::max(change.x, change.y) / std::numbers::sqrt2);
    sum += std::pow(color, 1 - feature);
  }
  return sum / double(reference.pixels.size());
}

}  // namespace furnace::reference
