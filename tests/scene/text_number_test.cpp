#include "renderer/scene/text_number.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace furnace {
namespace {

TEST(TextNumber, IsAllOfTheWord) {
  EXPECT_EQ(number_in("+1.5e3"), 1500);
  EXPECT_EQ(number_in("-.25"), -0.25);
  for (const auto* word : {"", "+", "-", "1x", "0x10", "1,5", " 1", "1 ", "++1", "#2"})
    EXPECT_FALSE(number_in(word)) << word;
}

TEST(TextNumber, NamesAreNumbers) {
  EXPECT_TRUE(std::isnan(number_in("nan").value_or(0)));
  EXPECT_EQ(number_in("-inf"), -std::numeric_limits<double>::infinity());
}

TEST(TextNumber, WhatNoDoubleHolds) {
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(number_in("1e999"), infinite);
  EXPECT_EQ(number_in("-1E+999"), -infinite);
  EXPECT_EQ(number_in("1" + std::string(400, '0')), infinite);
  EXPECT_EQ(number_in("1e-999"), 0);
  EXPECT_EQ(number_in("0." + std::string(400, '0') + "1"), 0);
}

}  // namespace
}  // namespace furnace
