#include "renderer/texture_notes.hpp"

#include <gtest/gtest.h>

namespace furnace {
namespace {

ContentHash key(int i) {
  return HashBuilder().add(std::int64_t(i)).finish();
}

TEST(TextureNotes, AreToldAgainAtTheirNewPlace) {
  TextureNotes notes;
  notes.remember(key(1), {{"texture-downscaled", "/images/0", "has many pixels"}});
  const std::vector<Note> again = notes.recall(key(1), "/images/7");
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].code, "texture-downscaled");
  EXPECT_EQ(again[0].pointer, "/images/7");
  EXPECT_TRUE(notes.recall(key(2), "/images/7").empty());
  notes.remember(key(1), {});
  EXPECT_TRUE(notes.recall(key(1), "/images/7").empty());
}

TEST(TextureNotes, StayFew) {
  TextureNotes notes;
  for (int i = 0; i < 10'000; ++i) notes.remember(key(i), {{"a", "b", "c"}});
  EXPECT_TRUE(notes.recall(key(0), "").empty());
  EXPECT_EQ(notes.recall(key(9'999), "").size(), 1u);
}

}  // namespace
}  // namespace furnace
