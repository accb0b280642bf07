#include "renderer/frame/layer_view.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/image/color.hpp"

namespace furnace {
namespace {

bool is_place(FilmLayer layer) {
  return row_of(layer).kind == FilmLayerKind::kPlace;
}

// Colours that lie far apart for numbers that follow one another: the golden section of the hues.
glm::vec3 color_of_number(float number) {
  if (number == 0) return glm::vec3(0);
  const double hue = std::fmod(double(number) * 0.61803398874989, 1.0);
  const double value = std::fmod(double(number) * 0.75487766624669, 1.0) * 0.4 + 0.6;
  glm::vec3 color;
  for (int c = 0; c < 3; ++c) {
    const double wave = std::abs(std::fmod(hue * 6 + 6 - 2 * c, 6.0) - 3) - 1;
    color[c] = float(value * (0.3 + 0.7 * std::clamp(wave, 0.0, 1.0)));
  }
  return color;
}

glm::vec3 fraction(const glm::vec3& v) {
  return v - glm::floor(v);
}

// What is shown of straight numbers, [0, 1], as it is stored.
glm::vec3 seen(FilmLayer layer, const glm::vec3& v, const DepthRange& depth, const Bounds& scene) {
  switch (layer) {
    case FilmLayer::kDepth: {
      const double range_m = std::max(depth.far_m - depth.near_m, 1e-9);
      return glm::vec3(float(std::clamp((depth.far_m - double(v.x)) / range_m, 0.0, 1.0)));
    }
    case FilmLayer::kPosition:
      return glm::clamp((v - scene.min) / glm::max(scene.max - scene.min, glm::vec3(1e-9f)), 0.f, 1.f);
    case FilmLayer::kUv:
      return fraction(v);
    case FilmLayer::kObjectId:
    case FilmLayer::kMaterialId:
    case FilmLayer::kPrimitiveId:
      return color_of_number(v.x);
    case FilmLayer::kMotion: {
      constexpr float kRangePx = 64;
      return glm::clamp(v / kRangePx + 0.5f, 0.f, 1.f);
    }
    case FilmLayer::kNormal:
    case FilmLayer::kViewNormal:
      return v * 0.5f + 0.5f;
    case FilmLayer::kAlbedo: {
      glm::vec3 color;
      for (int c = 0; c < 3; ++c) color[c] = float(srgb_from_linear(std::clamp(double(v[c]), 0.0, 1.0)));
      return color;
    }
    case FilmLayer::kFresnel:
      return v;
    case FilmLayer::kDistribution:
      return glm::vec3(v.x / (1 + v.x));
    case FilmLayer::kWireframe: {
      constexpr float kGround = 0.2f;
      return glm::vec3(kGround + (1 - kGround) * v.x);
    }
    default:
      return glm::vec3(v.x);
  }
}

void put_unorm(Image& image, std::size_t at, float value) {
  const float unit = std::clamp(value, 0.f, 1.f);
  if (image.type == SampleType::kUint16)
    image.samples<std::uint16_t>()[at] = std::uint16_t(std::lround(unit * 65535));
  else
    image.samples<std::uint8_t>()[at] = std::uint8_t(std::lround(unit * 255));
}

Image linear_numbers(const Image& numbers, FilmLayer layer, const FramePlan& plan) {
  const bool exact = is_place(layer);
  const int colors = row_of(layer).channels.size() == 1 ? 1 : 3;
  const SampleType type = exact ? SampleType::kFloat32 : plan.film_type;
  Image image = make_image(numbers.extent, colors + (plan.opaque ? 0 : 1), type, ColorSpace::kLinear);
  const auto from = numbers.samples<float>();
  for (std::size_t pixel = 0; pixel < std::size_t(numbers.extent.area()); ++pixel) {
    for (int c = 0; c < image.channels; ++c) {
      const float value = from[4 * pixel + std::size_t(c < colors ? c : 3)];
      const std::size_t at = pixel * std::size_t(image.channels) + std::size_t(c);
      if (type == SampleType::kFloat16)
        image.samples<std::uint16_t>()[at] = half_from_float(value);
      else
        image.samples<float>()[at] = value;
    }
  }
  return image;
}

}  // namespace

DepthRange depth_range(const View& view, const Bounds& scene) {
  if (scene.empty()) return {};
  const glm::dvec3 backwards(glm::transpose(glm::mat3(view.view_from_world))[2]);
  DepthRange range{1e30, 0};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at(corner & 1 ? scene.max.x : scene.min.x, corner & 2 ? scene.max.y : scene.min.y,
                        corner & 4 ? scene.max.z : scene.min.z);
    const double depth_m = std::max(glm::dot(glm::dvec3(view.eye) - at, backwards), 0.0);
    range = {std::min(range.near_m, depth_m), std::max(range.far_m, depth_m)};
  }
  return range;
}

Image view_of(const Image& numbers, const FramePlan& plan, const View& view, const Bounds& scene) {
  const FilmLayer layer = *plan.layers.shown;
  if (plan.scene_linear()) return linear_numbers(numbers, layer, plan);
  const DepthRange depth = depth_range(view, scene);
  const int channels = plan.opaque ? 3 : 4;
  Image image = make_image(numbers.extent, channels, plan.film_type, ColorSpace::kSrgb);
  const auto from = numbers.samples<float>();
  for (std::size_t pixel = 0; pixel < std::size_t(numbers.extent.area()); ++pixel) {
    const float* drawn = &from[4 * pixel];
    const float alpha = std::clamp(drawn[3], 0.f, 1.f);
    glm::vec3 color(0);
    if (alpha > 0) {
      const glm::vec3 straight = glm::vec3(drawn[0], drawn[1], drawn[2]) / (is_place(layer) ? 1.f : drawn[3]);
      color = seen(layer, straight, depth, scene) * (plan.opaque ? alpha : 1.f);
    }
    for (int c = 0; c < channels; ++c)
      put_unorm(image, pixel * std::size_t(channels) + std::size_t(c), c < 3 ? color[c] : alpha);
  }
  return image;
}

}  // namespace furnace
