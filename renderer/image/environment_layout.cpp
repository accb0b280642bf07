#include "renderer/image/environment_layout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "renderer/base/check.hpp"

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr float kLargest = std::numeric_limits<float>::max();

struct LayoutRow {
  std::string_view name;
  int width, height;  // of the picture, in its own unit: faces, but for an equirect
};

constexpr std::array<LayoutRow, 6> kLayouts = {{{"auto", 0, 0},
                                                {"equirect", 2, 1},
                                                {"horizontal-cross", 4, 3},
                                                {"vertical-cross", 3, 4},
                                                {"horizontal-strip", 6, 1},
                                                {"vertical-strip", 1, 6}}};

const LayoutRow& row_of(EnvironmentLayout layout) {
  return kLayouts[std::size_t(layout)];
}

enum Face { kPlusX, kMinusX, kPlusY, kMinusY, kPlusZ, kMinusZ };

// Where the faces lie, in faces: column, row. By Face.
using Places = std::array<std::array<int, 2>, 6>;
constexpr Places kHorizontalCross = {{{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}}};
constexpr Places kVerticalCross = {{{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3}}};

const Places* places_of(EnvironmentLayout layout) {
  if (layout == EnvironmentLayout::kHorizontalCross) return &kHorizontalCross;
  return layout == EnvironmentLayout::kVerticalCross ? &kVerticalCross : nullptr;
}

class Cube {
 public:
  Cube(const Image& picture, EnvironmentLayout layout)
      : side_(face_side(picture.extent, layout)),
        layout_(layout),
        width_(picture.extent.width),
        texels_(picture.samples<float>().data()) {}

  int side() const { return side_; }

  // RGB of a face's texel.
  const float* at(Face face, int i, int j) const {
    const bool is_upside_down = layout_ == EnvironmentLayout::kVerticalCross && face == kMinusZ;
    if (is_upside_down) i = side_ - 1 - i, j = side_ - 1 - j;
    const auto [column, row] = place(face);
    return texels_ + 3 * (std::size_t(row * side_ + j) * width_ + std::size_t(column * side_ + i));
  }

 private:
  std::array<int, 2> place(Face face) const {
    if (const Places* places = places_of(layout_)) return (*places)[face];
    return layout_ == EnvironmentLayout::kHorizontalStrip ? std::array<int, 2>{face, 0}
                                                          : std::array<int, 2>{0, face};
  }

  int side_ = 0;
  EnvironmentLayout layout_;
  int width_ = 0;  // of the picture
  const float* texels_;
};

// Half of a face's texels along one axis, from its middle outwards; of an odd number the first is a half.
struct HalfFace {
  int side = 0;

  int count() const { return (side + 1) / 2; }
  // On the cube of half side 1.
  double begin(int k) const { return std::max(0.0, (2.0 * k - side % 2) / side); }
  double end(int k) const { return (2.0 * k + 2 - side % 2) / side; }
  // Index of the texel on the positive or negative side.
  int index(int k, bool positive) const {
    const int above = side / 2 + k;
    return positive ? above : side - 1 - above;
  }
};

// A part of the azimuth within one column: Gauss-Legendre's three nodes (Abramowitz and Stegun 1964, table 25.4).
template <class Use>
void for_nodes(double begin, double end, Use&& use) {
  constexpr double kNode = 0.7745966692414834, kOuter = 5.0 / 18, kInner = 8.0 / 18;
  const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin), length = end - begin;
  use(middle - half * kNode, length * kOuter);
  use(middle, length * kInner);
  use(middle + half * kNode, length * kOuter);
}

// In azimuth and the sine of elevation areas are solid angles, and along a meridian the faces' texels and the map's are
// intervals of that sine: what is shared is exact there, and smooth in the azimuth between the corners of both.
class Resampling {
 public:
  Resampling(const Cube& cube, Image& equirect)
      : cube_(cube),
        half_{cube.side()},
        n_(cube.side()),
        equirect_(equirect),
        coverage_(std::size_t(n_) * n_) {
    for (int row = 0; row <= n_; ++row) sines_.push_back(std::sin(0.5 * kPi * row / n_));
  }

  void run() {
    for (int i = 0; i < half_.count(); ++i) add_side_column(i);
    for (int j = 0; j < half_.count(); ++j)
      for (int i = 0; i < half_.count(); ++i) add_cap_texel(i, j);
    divide_by_coverage();
  }

 private:
  double column_width() const { return 0.5 * kPi / n_; }

  // Calls use(begin, end, column) for each column of the map that [begin, end] has a part of.
  template <class Use>
  void for_columns(double begin, double end, Use&& use) const {
    const int first = std::clamp(static_cast<int>(begin / column_width()), 0, n_ - 1);
    for (int column = first; column < n_ && column * column_width() < end; ++column) {
      const double from = std::max(begin, column * column_width());
      const double to = std::min(end, (column + 1) * column_width());
      if (to > from) use(from, to, column);
    }
  }

  // Calls use(row, share) for each row of the map, from the equator upwards, that a part of a meridian has a share in.
  template <class Use>
  void for_rows(double from_sine, double to_sine, Use&& use) const {
    int row = std::clamp(static_cast<int>(std::asin(std::min(from_sine, 1.0)) / column_width()), 0, n_ - 1);
    for (; row < n_ && sines_[row] < to_sine; ++row) {
      const double share = std::min(to_sine, sines_[row + 1]) - std::max(from_sine, sines_[row]);
      if (share > 0) use(row, share);
    }
  }

  // A column of an upright face, east of its middle and above the horizon, with all its images.
  void add_side_column(int i) {
    for_columns(std::atan(half_.begin(i)), std::atan(half_.end(i)),
                [&](double begin, double end, int column) {
                  for_nodes(begin, end, [&](double azimuth, double width) {
                    const auto sine_at = [cos = std::cos(azimuth)](double height) {
                      return height * cos / std::sqrt(1 + height * cos * height * cos);
                    };
                    for (int j = 0; j < half_.count(); ++j) {
                      for_rows(sine_at(half_.begin(j)), sine_at(half_.end(j)), [&](int row, double share) {
                        add_side(i, j, column, row, static_cast<float>(width * share));
                      });
                    }
                  });
                });
  }

  // East is where the azimuth grows; there a = -tan of it, on every upright face.
  void add_side(int i, int j, int column, int row, float weight) {
    constexpr Face kFaces[] = {kPlusX, kPlusZ, kMinusX, kMinusZ};  // by quarters of the azimuth
    for (int quarter = 0; quarter < 4; ++quarter) {
      for (const bool east : {false, true}) {
        const int to = quarter * n_ + (east ? column : -1 - column);
        for (const bool up : {false, true})
          add(cube_.at(kFaces[quarter], half_.index(i, !east), half_.index(j, !up)), to, row, up, weight);
      }
    }
    cover(column, row, weight);
    cover(n_ - 1 - column, row, weight);
  }

  // A texel of a quarter of the upper face, with all its images: |x| in i, |z| in j.
  void add_cap_texel(int i, int j) {
    const double x0 = half_.begin(i), x1 = half_.end(i), z0 = half_.begin(j), z1 = half_.end(j);
    const double first = std::atan2(z0, x1), last = x0 > 0 ? std::atan2(z1, x0) : 0.5 * kPi;
    // Between its corners one edge is near, one is far.
    std::array<double, 4> cuts = {first, std::atan2(z1, x1), x0 > 0 || z0 > 0 ? std::atan2(z0, x0) : first,
                                  last};
    std::sort(cuts.begin(), cuts.end());
    for (int cut = 0; cut < 3; ++cut) {
      for_columns(cuts[cut], cuts[cut + 1], [&](double begin, double end, int column) {
        for_nodes(begin, end, [&](double azimuth, double width) {
          const double cos = std::cos(azimuth), sin = std::sin(azimuth);
          const double near = std::max(x0 / cos, z0 / sin), far = std::min(x1 / cos, z1 / sin);
          for_rows(1 / std::sqrt(1 + far * far), 1 / std::sqrt(1 + near * near), [&](int row, double share) {
            add_cap(i, j, column, row, static_cast<float>(width * share));
          });
        });
      });
    }
  }

  void add_cap(int i, int j, int column, int row, float weight) {
    const int columns[2][2] = {{2 * n_ + column, -1 - column}, {2 * n_ - 1 - column, column}};
    for (const bool plus_z : {false, true}) {
      for (const bool plus_x : {false, true}) {
        const int to = columns[plus_z][plus_x];
        add(cube_.at(kPlusY, half_.index(i, plus_x), half_.index(j, plus_z)), to, row, true, weight);
        add(cube_.at(kMinusY, half_.index(i, plus_x), half_.index(j, !plus_z)), to, row, false, weight);
      }
    }
    cover(column, row, weight);
  }

  // `column` from where the map looks to +X, `row` from the horizon.
  void add(const float* texel, int column, int row, bool up, float weight) {
    const int width = equirect_.extent.width;
    const int i = (column + width / 2 + width) % width, j = up ? n_ - 1 - row : n_ + row;
    float* to = equirect_.samples<float>().data() + 3 * (std::size_t(j) * width + i);
    for (int c = 0; c < 3; ++c) to[c] += weight * texel[c];
  }

  // The same in every quarter, above and below.
  void cover(int column, int row, float weight) { coverage_[std::size_t(row) * n_ + column] += weight; }

  void divide_by_coverage() {
    float* texel = equirect_.samples<float>().data();
    for (int j = 0; j < 2 * n_; ++j) {
      const float* row = coverage_.data() + std::size_t(j < n_ ? n_ - 1 - j : j - n_) * n_;
      for (int i = 0; i < 4 * n_; ++i, texel += 3)
        // A mean of the largest floats must not round to infinity.
        for (int c = 0; c < 3; ++c) texel[c] = std::min(texel[c] / row[i % n_], kLargest);
    }
  }

  const Cube& cube_;
  const HalfFace half_;
  const int n_;  // rows of the map from horizon to pole, columns of a quarter
  Image& equirect_;
  std::vector<double> sines_;    // of the elevations between rows
  std::vector<float> coverage_;  // sr, of a quarter above the horizon: [row][column]
};

}  // namespace

std::string_view name_of(EnvironmentLayout layout) {
  return row_of(layout).name;
}

EnvironmentLayout layout_of(std::int64_t width, std::int64_t height, EnvironmentLayout asked) {
  const auto fits = [&](const LayoutRow& row) { return width * row.height == height * row.width; };
  for (std::size_t k = 1; k < kLayouts.size(); ++k) {
    const auto layout = EnvironmentLayout(k);
    if ((asked == EnvironmentLayout::kAuto || asked == layout) && fits(kLayouts[k])) return layout;
  }
  return EnvironmentLayout::kAuto;
}

int face_side(const Extent& picture, EnvironmentLayout layout) {
  return picture.width / row_of(layout).width;
}

void clear_beside_faces(Image& picture, EnvironmentLayout layout) {
  const Places* places = places_of(layout);
  if (!places) return;
  const int side = face_side(picture.extent, layout);
  const auto samples = picture.samples<float>();
  for (int y = 0; y < picture.extent.height; ++y) {
    for (int column = 0; column < row_of(layout).width; ++column) {
      if (std::ranges::find(*places, std::array{column, y / side}) != places->end()) continue;
      const std::size_t begin =
          std::size_t(y) * std::size_t(picture.extent.width) + std::size_t(column * side);
      std::ranges::fill(samples.subspan(3 * begin, 3 * std::size_t(side)), 0.0f);
    }
  }
}

Image equirect_of_cube(const Image& picture, EnvironmentLayout layout) {
  FURNACE_CHECK(layout_of(picture.extent.width, picture.extent.height, layout) == layout &&
                    layout > EnvironmentLayout::kEquirect,
                "a {} of {} x {} px", name_of(layout), picture.extent.width, picture.extent.height);
  const Cube cube(picture, layout);
  Image equirect =
      make_image({4 * cube.side(), 2 * cube.side()}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  Resampling(cube, equirect).run();
  return equirect;
}

}  // namespace furnace
