#include "server/asset_store.hpp"

#include <algorithm>
#include <fstream>

#include <sys/file.h>
#include <fcntl.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Time = AssetStoreConfig::Time;

ContentHash hash_of(std::string_view text) {
  return hash_bytes(std::as_bytes(std::span(text)));
}

class AssetStoreTest : public ::testing::Test {
 protected:
  AssetStoreTest() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    config_.folder = fs::path(::testing::TempDir()) / (std::string("assets_") + test->name());
    fs::remove_all(config_.folder);
    config_.now = [this] { return now_; };
  }
  ~AssetStoreTest() override {
    std::error_code ignored;
    fs::remove_all(config_.folder, ignored);
  }

  static AssetStore::Kept put(AssetStore& store, std::string_view text,
                              std::optional<ContentHash> wanted = std::nullopt) {
    const auto upload = store.begin();
    for (std::size_t i = 0; i < text.size(); i += 1000) upload->take(text.substr(i, 1000));
    return store.keep(*upload, wanted, {"model/gltf-binary", "a.glb"});
  }
  static Error error_of(const std::function<void()>& body) {
    try {
      body();
    } catch (const Error& error) {
      return error;
    }
    ADD_FAILURE() << "no error";
    return {};
  }
  fs::path path_of(const ContentHash& hash) const {
    return config_.folder / hash.hex().substr(0, 2) / hash.hex();
  }
  std::ptrdiff_t files_below(const char* folder) const {
    std::error_code missing;
    return std::distance(fs::directory_iterator(config_.folder / folder, missing), fs::directory_iterator());
  }
  void later(std::chrono::milliseconds time) { now_ += time; }

  Time now_ = Time::clock::now();
  AssetStoreConfig config_;
};

TEST_F(AssetStoreTest, KeepsTheBytesUnderTheirHash) {
  AssetStore store(config_);
  const std::string text(5000, 'x');
  const AssetStore::Kept kept = put(store, text, hash_of(text));
  EXPECT_TRUE(kept.is_new);
  EXPECT_EQ(kept.entry.hash, hash_of(text));
  EXPECT_EQ(store.read(hash_of(text))->text(), text);
  const auto found = AssetStore(config_).find(hash_of(text));  // after a restart too
  ASSERT_TRUE(found);
  EXPECT_EQ(found->bytes, 5000);
  EXPECT_EQ(found->about.media_type, "model/gltf-binary");
  EXPECT_EQ(found->about.name, "a.glb");
  EXPECT_EQ(found->created_ms, kept.entry.created_ms);
  EXPECT_EQ(files_below("uploads"), 0);
}

TEST_F(AssetStoreTest, ASecondUploadOfTheSameBytesAddsNothing) {
  AssetStore store(config_);
  EXPECT_TRUE(put(store, "same").is_new);
  EXPECT_FALSE(put(store, "same").is_new);
  EXPECT_EQ(store.stats().assets, 1);
  EXPECT_EQ(store.stats().uploads, 2);
}

TEST_F(AssetStoreTest, AnotherHashThanPromisedKeepsNothing) {
  AssetStore store(config_);
  const Error error = error_of([&] { put(store, "these", hash_of("those")); });
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(error.message, HasSubstr(hash_of("these").hex()));
  EXPECT_THAT(error.message, HasSubstr(hash_of("those").hex()));
  EXPECT_FALSE(store.find(hash_of("these")) || store.find(hash_of("those")));
  EXPECT_EQ(files_below("uploads"), 0);
  EXPECT_EQ(error_of([&] { put(store, ""); }).code, ErrorCode::kInvalidRequest);
}

TEST_F(AssetStoreTest, AnAssetHasABoundAndUploadsTogetherToo) {
  config_.largest_bytes = 10;
  config_.budget_bytes = 15;
  AssetStore store(config_);
  EXPECT_EQ(error_of([&] { put(store, "12345678901"); }).code, ErrorCode::kTooLarge);
  const auto first = store.begin();
  first->take("1234567890");
  {
    const auto second = store.begin();
    EXPECT_EQ(error_of([&] { second->take("123456"); }).code, ErrorCode::kOverloaded);
  }
  EXPECT_NO_THROW(store.begin()->take("12345"));  // what the second had is free again
}

TEST_F(AssetStoreTest, TheLeastRecentlyUsedGoesWhenThereIsNoRoom) {
  config_.budget_bytes = 3 * 4096;
  AssetStore store(config_);
  for (const char* text : {"a", "b", "c"}) {
    put(store, text);
    later(std::chrono::seconds(1));
  }
  EXPECT_TRUE(store.find(hash_of("a")));
  later(std::chrono::seconds(1));
  put(store, "d");
  EXPECT_TRUE(store.find(hash_of("a")));
  EXPECT_FALSE(store.find(hash_of("b")));
  EXPECT_TRUE(store.find(hash_of("c")) && store.find(hash_of("d")));
  EXPECT_EQ(store.stats().assets, 3);
  EXPECT_EQ(store.stats().bytes, 3 * 4096);
}

TEST_F(AssetStoreTest, WhatIsInUseStays) {
  config_.budget_bytes = 4096;
  AssetStore store(config_);
  put(store, "used");
  auto body = store.open(hash_of("used"));
  ASSERT_NE(body, nullptr);
  EXPECT_EQ(body->read(0, 100), "used");
  EXPECT_EQ(error_of([&] { put(store, "other"); }).code, ErrorCode::kOverloaded);
  EXPECT_TRUE(store.find(hash_of("used")));
  body.reset();
  EXPECT_TRUE(put(store, "other").is_new);
  EXPECT_FALSE(store.find(hash_of("used")));
}

TEST_F(AssetStoreTest, WhatIsUnusedForLongGoes) {
  config_.ttl = std::chrono::hours(2);
  AssetStore store(config_);
  put(store, "forgotten");
  put(store, "asked for");
  later(std::chrono::minutes(90));
  EXPECT_TRUE(store.find(hash_of("asked for")));
  later(std::chrono::minutes(90));
  EXPECT_FALSE(store.find(hash_of("forgotten")));
  EXPECT_TRUE(store.find(hash_of("asked for")));
  EXPECT_FALSE(fs::exists(path_of(hash_of("forgotten"))));
  EXPECT_EQ(store.stats().assets, 1);
}

TEST_F(AssetStoreTest, ADamagedFileIsSetAsideAndMayComeAgain) {
  AssetStore store(config_);
  for (const char* damage : {"tampered", "cut", ""}) {
    put(store, "original");
    std::ofstream(path_of(hash_of("original")), std::ios::trunc) << damage;
    EXPECT_FALSE(store.read(hash_of("original"))) << damage;
    EXPECT_FALSE(store.find(hash_of("original")));
    EXPECT_EQ(files_below("damaged"), 1);
    EXPECT_TRUE(put(store, "original").is_new);
    std::ofstream(path_of(hash_of("original")), std::ios::trunc) << damage;
    EXPECT_EQ(store.open(hash_of("original")), nullptr) << damage;
  }
  put(store, "original");
  EXPECT_EQ(store.read(hash_of("original"))->text(), "original");
}

TEST_F(AssetStoreTest, OnlyWhatADeadProcessLeftIsRemovedAtTheStart) {
  AssetStore store(config_);
  put(store, "kept");
  const auto living = store.begin();
  living->take("half");
  std::ofstream(config_.folder / "uploads" / "1-1.part") << "left";
  std::ofstream(path_of(hash_of("gone")).parent_path().replace_filename("00") += ".about") << "widow";
  EXPECT_EQ(files_below("uploads"), 2);
  AssetStore next(config_);
  EXPECT_EQ(files_below("uploads"), 1);
  EXPECT_TRUE(next.find(hash_of("kept")));
  EXPECT_TRUE(store.keep(*living, hash_of("half"), {}).is_new);
  EXPECT_EQ(AssetStore(config_).stats().assets, 2);
}

TEST_F(AssetStoreTest, ErasesOnce) {
  AssetStore store(config_);
  put(store, "x");
  EXPECT_TRUE(store.erase(hash_of("x")));
  EXPECT_FALSE(store.erase(hash_of("x")));
  EXPECT_FALSE(store.read(hash_of("x")));
  EXPECT_EQ(store.stats().assets, 0);
}

TEST_F(AssetStoreTest, ADiskThatRefusesIsAStorageProblem) {
  std::ofstream(config_.folder) << "a file where the folder should be";
  AssetStore store(config_);
  EXPECT_EQ(error_of([&] { put(store, "x"); }).code, ErrorCode::kStorage);
  EXPECT_FALSE(store.find(hash_of("x")));
  EXPECT_EQ(error_of([] { AssetStore(AssetStoreConfig{}).begin(); }).code, ErrorCode::kStorage);
}

TEST(AssetId, IsStrict) {
  const std::string hex = hash_of("x").hex();
  EXPECT_EQ(parse_asset_id("sha256-" + hex), hash_of("x"));
  for (const std::string& wrong :
       {hex, "sha256-" + hex + "0", std::string("sha256-"), "sha256-G" + hex.substr(1), "SHA256-" + hex})
    EXPECT_THROW(parse_asset_id(wrong), Error) << wrong;
}

TEST_F(AssetStoreTest, AnOwnersAssetsKeepWithinItsQuota) {
  const auto put_for = [](AssetStore& store, std::string_view text, std::int64_t quota_bytes) {
    const auto upload = store.begin();
    upload->take(text);
    return store.keep(*upload, std::nullopt, {}, {"anna", quota_bytes});
  };
  {
    AssetStore store(config_);
    put_for(store, "first", 0);
    put(store, "of nobody");
  }
  AssetStore store(config_);
  EXPECT_EQ(store.find(hash_of("first"))->owner, "anna");
  put_for(store, "second", 3 * 4096);
  put_for(store, "third", 3 * 4096);
  const Error full = error_of([&] { put_for(store, "fourth", 3 * 4096); });
  EXPECT_EQ(full.code, ErrorCode::kTooLarge);
  EXPECT_THAT(full.message, HasSubstr("may have 12288 bytes together and have 12288"));
  EXPECT_FALSE(put_for(store, "second", 3 * 4096).is_new) << "what is there already costs nothing";
  EXPECT_TRUE(store.erase(hash_of("first")));
  EXPECT_TRUE(put_for(store, "fourth", 3 * 4096).is_new);
}

TEST_F(AssetStoreTest, OneClientCannotTakeAllPlacesForWhatIsIncomplete) {
  AssetStore store(config_);
  const auto begin = [&](int number, std::string client) {
    return store.resume({hash_of(std::to_string(number)), std::move(client)}, {0, 1, 10});
  };
  for (int i = 0; i < 100; ++i) ASSERT_NE(begin(i, "anna"), nullptr);
  EXPECT_EQ(error_of([&] { begin(100, "anna"); }).code, ErrorCode::kOverloaded);
  EXPECT_NE(begin(99, "anna"), nullptr) << "what was begun goes on";
  EXPECT_NE(begin(100, "berta"), nullptr);
}

TEST_F(AssetStoreTest, WhatIsIncompleteIsBoundedAndForgotten) {
  config_.budget_bytes = 10'000;
  config_.largest_bytes = 10'000;
  config_.partial_ttl = std::chrono::hours(1);
  now_ = Time::clock::now();
  const auto send = [](AssetStore& store, std::string_view whole, std::string client, std::int64_t end) {
    const PartialUploads::Id id{hash_of(whole), std::move(client)};
    const std::int64_t first = store.received(id);
    const auto upload = store.resume(id, {first, end, std::int64_t(whole.size())});
    ASSERT_NE(upload, nullptr);
    upload->take(whole.substr(std::size_t(first), std::size_t(end - first)));
    EXPECT_EQ(store.keep_when_whole(*upload, id.hash, {}).has_value(), end == std::int64_t(whole.size()));
  };
  const std::string whole(4000, 'x');
  {
    AssetStore store(config_);
    send(store, whole, "anna", 3000);
    send(store, whole, "berta", 2000);
    EXPECT_EQ(store.received({hash_of(whole), "anna"}), 3000);
    EXPECT_EQ(store.received({hash_of(whole), "berta"}), 2000);
    EXPECT_EQ(error_of([&] {
                store.resume({hash_of("?"), "carla"}, {0, 6000, 6000});
              }).code,
              ErrorCode::kOverloaded);
  }
  AssetStore store(config_);
  send(store, whole, "anna", 4000);
  EXPECT_TRUE(store.read(hash_of(whole)));
  EXPECT_EQ(files_below("partial"), 1);
  now_ += std::chrono::hours(2);
  EXPECT_NE(store.resume({hash_of("?"), "carla"}, {0, 6000, 6000}), nullptr);
  EXPECT_EQ(store.received({hash_of(whole), "berta"}), 0);
}

}  // namespace
}  // namespace furnace
