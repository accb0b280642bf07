#include "renderer/ibl/baked_environment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace furnace {

std::vector<double> ggx_level_roughness() {
  return {0,    0.05,  0.068, 0.092, 0.125, 0.148, 0.175, 0.206, 0.241, 0.28,
          0.32, 0.365, 0.415, 0.47,  0.535, 0.605, 0.69,  0.79,  0.89,  1};
}

std::vector<double> charlie_level_roughness() {
  return {0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1};
}

std::size_t BakedEnvironment::byte_size() const {
  std::size_t bytes = sizeof(*this) + irradiance.byte_size() + (radiance ? radiance->byte_size() : 0);
  for (const BakedLevel& level : charlie) bytes += sizeof(level) + level.equirect.byte_size();
  for (const BakedLevel& level : levels) bytes += sizeof(level) + level.equirect.byte_size();
  return bytes;
}

double horizontal_illuminance_lux(const BakedEnvironment& baked) {
  const std::array<float, 3> up = sample_equirect(baked.irradiance, 0, 1, 0);
  return std::numbers::pi * (0.2126 * double(up[0]) + 0.7152 * double(up[1]) + 0.0722 * double(up[2]));
}

std::array<float, 3> sample_equirect(const Image& image, double x, double y, double z) {
  const int width = image.extent.width, height = image.extent.height;
  const double theta = std::atan2(std::hypot(x, z), y);
  const double phi = std::atan2(z, x);
  const double column = (phi / (2 * std::numbers::pi) + 0.5) * width - 0.5;
  const double row = theta / std::numbers::pi * height - 0.5;
  const double column0 = std::floor(column), row0 = std::floor(row);
  const std::span<const float> samples = image.samples<float>();

  const auto texel = [&](int i, int j) {
    if (j < 0 || j >= height) {  // over the pole
      j = j < 0 ? -1 - j : 2 * height - 1 - j;
      i += width / 2;
    }
    i = ((i % width) + width) % width;
    return samples.data() + (std::size_t(j) * width + i) * 3;
  };
  const int i = static_cast<int>(column0), j = static_cast<int>(row0);
  const double s = column - column0, t = row - row0;
  const float *a = texel(i, j), *b = texel(i + 1, j), *c = texel(i, j + 1), *d = texel(i + 1, j + 1);
  std::array<float, 3> result;
  for (int k = 0; k < 3; ++k) {
    const double top = a[k] + s * (double{b[k]} - a[k]);
    const double bottom = c[k] + s * (double{d[k]} - c[k]);
    result[k] = static_cast<float>(top + t * (bottom - top));
  }
  return result;
}

}  // namespace furnace
