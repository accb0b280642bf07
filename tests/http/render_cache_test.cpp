#include "server/render_cache.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

class RenderCacheTest : public ::testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  RenderCacheConfig config(std::int64_t memory_bytes, std::int64_t disk_bytes = 1 << 20) const {
    return {memory_bytes, folder_, disk_bytes};
  }
  api::StoredRender draw(std::size_t bytes = 100) {
    ++drawn_;
    return {std::string(bytes, char('a' + drawn_ % 26)), "image/png", 0.25, 3,
            {{"code", "/p", "what \xc3\xa9"}},           "{\"a\":1}"};
  }
  std::function<api::StoredRender()> drawing() {
    return [this] { return draw(); };
  }
  static ContentHash tag(std::string_view name) { return HashBuilder().add(name).finish(); }

  fs::path folder_ = fs::temp_directory_path() / ("render_cache_test." + std::to_string(::getpid()));
  int drawn_ = 0;
};

TEST_F(RenderCacheTest, DrawsOnceAndAnswersFromMemory) {
  RenderCache cache(config(1 << 20));
  EXPECT_FALSE(cache.find(tag("a"), {}));
  EXPECT_EQ(cache.get_or_draw(tag("a"), {}, drawing()).origin, RenderOrigin::kDrawn);
  const auto again = cache.get_or_draw(tag("a"), {}, drawing());
  EXPECT_EQ(again.origin, RenderOrigin::kMemory);
  EXPECT_EQ(again.render->bytes, std::string(100, 'b'));
  EXPECT_EQ(cache.find(tag("a"), {}), again.render);
  EXPECT_EQ(drawn_, 1);
}

TEST_F(RenderCacheTest, OutlivesTheProcessOnDisk) {
  const api::StoredRender first = *RenderCache(config(1 << 20)).get_or_draw(tag("a"), {}, drawing()).render;
  RenderCache next(config(1 << 20));
  const auto found = next.get_or_draw(tag("a"), {}, drawing());
  EXPECT_EQ(found.origin, RenderOrigin::kDisk);
  EXPECT_EQ(found.render->bytes, first.bytes);
  EXPECT_EQ(found.render->notes, first.notes);
  EXPECT_EQ(found.render->report, first.report);
  EXPECT_EQ(found.render->frames, 3);
  EXPECT_EQ(found.render->exposure_ev, 0.25);
  EXPECT_EQ(next.get_or_draw(tag("a"), {}, drawing()).origin, RenderOrigin::kMemory)
      << "and is in memory now";
  RenderCache third(config(0));
  EXPECT_TRUE(third.find(tag("a"), {}));
  EXPECT_FALSE(third.find(tag("b"), {}));
  EXPECT_EQ(drawn_, 1);
}

TEST_F(RenderCacheTest, DamagedFilesAreDrawnAnew) {
  for (const std::size_t at : {3u, 70u, 200u}) {
    RenderCache(config(0)).get_or_draw(tag("a"), {}, drawing());
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      if (entry.path().extension() != ".render") continue;
      std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(std::streamoff(at));
      file.put('#');
    }
    const int before = drawn_;
    EXPECT_EQ(RenderCache(config(0)).get_or_draw(tag("a"), {}, drawing()).origin, RenderOrigin::kDrawn) << at;
    EXPECT_EQ(drawn_, before + 1);
  }
}

TEST_F(RenderCacheTest, EveryTruncationIsRefused) {
  const std::string file = api::encode_stored_render(draw());
  EXPECT_EQ(api::decode_stored_render(file).bytes, std::string(100, 'b'));
  for (std::size_t size = 0; size < file.size(); ++size)
    EXPECT_THROW(api::decode_stored_render(file.substr(0, size)), Error) << size;
  EXPECT_THROW(api::decode_stored_render(file + "x"), Error);
}

TEST_F(RenderCacheTest, FailuresAreNotKept) {
  RenderCache cache(config(1 << 20));
  const auto failing = []() -> api::StoredRender { fail(ErrorCode::kUnprocessable, "no"); };
  EXPECT_THROW(cache.get_or_draw(tag("a"), {}, failing), Error);
  EXPECT_EQ(cache.get_or_draw(tag("a"), {}, drawing()).origin, RenderOrigin::kDrawn);
}

TEST_F(RenderCacheTest, TheDisksBudgetHolds) {
  RenderCache cache(config(0, 2000));
  for (int i = 0; i < 20; ++i) cache.get_or_draw(tag(std::to_string(i)), {}, drawing());
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    if (entry.is_regular_file()) bytes += entry.file_size();
  EXPECT_LE(bytes, 2000u);
  EXPECT_GT(bytes, 0u);
  EXPECT_TRUE(cache.find(tag("19"), {}));
  EXPECT_FALSE(cache.find(tag("0"), {}));
}

TEST_F(RenderCacheTest, EqualRequestsTogetherAreDrawnOnce) {
  RenderCache cache(config(1 << 20));
  std::atomic<int> drawn = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&] {
      cache.get_or_draw(tag("a"), {}, [&] {
        ++drawn;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return api::StoredRender{"x", "image/png", 0, 1, {}, ""};
      });
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(drawn, 1);
}

}  // namespace
}  // namespace furnace
