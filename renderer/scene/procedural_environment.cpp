#include "renderer/scene/procedural_environment.hpp"

#include "renderer/scene/equirect_painter.hpp"
#include "renderer/scene/gradient.hpp"
#include "renderer/scene/procedural.hpp"
#include "renderer/scene/sky.hpp"
#include "renderer/scene/studio.hpp"

#include <algorithm>
#include <array>
#include <functional>

namespace furnace {
namespace {

// Enough for a constant: every level of a bake is constant too.
constexpr Extent kConstantExtent{64, 32};

Image make_furnace() {
  return constant_environment(glm::vec3(1));
}

Image make_overcast_sky() {
  return paint_overcast(OvercastEnvironment{});
}

Image paint_gradient(const GradientEnvironment& gradient) {
  const EquirectGrid grid(kEquirectExtent);
  return paint_equirect(grid.extent, [&](int row, std::vector<glm::dvec3>& radiance) {
    std::fill(radiance.begin(), radiance.end(), gradient_radiance(gradient, grid.elevation_deg(row)));
  });
}

struct Painter {
  const Painting& painting;

  Image operator()(const GradientEnvironment& gradient) const { return paint_gradient(gradient); }
  Image operator()(const OvercastEnvironment& overcast) const { return paint_overcast(overcast); }
  Image operator()(const ClearSkyEnvironment& sky) const { return paint_clear_sky(sky, painting); }
  Image operator()(const StudioEnvironment& studio) const { return paint_studio(studio); }
};

struct Builtin {
  std::string_view name;
  Image (*make)();
};

constexpr std::array kBuiltins = {
    Builtin{"studio", make_studio},
    Builtin{"overcast", make_overcast_sky},
    Builtin{"clear-sky", make_clear_sky},
    Builtin{"furnace", make_furnace},
};

}  // namespace

EquirectGrid::EquirectGrid(Extent size) : extent(size) {
  for (int row = 0; row < size.height; ++row) {
    const double theta = kPi * (row + 0.5) / size.height;
    sin_theta.push_back(std::sin(theta));
    cos_theta.push_back(std::cos(theta));
  }
  for (int column = 0; column < size.width; ++column) {
    const double phi = 2 * kPi * ((column + 0.5) / size.width - 0.5);
    cos_phi.push_back(std::cos(phi));
    sin_phi.push_back(std::sin(phi));
  }
}

double EquirectGrid::texel_sr(int row) const {
  const double top = kPi * row / extent.height, bottom = kPi * (row + 1) / extent.height;
  return 2 * kPi / extent.width * (std::cos(top) - std::cos(bottom));
}

void paint_rows(const Painting& painting, int rows, const std::function<void(int row)>& paint) {
  constexpr double kRowCost_us = 200;
  const auto paint_one = [&](std::size_t row) {
    check_deadline(painting.deadline, "environment: painting");
    paint(static_cast<int>(row));
  };
  if (painting.pool != nullptr) return painting.pool->parallel_for(std::size_t(rows), kRowCost_us, paint_one);
  for (int row = 0; row < rows; ++row) paint_one(std::size_t(row));
}

Image paint_environment(const ProceduralEnvironment& environment, const Painting& painting) {
  return std::visit(Painter{painting}, environment);
}

std::optional<Image> builtin_environment(std::string_view name) {
  const auto builtin =
      std::find_if(kBuiltins.begin(), kBuiltins.end(), [&](const Builtin& b) { return b.name == name; });
  if (builtin == kBuiltins.end()) return std::nullopt;
  return builtin->make();
}

Image constant_environment(const glm::vec3& radiance) {
  Image image = make_image(kConstantExtent, 3, SampleType::kFloat32, ColorSpace::kLinear);
  const auto samples = image.samples<float>();
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = radiance[i % 3];
  return image;
}

std::vector<std::string_view> builtin_environment_names() {
  std::vector<std::string_view> names;
  for (const Builtin& builtin : kBuiltins) names.push_back(builtin.name);
  return names;
}

}  // namespace furnace
