#include "renderer/base/check.hpp"

#include <gtest/gtest.h>

namespace furnace {
namespace {

TEST(CheckDeathTest, ShowsExpressionValuesAndPlace) {
  const int index = 7;
  EXPECT_DEATH(FURNACE_CHECK(index < 3, "index {} of {}", index, 3),
               "FURNACE_CHECK\\(index < 3\\) failed at .*check_test.cpp:[0-9]+: index 7 of 3");
}

TEST(Check, EvaluatesItsConditionOnceAndItsValuesNever) {
  int conditions = 0, values = 0;
  FURNACE_CHECK(++conditions > 0, "{}", ++values);
  EXPECT_EQ(conditions, 1);
  EXPECT_EQ(values, 0);
}

}  // namespace
}  // namespace furnace
