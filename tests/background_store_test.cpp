// Backgrounds of their own on disk: what tests/bake_store_test.cpp says of bakes, where they differ.
#include "renderer/bake_store.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "renderer/base/file.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kAmple = 1 << 30;

const ContentHash kKey = HashBuilder().add("background store test").finish();

StoredBackground background() {
  Image texels = make_image({48, 24}, 4, SampleType::kFloat16, ColorSpace::kLinear);
  std::mt19937 random(7);
  for (std::uint16_t& sample : texels.samples<std::uint16_t>()) sample = std::uint16_t(random());
  return {{kKey, std::move(texels), 0x1p-5},
          {{"environment-repaired", "/environment/background/map", "how many"}}};
}

bool is_whole(const StoredBackground& found) {
  const StoredBackground expected = background();
  return found.sky.key == kKey && found.sky.scale == expected.sky.scale &&
         found.sky.texels.extent == expected.sky.texels.extent &&
         found.sky.texels.pixels == expected.sky.texels.pixels && found.notes == expected.notes;
}

class BackgroundStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "furnace_backgrounds_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  static void write(const fs::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  }

  fs::path folder_;
};

TEST_F(BackgroundStoreTest, GivesBackEveryBit) {
  ASSERT_TRUE(BakeStore(folder_, kAmple).save_background(kKey, background()));
  BakeStore store(folder_, kAmple);
  EXPECT_TRUE(is_whole(store.load_background(kKey).value()));
  EXPECT_FALSE(store.load_background(HashBuilder().add("another").finish()));
  EXPECT_EQ(store.stats().set_aside, 0);
}

TEST_F(BackgroundStoreTest, AChangedOrCutFileIsAMissOrChangesNothing) {
  BakeStore store(folder_, kAmple);
  ASSERT_TRUE(store.save_background(kKey, background()));
  const fs::path path = store.path_of(kKey);
  const std::string whole = read_file(path, kAmple);
  int misses = 0;
  constexpr int kChanges = 150;
  for (int i = 0; i < kChanges; ++i) {
    std::string changed = whole;
    char& byte = changed[std::size_t(i) * (whole.size() - 1) / (kChanges - 1)];
    byte = char(byte ^ 1 << i % 8);
    write(path, changed);
    const auto loaded = store.load_background(kKey);
    misses += !loaded;
    EXPECT_TRUE(!loaded || is_whole(*loaded)) << i;
  }
  EXPECT_GT(misses, kChanges * 3 / 4);
  for (const std::size_t length : {std::size_t{0}, whole.size() / 3, whole.size() - 1}) {
    write(path, whole.substr(0, length));
    EXPECT_FALSE(store.load_background(kKey)) << length;
  }
  EXPECT_EQ(store.stats().set_aside, misses + 3);
}

// Neither is taken for the other, whatever stands under a key.
TEST_F(BackgroundStoreTest, ABakeIsNoBackground) {
  BakeStore store(folder_, kAmple);
  StoredBake bake;
  bake.environment.sky = background().sky;
  bake.environment.atlas.texels = background().sky.texels;
  ASSERT_TRUE(store.save(kKey, bake));
  EXPECT_FALSE(store.load_background(kKey));
  ASSERT_TRUE(store.save_background(kKey, background()));
  EXPECT_FALSE(store.load(kKey));
  EXPECT_EQ(store.stats().set_aside, 2);
}

}  // namespace
}  // namespace furnace
