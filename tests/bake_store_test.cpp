// What the store promises of a disk that breaks, fills up, is shared, or loses its writer.
#include "renderer/bake_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "renderer/image/exr_parts.hpp"
#include "renderer/base/file.hpp"
#include "tests/support/unprivileged.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr std::int64_t kAmple = 1 << 30;
constexpr const char* kChildFolder = "FURNACE_BAKE_STORE_TEST_FOLDER";
constexpr const char* kChildBudget = "FURNACE_BAKE_STORE_TEST_BUDGET";
constexpr const char* kChildSaves = "FURNACE_BAKE_STORE_TEST_SAVES";

ContentHash key_of(int number) {
  return HashBuilder().add("bake store test").add(std::int64_t(number)).finish();
}

// Every pattern of bits, NaN too: the store is no judge of them.
Image random_halves(Extent extent, unsigned seed) {
  Image image = make_image(extent, 4, SampleType::kFloat16, ColorSpace::kLinear);
  std::mt19937 random(seed);
  for (std::uint16_t& sample : image.samples<std::uint16_t>()) sample = std::uint16_t(random());
  return image;
}

StoredBake make_bake(int number, Extent sky = {32, 16}, Extent atlas = {40, 52}) {
  StoredBake bake;
  bake.environment.key = key_of(number);
  bake.environment.sky = {key_of(number), random_halves(sky, unsigned(number)), 0x1p-17};
  bake.environment.map = {map_key_of(key_of(number)), random_halves(sky, unsigned(number) + 500), 0x1p-3};
  bake.environment.atlas = {random_halves(atlas, unsigned(number) + 1000),
                            0x1p-9 * (number + 1),
                            {0.1, 1.0 / 3, 1},
                            {{1, 1, 16}, {19, 1, 16}, {1, 19, 20}},
                            {23, 19, 8}};
  bake.environment.summary = {{4096, 2048}, EnvironmentLayout::kVerticalCross,
                              {1, 2, 3},    {0.1, 0.2, 1e-30},
                              65504.25,     1.0 / 7,
                              812.5,        {{{0.6, 0.8, 0}, {1e5, 2e4, 1.0 / 3}, 0.0047, 7e-5, 118272}},
                              true};
  bake.notes = {{"environment-repaired", "/environment/map", std::string("all\0bytes \xff \n", 13)},
                {"", "", ""}};
  return bake;
}

auto members(const Image& image) {
  return std::tie(image.extent, image.channels, image.type, image.color_space, image.pixels);
}
auto members(const PreparedSky& sky) {
  return std::tuple_cat(std::tie(sky.key, sky.scale), members(sky.texels));
}
auto members(const AtlasTile& tile) {
  return std::tie(tile.x, tile.y, tile.inner);
}
auto members(const Note& note) {
  return std::tie(note.code, note.pointer, note.message);
}

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return std::ranges::equal(a, b, [](const T& x, const T& y) { return members(x) == members(y); });
}

bool same(const StoredBake& a, const StoredBake& b) {
  const PreparedEnvironment &x = a.environment, &y = b.environment;
  return x.key == y.key && members(x.sky) == members(y.sky) && members(x.map) == members(y.map) &&
         members(x.atlas.texels) == members(y.atlas.texels) && x.atlas.scale == y.atlas.scale &&
         x.atlas.level_roughness == y.atlas.level_roughness &&
         same(x.atlas.level_tiles, y.atlas.level_tiles) &&
         members(x.atlas.irradiance_tile) == members(y.atlas.irradiance_tile) && x.summary == y.summary &&
         same(a.notes, b.notes);
}

void write(const fs::path& path, std::string_view bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (entry.is_regular_file()) names.push_back(entry.path().filename().string());
  }
  return names;
}

class BakeStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "furnace_bakes_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  // This program again, saving and trimming in `folder_` (see BakeStoreChild).
  pid_t start_child(std::int64_t budget_bytes, int saves) {
    const std::string folder = folder_.string(), budget = std::to_string(budget_bytes),
                      count = std::to_string(saves);
    const pid_t child = fork();
    if (child == 0) {
      setenv(kChildFolder, folder.c_str(), 1);
      setenv(kChildBudget, budget.c_str(), 1);
      setenv(kChildSaves, count.c_str(), 1);
      execl("/proc/self/exe", "bake_store_test", "--gtest_filter=BakeStoreChild.Saves", "--gtest_brief=1",
            static_cast<char*>(nullptr));
      _exit(127);
    }
    return child;
  }

  fs::path folder_;
};

TEST(BakeStoreChild, Saves) {
  const char* const folder = std::getenv(kChildFolder);
  if (folder == nullptr) GTEST_SKIP() << "the other tests start this one";
  BakeStore store(folder, std::atoll(std::getenv(kChildBudget)));
  const int saves = std::atoi(std::getenv(kChildSaves));
  for (int i = 0; i < saves; ++i) {
    ASSERT_TRUE(store.save(key_of(i % 7), make_bake(i % 7, {128, 64})));
    const auto loaded = store.load(key_of((i + 3) % 7));
    ASSERT_TRUE(!loaded || same(*loaded, make_bake((i + 3) % 7, {128, 64})));
  }
  EXPECT_EQ(store.stats().set_aside, 0);
}

TEST_F(BakeStoreTest, GivesBackEveryBit) {
  const StoredBake bake = make_bake(1), other = make_bake(2, {64, 32}, {41, 53});
  {
    BakeStore store(folder_, kAmple);
    EXPECT_FALSE(store.load(key_of(1)));
    EXPECT_TRUE(store.save(key_of(1), bake));
    EXPECT_TRUE(store.save(key_of(2), make_bake(3)));
    EXPECT_TRUE(store.save(key_of(2), other));
  }
  BakeStore store(folder_, kAmple);
  EXPECT_TRUE(same(store.load(key_of(1)).value(), bake));
  EXPECT_TRUE(same(store.load(key_of(2)).value(), other));
  EXPECT_EQ(names_in(store.path_of(key_of(1)).parent_path()).size(), 2u);
  EXPECT_EQ(store.stats().hits, 2);
  EXPECT_EQ(store.stats().misses, 0);
}

TEST_F(BakeStoreTest, WithoutABudgetTouchesNothing) {
  BakeStore store(folder_, 0);
  EXPECT_FALSE(store.save(key_of(1), make_bake(1)));
  EXPECT_FALSE(store.load(key_of(1)));
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(BakeStoreTest, CutFilesAreMisses) {
  BakeStore store(folder_, kAmple);
  ASSERT_TRUE(store.save(key_of(1), make_bake(1)));
  const fs::path path = store.path_of(key_of(1));
  const std::string whole = read_file(path, kAmple);
  for (std::size_t i = 0; i < 40; ++i) {
    // The ends of header, tables and pixels are where a reader could stumble: more cuts near the front.
    const std::size_t length = i < 20 ? i * 97 : whole.size() - 1 - (39 - i) * (whole.size() / 21);
    write(path, whole.substr(0, length));
    EXPECT_FALSE(store.load(key_of(1))) << length;
    EXPECT_FALSE(fs::exists(path)) << length;
  }
  EXPECT_EQ(store.stats().set_aside, 40);
  write(path, whole);
  EXPECT_TRUE(store.load(key_of(1)));
}

TEST_F(BakeStoreTest, AChangedByteIsAMissOrChangesNothing) {
  BakeStore store(folder_, kAmple);
  const StoredBake bake = make_bake(1);
  ASSERT_TRUE(store.save(key_of(1), bake));
  const fs::path path = store.path_of(key_of(1));
  const std::string whole = read_file(path, kAmple);
  const std::size_t header = whole.find("furnace.skyScale");
  ASSERT_NE(header, whole.npos);
  int misses = 0, tries = 0;
  const auto change = [&](std::size_t at, char mask) {
    std::string changed = whole;
    changed[at] = char(changed[at] ^ mask);
    write(path, changed);
    const auto loaded = store.load(key_of(1));
    ++tries;
    misses += !loaded;
    EXPECT_TRUE(!loaded || same(*loaded, bake)) << at;
  };
  for (std::size_t at = 0; at < 2 * header; at += 5) change(at, at % 2 ? char(0xff) : char(1));
  for (std::size_t i = 0; i < 200; ++i) change(i * (whole.size() - 1) / 199, char(1 << i % 8));
  EXPECT_GT(misses, tries * 3 / 4);  // most bytes are pixels, and none of those may pass
  EXPECT_EQ(store.stats().set_aside, misses);
}

TEST_F(BakeStoreTest, ForeignFilesAreSetAside) {
  BakeStore store(folder_, kAmple);
  ASSERT_TRUE(store.save(key_of(1), make_bake(1)));
  const std::string file = read_file(store.path_of(key_of(1)), kAmple);
  const auto replaced = [&](std::string_view from, std::string_view to) {
    std::string changed = file;
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, changed.npos) << from;
    return at == changed.npos ? changed : changed.replace(at, from.size(), to);
  };
  // A string attribute: name, type, size, text.
  const auto attribute = [](std::string_view name, std::string_view text) {
    return fmt::format("{0}{3}string{3}{1}{3}{3}{3}{2}", name, char(text.size()), text, '\0');
  };
  const std::string version = std::to_string(kBakeVersion), layout = std::to_string(kBakeFileLayout);
  const Image sky = random_halves({4, 2}, 1);
  const Image plain = make_image({4, 2}, 4, SampleType::kFloat16, ColorSpace::kLinear);
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"another bake's key", file},
      {"no EXR", "this is not a picture"},
      {"empty", ""},
      {"an EXR of one part", encode_exr(plain, {})},
      {"no texts", encode_exr_parts(std::vector<NamedImage>{{"sky", &sky}, {"atlas", &plain}}, {})},
      {"other parts", encode_exr_parts(std::vector<NamedImage>{{"sky", &sky}, {"moon", &plain}}, {})},
      {"another layout", replaced(attribute("furnace.layout", layout), attribute("furnace.layout", "9"))},
      {"another bake's version",
       replaced(attribute("furnace.bakeVersion", version),
                attribute("furnace.bakeVersion", std::string(version.size(), '0')))},
  };
  for (const auto& [what, bytes] : cases) {
    const auto set_aside = store.stats().set_aside;
    write(store.path_of(key_of(2)), bytes);
    EXPECT_FALSE(store.load(key_of(2))) << what;
    EXPECT_EQ(store.stats().set_aside, set_aside + 1) << what;
    EXPECT_FALSE(fs::exists(store.path_of(key_of(2)))) << what;
    EXPECT_TRUE(store.save(key_of(2), make_bake(2))) << what;
    EXPECT_TRUE(store.load(key_of(2))) << what;
  }
  EXPECT_TRUE(store.load(key_of(1)));
}

TEST_F(BakeStoreTest, KeepsTheNewestSixteenDamagedFiles) {
  BakeStore store(folder_, kAmple);
  for (int i = 0; i < 20; ++i) {
    write(store.path_of(key_of(i)), "?");
    EXPECT_FALSE(store.load(key_of(i)));
  }
  const fs::path damaged = store.path_of(key_of(0)).parent_path() / "damaged";
  EXPECT_EQ(names_in(damaged).size(), 16u);
  EXPECT_TRUE(fs::exists(damaged / (key_of(19).hex() + ".bad")));
  EXPECT_FALSE(fs::exists(damaged / (key_of(0).hex() + ".bad")));
}

TEST_F(BakeStoreTest, TrimsWhatWasUsedLongestAgo) {
  std::int64_t one = 0;
  {
    BakeStore store(folder_, kAmple);
    for (int i = 0; i < 4; ++i) {
      ASSERT_TRUE(store.save(key_of(i), make_bake(i)));
      const fs::path path = store.path_of(key_of(i));
      one = std::int64_t(fs::file_size(path)) + 8;  // the scales' digits differ in number
      fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(10 - i));
    }
    EXPECT_TRUE(store.load(key_of(0)));  // the oldest no longer
    write(store.path_of(key_of(9)), "?");
    EXPECT_FALSE(store.load(key_of(9)));
  }
  write(folder_ / "bakes" / "mine.exr", std::string(std::size_t(one), 'x'));  // not ours to remove or count
  const fs::path outdated = folder_ / "bakes" / "v0" / (key_of(8).hex() + ".exr");
  write(outdated, "of an older layout");
  fs::last_write_time(outdated, fs::file_time_type::clock::now() - std::chrono::hours(20));
  BakeStore store(folder_, 3 * one);
  ASSERT_TRUE(store.save(key_of(5), make_bake(5)));
  for (const int kept : {0, 3, 5}) EXPECT_TRUE(fs::exists(store.path_of(key_of(kept)))) << kept;
  for (const int removed : {1, 2}) EXPECT_FALSE(fs::exists(store.path_of(key_of(removed)))) << removed;
  EXPECT_TRUE(fs::exists(folder_ / "bakes" / "mine.exr"));
  EXPECT_FALSE(fs::exists(outdated));
  EXPECT_TRUE(names_in(store.path_of(key_of(0)).parent_path() / "damaged").empty());
  EXPECT_EQ(store.stats().trimmed, 4);
}

TEST_F(BakeStoreTest, WhatIsLargerThanTheBudgetIsNotKept) {
  BakeStore store(folder_, 4096);
  testing::internal::CaptureStderr();
  EXPECT_FALSE(store.save(key_of(1), make_bake(1)));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("bakes.too_large"));
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(BakeStoreTest, AFolderThatCannotBeWrittenIsSaidOnce) {
  write(folder_ / "file", "");
  write(folder_ / "bakes", "");
  // A file in place of the folder refuses root too.
  for (const fs::path& folder : {folder_, folder_ / "file", fs::path("/proc/furnace")}) {
    testing::internal::CaptureStderr();
    BakeStore store(folder, kAmple);
    for (int i = 0; i < 5; ++i) {
      EXPECT_FALSE(store.load(key_of(i)));
      EXPECT_FALSE(store.save(key_of(i), make_bake(i)));
    }
    EXPECT_EQ(store.stats().refused, 5);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_EQ(std::ranges::count(said, '\n'), 1) << said;
    EXPECT_THAT(said, HasSubstr("bakes.write_failed"));
  }
}

TEST_F(BakeStoreTest, AFolderWithoutPermissionToWriteStillServes) {
  const test::Unprivileged unprivileged(folder_);  // root may write everywhere
  BakeStore(folder_, kAmple).save(key_of(1), make_bake(1));
  BakeStore store(folder_, kAmple);
  const fs::path current = store.path_of(key_of(1)).parent_path();
  fs::permissions(current, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_TRUE(store.load(key_of(1)));
  EXPECT_FALSE(store.save(key_of(2), make_bake(2)));
  fs::permissions(current, fs::perms::owner_all);
}

// A limit on the size of files stands in for a full disk: write() takes a part, then refuses.
TEST_F(BakeStoreTest, AFullDiskLeavesNothingBehind) {
  BakeStore store(folder_, kAmple);
  ASSERT_TRUE(store.save(key_of(1), make_bake(1)));
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{10'000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  const bool saved = store.save(key_of(2), make_bake(2, {256, 128}));
  const bool replaced = store.save(key_of(1), make_bake(1, {256, 128}));
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  signal(SIGXFSZ, handler);
  EXPECT_FALSE(saved || replaced);
  EXPECT_TRUE(same(store.load(key_of(1)).value(), make_bake(1)));
  EXPECT_EQ(names_in(store.path_of(key_of(1)).parent_path()).size(), 1u);
  EXPECT_TRUE(store.save(key_of(2), make_bake(2, {256, 128})));
}

TEST_F(BakeStoreTest, SurvivesTheDeathOfItsWriterAtAnyInstant) {
  const fs::path current = BakeStore(folder_, 0).path_of(key_of(0)).parent_path();
  int loaded = 0, unfinished = 0;
  for (int round = 0; round < 20; ++round) {
    const pid_t child = start_child(kAmple, 1'000'000);
    ASSERT_GT(child, 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(40 + 3 * round));
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child ended by itself, " << status;

    for (const std::string& name : names_in(current)) unfinished += name.ends_with(".tmp");
    BakeStore store(folder_, kAmple);
    for (const std::string& name : names_in(current)) EXPECT_TRUE(name.ends_with(".exr")) << name;
    for (int i = 0; i < 7; ++i) {
      const bool is_there = fs::exists(store.path_of(key_of(i)));
      const auto bake = store.load(key_of(i));
      EXPECT_EQ(bool(bake), is_there);
      EXPECT_TRUE(!bake || same(*bake, make_bake(i, {128, 64})));
      loaded += bool(bake);
    }
    EXPECT_EQ(store.stats().set_aside, 0);
    EXPECT_TRUE(store.save(key_of(round % 7), make_bake(round % 7, {128, 64})));
  }
  EXPECT_GT(loaded, 0);
  RecordProperty("unfinished", unfinished);  // 13 of 20 deaths, where this was written
}

TEST_F(BakeStoreTest, LeavesTheUnfinishedFilesOfTheLivingAlone) {
  BakeStore(folder_, kAmple).save(key_of(1), make_bake(1));
  const fs::path current = BakeStore(folder_, kAmple).path_of(key_of(1)).parent_path();
  const auto unfinished = [&](int number, const std::string& pid) {
    const fs::path path = current / fmt::format(".{}.exr.{}.1.tmp", key_of(number).hex(), pid);
    write(path, "x");
    return path;
  };
  const std::string parent = std::to_string(getppid());
  const fs::path living = unfinished(1, parent), old = unfinished(2, parent),
                 dead = unfinished(3, "999999999"), own = unfinished(4, std::to_string(getpid())),
                 no_pid = current / ("." + key_of(5).hex() + ".exr.tmp");
  write(no_pid, "x");
  fs::last_write_time(old, fs::file_time_type::clock::now() - std::chrono::hours(2));
  const BakeStore store(folder_, kAmple);
  EXPECT_TRUE(fs::exists(living));
  EXPECT_FALSE(fs::exists(old));
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_FALSE(fs::exists(own));
}

TEST_F(BakeStoreTest, TwoProcessesSaveAndTrimAtOnce) {
  constexpr std::int64_t kBudget = 4 * 90'000;  // of seven keys, four fit
  const pid_t children[] = {start_child(kBudget, 60), start_child(kBudget, 60)};
  for (const pid_t child : children) {
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  }
  BakeStore store(folder_, kBudget);
  std::int64_t bytes = 0;
  int loaded = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
    if (entry.is_regular_file()) bytes += std::int64_t(entry.file_size());
  }
  EXPECT_LE(bytes, kBudget);
  for (int i = 0; i < 7; ++i) loaded += bool(store.load(key_of(i)));
  EXPECT_GE(loaded, 2);
  EXPECT_EQ(store.stats().set_aside, 0);
}

TEST_F(BakeStoreTest, ThreadsShareAStore) {
  BakeStore store(folder_, 4 * 25'000);
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 20; ++i) {
        const int number = (i + t) % 6;
        if (!store.save(key_of(number), make_bake(number))) ++wrong;
        const auto loaded = store.load(key_of((number + 2) % 6));
        if (loaded && !same(*loaded, make_bake((number + 2) % 6))) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(store.stats().saved, 80);
  EXPECT_EQ(store.stats().set_aside, 0);
}

}  // namespace
}  // namespace furnace
