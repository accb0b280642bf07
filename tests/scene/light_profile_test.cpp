// Photometric files.
#include <cmath>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/light_profile.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

std::string file_of(const std::string& numbers, const std::string& tilt = "TILT=NONE") {
  return "IESNA:LM-63-2002\r\n[MANUFAC] none\r\n" + tilt + "\r\n" + numbers;
}

TEST(LightProfile, AnEvenLampHasFourPiTimesItsCandela) {
  const LightProfile profile = parse_ies(file_of("1 -1 1.5 3 1 1 2 0 0 0 0.5 1 10\n0 90 180\n0\n40 40 40\n"));
  EXPECT_DOUBLE_EQ(profile.peak_candela, 30);
  EXPECT_NEAR(profile.flux_lumen, 4 * kPi * 30, 1e-9);
  EXPECT_DOUBLE_EQ(profile.candela_towards(1, 2), 30);
}

// I = I0 cos(v) below the horizon: Lambert's lamp, pi I0 lumen. Linear between 91 angles that is exact to 1e-4.
TEST(LightProfile, FluxIsTheIntegral) {
  std::string angles, values;
  for (int v = 0; v <= 90; ++v) {
    angles += std::to_string(v) + (v % 10 == 9 ? "\n" : " ");
    values += std::to_string(100 * std::cos(v * kPi / 180)) + (v % 7 == 6 ? "\n" : ",");
  }
  const LightProfile profile =
      parse_ies(file_of("1 1000 1 91 1 1 1 0 0 0\n1 1 20\n" + angles + "\n0\n" + values));
  EXPECT_NEAR(profile.flux_lumen, 100 * kPi, 100 * kPi * 1e-4);
  EXPECT_EQ(profile.candela_towards(2, 0), 0);
  EXPECT_NEAR(profile.candela_towards(kPi / 3, 0), 50, 1e-3);
}

TEST(LightProfile, SymmetryFillsTheRest) {
  const std::string head = "1 1000 1 2 3 1 1 0 0 0 1 1 1\n0 180\n";
  const LightProfile quarter = parse_ies(file_of(head + "0 45 90\n1 1 2 2 3 3\n"));
  for (const double degrees : {90.0, 270.0})
    EXPECT_NEAR(quarter.candela_towards(1, degrees * kPi / 180), 3, 1e-9);
  for (const double degrees : {45.0, 135.0, 225.0, 315.0})
    EXPECT_NEAR(quarter.candela_towards(1, degrees * kPi / 180), 2, 1e-9) << degrees;
  const LightProfile half = parse_ies(file_of(head + "0 90 180\n1 1 2 2 3 3\n"));
  EXPECT_NEAR(half.candela_towards(1, 270 * kPi / 180), 2, 1e-9);
  EXPECT_NEAR(half.candela_towards(1, 350 * kPi / 180), 1 + 10.0 / 90, 1e-9);
  const LightProfile sideways = parse_ies(file_of(head + "90 180 270\n1 1 2 2 3 3\n"));
  for (const double degrees : {0.0, 180.0})
    EXPECT_NEAR(sideways.candela_towards(1, degrees * kPi / 180), 2, 1e-9);
  EXPECT_NEAR(sideways.candela_towards(1, 90 * kPi / 180), 1, 1e-9);
  EXPECT_NEAR(sideways.candela_towards(1, 270 * kPi / 180), 3, 1e-9);
  EXPECT_NEAR(sideways.candela_towards(1, 45 * kPi / 180), 1.5, 1e-9);
  EXPECT_NEAR(sideways.candela_towards(1, 315 * kPi / 180), 2.5, 1e-9);
}

TEST(LightProfile, ATiltThatIsIncludedIsPassedOver) {
  const LightProfile profile = parse_ies(
      file_of("1\n3\n0 45 90\n1 0.9 0.8\n1 1000 1 2 1 1 1 0 0 0 1 1 1\n0 90\n0\n7 7\n", "TILT=INCLUDE"));
  EXPECT_EQ(profile.peak_candela, 7);
}

TEST(LightProfile, WhatIsWrongIsNamedWithItsLine) {
  const std::pair<std::string, const char*> wrong[] = {
      {"", "no line that begins with TILT="},
      {file_of("1 1000 1 2 1 1 1 0 0 0 1 1 1\n0 90\n0\n7\n"), "the file ends before a candela value"},
      {file_of("1 1000 1 2 1 2 1 0 0 0 1 1 1\n"), "line 4: photometry of type A or B"},
      {file_of("1 1000 1 2 1 1 1 0 0 0 1 1 1\n0 x\n"), "line 5: a vertical angle is no number"},
      {file_of("1 1000 1 2 1 1 1 0 0 0 1 1 1\n90 0\n0\n"), "vertical angles must be"},
      {file_of("1 1000 1 2 2 1 1 0 0 0 1 1 1\n0 90\n0 77\n"), "horizontal angles must ascend"},
      {file_of("1 1000 1 2 1 1 1 0 0 0 1 1 1\n0 90\n0\n7 -1\n"), "below 0"},
      {file_of("1 1000 1 2 1 1 1 0 0 0 1 1 1\n0 90\n0\n0 0\n"), "every candela value is 0"},
      {file_of("1 1000 0 2 1 1 1 0 0 0 1 1 1\n"), "must be above 0"},
      {file_of("1 1000 1 1000000000 1 1 1 0 0 0 1 1 1\n"), "a whole number from 1 to 100000"},
      {file_of("1 1000 1 50000 50000 1 1 0 0 0 1 1 1\n"), "a whole number from 1 to 2"},
      {file_of("", "TILT=lamp.tlt"), "a TILT of its own file is not read"}};
  for (const auto& [text, message] : wrong) {
    try {
      parse_ies(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
      EXPECT_THAT(error.message, testing::HasSubstr(message));
    }
  }
}

// Whatever the bytes are: an error or a profile of finite numbers.
TEST(LightProfile, SurvivesGarbage) {
  std::mt19937 random(7);
  const std::string good = file_of("1 1000 1 3 3 1 2 0 0 0 1 1 10\n0 45 90\n0 45 90\n1 2 3 4 5 6 7 8 9\n");
  for (int i = 0; i < 20000; ++i) {
    std::string text = good;
    const int changes = 1 + int(random() % 4);
    for (int k = 0; k < changes; ++k) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = char(random());
          break;
        case 1:
          text.erase(at, random() % 8);
          break;
        default:
          text.insert(at, 1, "0123456789.-eE \n,"[random() % 17]);
      }
      if (text.empty()) break;
    }
    try {
      const LightProfile profile = parse_ies(text);
      ASSERT_TRUE(std::isfinite(profile.flux_lumen) && std::isfinite(profile.candela_towards(1, 4)));
    } catch (const Error& error) {
      ASSERT_EQ(error.code, ErrorCode::kUnprocessable);
    }
  }
}

}  // namespace
}  // namespace furnace
