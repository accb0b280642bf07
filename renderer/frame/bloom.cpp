#include "renderer/frame/bloom.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/base/check.hpp"

namespace furnace {
namespace {

constexpr int kHeightPx = 256;
// Of as much the width is a multiple, so that the picture can be halved five times; and at most four times the height.
constexpr int kWidthStepPx = 32, kLargestWidthPx = 4 * kHeightPx;
constexpr int kMostSamples = 16;
constexpr std::size_t kChannels = 4;
constexpr int kGaussians = 5;

// RGBA, `scale` pixels of the full small picture to a texel.
struct Plane {
  std::size_t width = 0, height = 0;
  int scale = 1;
  std::vector<float> values;

  std::size_t stride() const { return width * kChannels; }
};

// Reflected at the borders, as if nothing flowed through them: an even picture stays even, and its sum stays.
std::size_t reflected(std::ptrdiff_t i, std::size_t count) {
  const auto period = std::ptrdiff_t(2 * count);
  const std::ptrdiff_t within = ((i % period) + period) % period;
  return std::size_t(within < std::ptrdiff_t(count) ? within : period - 1 - within);
}

// From the middle to three standard deviations, with all of both sides 1.
std::vector<float> gaussian_weights(double sigma) {
  const int reach = int(std::ceil(3 * sigma));
  std::vector<double> weights;
  double sum = 0;
  for (int i = 0; i <= reach; ++i) {
    weights.push_back(sigma > 0 ? std::exp(-0.5 * (i / sigma) * (i / sigma)) : 1);
    sum += (i == 0 ? 1 : 2) * weights.back();
  }
  std::vector<float> scaled;
  for (const double weight : weights) scaled.push_back(float(weight / sum));
  return scaled;
}

void add_scaled(const float* from, float factor, std::size_t count, float* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

void blur_rows(Plane& plane, const std::vector<float>& weights) {
  const auto reach = std::ptrdiff_t(weights.size()) - 1;
  std::vector<float> padded((plane.width + 2 * std::size_t(reach)) * kChannels);
  for (std::size_t y = 0; y < plane.height; ++y) {
    float* row = &plane.values[y * plane.stride()];
    for (std::ptrdiff_t x = -reach; x < std::ptrdiff_t(plane.width) + reach; ++x)
      std::copy_n(row + reflected(x, plane.width) * kChannels, kChannels,
                  &padded[std::size_t(x + reach) * kChannels]);
    std::fill_n(row, plane.stride(), 0.f);
    for (std::ptrdiff_t i = -reach; i <= reach; ++i)
      add_scaled(&padded[std::size_t(i + reach) * kChannels], weights[std::size_t(std::abs(i))],
                 plane.stride(), row);
  }
}

void blur_columns(Plane& plane, const std::vector<float>& weights) {
  const auto reach = std::ptrdiff_t(weights.size()) - 1;
  std::vector<float> blurred(plane.values.size());
  for (std::size_t y = 0; y < plane.height; ++y) {
    for (std::ptrdiff_t i = -reach; i <= reach; ++i)
      add_scaled(&plane.values[reflected(std::ptrdiff_t(y) + i, plane.height) * plane.stride()],
                 weights[std::size_t(std::abs(i))], plane.stride(), &blurred[y * plane.stride()]);
  }
  plane.values = std::move(blurred);
}

Plane halved(const Plane& plane) {
  Plane half{plane.width / 2, plane.height / 2, 2 * plane.scale, {}};
  half.values.resize(half.stride() * half.height);
  for (std::size_t y = 0; y < plane.height; ++y) {
    for (std::size_t x = 0; x < plane.width; ++x)
      add_scaled(&plane.values[y * plane.stride() + x * kChannels], 0.25f, kChannels,
                 &half.values[y / 2 * half.stride() + x / 2 * kChannels]);
  }
  return half;
}

// Chaikin 1974, "An Algorithm for High-Speed Curve Generation": weights 3/4 and 1/4, again and again, are the quadratic
// B-spline, which has no edges.
Plane doubled(const Plane& plane) {
  Plane twice{plane.width * 2, plane.height * 2, plane.scale / 2, {}};
  twice.values.resize(twice.stride() * twice.height);
  for (std::size_t y = 0; y < twice.height; ++y) {
    for (std::size_t x = 0; x < twice.width; ++x) {
      const std::array<std::size_t, 2> columns{
          x / 2, reflected(std::ptrdiff_t(x / 2) + (x % 2 == 0 ? -1 : 1), plane.width)};
      const std::array<std::size_t, 2> rows{
          y / 2, reflected(std::ptrdiff_t(y / 2) + (y % 2 == 0 ? -1 : 1), plane.height)};
      for (std::size_t corner = 0; corner < 4; ++corner)
        add_scaled(&plane.values[rows[corner / 2] * plane.stride() + columns[corner % 2] * kChannels],
                   (corner / 2 == 0 ? 0.75f : 0.25f) * (corner % 2 == 0 ? 0.75f : 0.25f), kChannels,
                   &twice.values[y * twice.stride() + x * kChannels]);
    }
  }
  return twice;
}

// The same picture ever wider blurred, ever smaller: standard deviations of `widest_px` (along x and y) / 16, / 8 ... / 1.
std::vector<Plane> gaussian_pyramid(Plane plane, glm::dvec2 widest_px) {
  constexpr double kSmoothPx =
      4;  // so wide a Gaussian has nothing left that half as many texels could not hold
  std::vector<Plane> levels;
  glm::dvec2 variance(0);  // of what was done already, px^2
  for (int i = 0; i < kGaussians; ++i) {
    const glm::dvec2 sigma = widest_px * std::exp2(i + 1 - kGaussians);
    const glm::dvec2 more = glm::sqrt(glm::max(sigma * sigma - variance, 0.0)) / double(plane.scale);
    blur_rows(plane, gaussian_weights(more.x));
    blur_columns(plane, gaussian_weights(more.y));
    levels.push_back(plane);
    variance = sigma * sigma;
    if (std::min(sigma.x, sigma.y) < kSmoothPx * plane.scale || i + 1 == kGaussians) continue;
    variance += 0.25 * plane.scale * plane.scale;  // of the mean of two texels
    plane = halved(plane);
  }
  return levels;
}

}  // namespace

FramePlan plan_glow(const FramePlan& plan, int max_tile_px) {
  FURNACE_CHECK(plan.bloom.has_value(), "a glow of {} sub-frames", plan.jitter_px.size());
  FramePlan small = plan;
  const double steps = double(kHeightPx) * plan.picture.width / plan.picture.height / kWidthStepPx;
  const int width = std::clamp(int(std::ceil(steps)) * kWidthStepPx, kWidthStepPx, kLargestWidthPx);
  set_picture(small, {width, kHeightPx}, {max_tile_px, max_tile_px});
  set_samples(small, std::min(int(plan.jitter_px.size()), kMostSamples), {});
  small.film_type = SampleType::kFloat32;
  small.glow_only = true;
  small.layers = {};
  small.sky_shadows = false;
  return small;
}

// Spencer, Shirley, Zimmerman and Greenberg 1995, "Physically-Based Glare Effects for Digital Images": light that lens and eye
// scatter falls off about as the inverse square of the distance, which is the same energy for every octave of it.
Image spread_glow(const Image& bright, const Bloom& bloom, Extent picture) {
  FURNACE_CHECK(bright.type == SampleType::kFloat32 && bright.channels == int(kChannels),
                "a glow of {} channels", bright.channels);
  const auto source = bright.samples<float>();
  const Extent size = bright.extent;
  const double widest = bloom.radius / 2;  // of the picture's height
  const glm::dvec2 widest_px(widest * picture.height / picture.width * size.width, widest * size.height);
  Plane plane{std::size_t(size.width), std::size_t(size.height), 1, {source.begin(), source.end()}};
  const std::vector<Plane> levels = gaussian_pyramid(std::move(plane), widest_px);
  Plane sum = levels.back();
  for (int i = kGaussians - 2; i >= 0; --i) {
    const Plane& level = levels[std::size_t(i)];
    if (sum.scale != level.scale) sum = doubled(sum);
    add_scaled(level.values.data(), 1, level.values.size(), sum.values.data());
  }
  Image glow = make_image(size, int(kChannels), SampleType::kFloat32, ColorSpace::kLinear);
  std::transform(sum.values.begin(), sum.values.end(), glow.samples<float>().begin(),
                 [](float value) { return value / kGaussians; });
  return glow;
}

}  // namespace furnace
