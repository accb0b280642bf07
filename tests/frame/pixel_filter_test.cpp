#include "renderer/frame/pixel_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "renderer/frame/frame_plan.hpp"

namespace furnace {
namespace {

const std::vector<PixelFilter> kFilters = {{PixelFilterKind::kBox, 0.5},
                                           {PixelFilterKind::kBox, 1.25},
                                           {PixelFilterKind::kGaussian, 1.5},
                                           {PixelFilterKind::kBlackmanHarris, 1.5},
                                           {PixelFilterKind::kMitchell, 2}};

std::vector<glm::vec2> places(int count) {
  std::vector<glm::vec2> out;
  for (int i = 0; i < count; ++i) out.push_back(r2_offset(i));
  return out;
}

// The share of the filter below `x`, by the midpoint rule.
double share_below(const PixelFilter& filter, double x) {
  constexpr int kSteps = 100'000;
  double below = 0, all = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double at = filter.radius_px * (2 * (i + 0.5) / kSteps - 1);
    all += filter_value(filter, at);
    if (at < x) below += filter_value(filter, at);
  }
  return below / all;
}

TEST(PixelFilter, TheBoxOfAPixelIsNoChange) {
  std::vector<glm::vec2> warped = places(64);
  const std::vector<float> weights = warp_by_filter({}, warped);
  EXPECT_EQ(warped, places(64));
  EXPECT_EQ(weights, std::vector<float>(64, 1.f / 64));
}

TEST(PixelFilter, WeightsSumToOneAndTheFirstIsTheMiddle) {
  for (const PixelFilter& filter : kFilters) {
    for (const int count : {1, 2, 3, 16, 4096}) {
      std::vector<glm::vec2> warped = places(count);
      const std::vector<float> weights = warp_by_filter(filter, warped);
      EXPECT_EQ(warped[0], glm::vec2(0));
      EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-6);
      for (const glm::vec2& at : warped) {
        EXPECT_LE(std::abs(at.x), filter.radius_px);
        EXPECT_LE(std::abs(at.y), filter.radius_px);
      }
    }
  }
}

// The error of so many quasi-random places; that of random ones is 0.008.
TEST(PixelFilter, PlacesAndWeightsAreTheFilter) {
  for (const PixelFilter& filter : kFilters) {
    std::vector<glm::vec2> warped = places(4096);
    const std::vector<float> weights = warp_by_filter(filter, warped);
    for (double x = -filter.radius_px; x < filter.radius_px; x += filter.radius_px / 7) {
      double across = 0, down = 0;
      for (std::size_t i = 0; i < warped.size(); ++i) {
        if (double(warped[i].x) < x) across += double(weights[i]);
        if (double(warped[i].y) < x) down += double(weights[i]);
      }
      EXPECT_NEAR(across, share_below(filter, x), 2e-3) << x;
      EXPECT_NEAR(down, share_below(filter, x), 2e-3) << x;
    }
  }
}

// However few sub-frames fall into negative lobes, together they take what the filter does.
TEST(PixelFilter, LobesHaveTheirOwnShare) {
  const PixelFilter filter{PixelFilterKind::kMitchell, 2};
  double positive = 0, negative = 0;  // along one axis
  constexpr int kSteps = 100'000;
  for (int i = 0; i < kSteps; ++i) {
    const double value = filter_value(filter, 4 * (i + 0.5) / kSteps - 2) * 4 / kSteps;
    (value < 0 ? negative : positive) += std::abs(value);
  }
  ASSERT_NEAR(positive - negative, 1, 1e-6);
  const double expected = 2 * positive * negative;
  int with_lobes = 0;
  for (const int count : {2, 4, 8, 16, 64, 1024}) {
    std::vector<glm::vec2> warped = places(count);
    double lobes = 0;
    for (const float weight : warp_by_filter(filter, warped)) lobes -= std::min(double(weight), 0.0);
    if (lobes == 0) continue;  // none fell into one
    EXPECT_NEAR(lobes, expected, 1e-4) << count;
    ++with_lobes;
  }
  EXPECT_GE(with_lobes, 4);
}

// Mitchell and Netravali 1988: the cubic is 8/9 in the middle, 1/18 a quarter of its support away, negative beyond.
TEST(PixelFilter, MitchellsCubic) {
  const PixelFilter filter{PixelFilterKind::kMitchell, 2};
  EXPECT_NEAR(filter_value(filter, 0), 8.0 / 9, 1e-12);
  EXPECT_NEAR(filter_value(filter, 1), 1.0 / 18, 1e-12);
  EXPECT_LT(filter_value(filter, 1.5), 0);
  EXPECT_NEAR(filter_value(filter, 1.9999999), 0, 1e-6);
  EXPECT_EQ(filter_value(filter, 2), 0);
}

}  // namespace
}  // namespace furnace
