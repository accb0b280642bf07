// Which context draws a scene, and when one has served long enough: decisions, without GL.
#include "renderer/context_pool.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace furnace {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

ContentHash scene(int number) {
  return HashBuilder().add("scene").add(std::int64_t(number)).finish();
}

TEST(ChooseContext, KeepsASceneWhereItIs) {
  const std::vector<int> idle(4, 0);
  for (int i = 0; i < 50; ++i) {
    const std::size_t home = choose_context(scene(i), idle);
    std::vector<int> callers(4, 0);
    callers[home] = 1;  // one more than the others: it is worth the wait
    EXPECT_EQ(choose_context(scene(i), callers), home);
  }
}

TEST(ChooseContext, LeavesABusyHome) {
  const std::vector<int> idle(3, 0);
  for (int i = 0; i < 50; ++i) {
    const std::size_t home = choose_context(scene(i), idle);
    std::vector<int> callers(3, 0);
    callers[home] = 2;
    const std::size_t second = choose_context(scene(i), callers);
    EXPECT_NE(second, home);
    callers[second] = 2;
    EXPECT_EQ(callers[choose_context(scene(i), callers)], 0);
    callers = {2, 2, 2};
    EXPECT_EQ(choose_context(scene(i), callers), home) << "all are as busy";
  }
}

TEST(ChooseContext, SpreadsScenes) {
  const std::vector<int> idle(4, 0);
  std::vector<int> scenes(4, 0);
  for (int i = 0; i < 400; ++i) ++scenes[choose_context(scene(i), idle)];
  // 100 each on average; 60 is five deviations off.
  EXPECT_GT(*std::min_element(scenes.begin(), scenes.end()), 60);
}

TEST(ChooseContext, MovesFewScenesWhenAContextIsAdded) {
  const std::vector<int> three(3, 0), four(4, 0);
  for (int i = 0; i < 100; ++i) {
    const std::size_t before = choose_context(scene(i), three), after = choose_context(scene(i), four);
    EXPECT_TRUE(after == before || after == 3);
  }
}

TEST(WornBy, EachEndIsOnlyThere) {
  const ContextUse much{1'000'000, hours(1000)};
  EXPECT_EQ(worn_by(much, {}, 1ll << 50), std::nullopt);
  EXPECT_EQ(worn_by({99, hours(0)}, {100, {}, 0}, 0), std::nullopt);
  EXPECT_EQ(worn_by({100, hours(0)}, {100, {}, 0}, 0), RenewalReason::kRenders);
  EXPECT_EQ(worn_by({0, minutes(59)}, {0, hours(1), 0}, 0), std::nullopt);
  EXPECT_EQ(worn_by({0, minutes(60)}, {0, hours(1), 0}, 0), RenewalReason::kAge);
}

TEST(WornBy, MemoryThatDoesNotComeBackIsNotAskedForAllTheTime) {
  const ContextLife life{0, {}, 1 << 30};
  EXPECT_EQ(worn_by({5, minutes(2)}, life, 1 << 30), std::nullopt);
  EXPECT_EQ(worn_by({5, minutes(2)}, life, (1 << 30) + 1), RenewalReason::kMemory);
  EXPECT_EQ(worn_by({5, seconds(59)}, life, (1 << 30) + 1), std::nullopt);
}

TEST(RenewalReasons, HaveNames) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kRenewalReasons; ++i) names.insert(name_of(RenewalReason(i)));
  EXPECT_EQ(names.size(), kRenewalReasons);
  EXPECT_FALSE(names.contains(""));
}

}  // namespace
}  // namespace furnace
