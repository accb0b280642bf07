#include "renderer/ibl/dfg.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/reference/lobe.hpp"

namespace furnace {
namespace {

const DfgTexel& texel(int column, int row) {
  return dfg_table()[std::size_t(row) * kDfgTableSize + column];
}
double coordinate(int index) {
  return (index + 0.5) / kDfgTableSize;
}

TEST(Dfg, AgreesWithSampledVisibleNormals) {
  constexpr double kTolerance = 1e-4;  // the bar for the table
  for (int row : {0, 3, 12, 31, 64, 127}) {
    for (int column : {0, 2, 9, 30, 64, 127}) {
      const double alpha = coordinate(row) * coordinate(row);
      const reference::LobeMoments expected = reference::integrate_lobe(coordinate(column), alpha, 400);
      const DfgTexel& found = texel(column, row);
      EXPECT_NEAR(found.scale, expected.scale, kTolerance)
          << "NoV " << coordinate(column) << " alpha " << alpha;
      EXPECT_NEAR(found.bias, expected.bias, kTolerance)
          << "NoV " << coordinate(column) << " alpha " << alpha;
      const double mean_angle = std::atan2(expected.tangent, expected.normal);
      EXPECT_NEAR(found.lean_rad, std::acos(coordinate(column)) - mean_angle, 5e-5)
          << "NoV " << coordinate(column) << " alpha " << alpha;
      EXPECT_NEAR(found.sheen, reference::integrate_sheen(coordinate(column), coordinate(row), 600),
                  kTolerance)
          << "NoV " << coordinate(column) << " roughness " << coordinate(row);
    }
  }
}

TEST(Dfg, NeverReflectsMoreThanArrives) {
  for (const DfgTexel& t : dfg_table()) {
    EXPECT_GE(t.scale, 0);
    EXPECT_GE(t.bias, 0);
    EXPECT_LE(t.scale + t.bias, 1 + 1e-4);  // single scattering loses light, it never adds any
    EXPECT_GE(t.lean_rad, -1e-6);
    EXPECT_GE(t.sheen, 0);
    EXPECT_LE(t.sheen, 1);
  }
}

TEST(Dfg, MirrorInTheSmoothLimit) {
  for (int column = 8; column < kDfgTableSize; ++column) {
    const DfgTexel& t = texel(column, 0);
    const double schlick = std::pow(1 - coordinate(column), 5);
    EXPECT_NEAR(t.scale + t.bias, 1, 1e-3);  // alpha = 1.5e-5: nothing is lost but a trace of the lobe's tail
    EXPECT_NEAR(t.bias, schlick, 1e-3);
    EXPECT_NEAR(t.lean_rad, 0, 1e-3);
  }
}

TEST(Dfg, RoughLobesLeanToTheNormal) {
  for (int column = 8; column < 120; ++column) {
    const double mirror_angle = std::acos(coordinate(column));
    EXPECT_GT(texel(column, 127).lean_rad, 0.1 * mirror_angle);
    EXPECT_LT(texel(column, 127).lean_rad, mirror_angle);
  }
}

TEST(Dfg, TheBuiltInTableIsTheComputedOne) {
  const DfgTable table = compute_dfg_table(kDfgTableSize);
  ASSERT_EQ(table.texels.size(), dfg_table().size());
  const auto same = [](const DfgTexel& a, const DfgTexel& b) {
    return a.scale == b.scale && a.bias == b.bias && a.lean_rad == b.lean_rad && a.sheen == b.sheen;
  };
  EXPECT_TRUE(std::equal(table.texels.begin(), table.texels.end(), dfg_table().begin(), same));
}

}  // namespace
}  // namespace furnace
