// Requests with all that they refer to, and the word on what drew them.
#include "api/bundle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/api/request_fixture.hpp"
#include "renderer/base/error.hpp"

namespace furnace::api {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

SelfContained packed(const std::string& document, const std::map<std::string, Blob>& files) {
  FileAssets none({}, 0, 0);
  AssetResolver assets(none, files, {});
  std::vector<ReadReference> reads;
  assets.record(reads);
  const RenderSpec spec = parse_render_request(document, assets, generous_limits(), OutputFormat::kWebp);
  return self_contained(document, reads, spec.output);
}

RenderSpec unpacked(const SelfContained& request) {
  FileAssets none({}, 0, 0);
  return parse_render_request(request.document, AssetResolver(none, request.parts, {}), generous_limits());
}

const std::string kPng("\x89PNG\r\n\x1a\n", 8);
const Blob kChair(R"({"asset":{"version":"2.0"},"images":[{"uri":"my%20oak.png"},{"uri":"a/b~.png"}]})");

TEST(Bundle, MeansWhatTheRequestMeant) {
  const std::map<std::string, Blob> files = {{"chair.gltf", kChair},
                                             {"my oak.png", Blob(kPng + "oak")},
                                             {"a/b~.png", Blob(kPng + "b")},
                                             {"sky", Blob("#?RADIANCE\n")}};
  const std::string document =
      R"({"scene":{"model":"part:chair.gltf","files":{"a/b~.png":"part:my oak.png"},
      "materials":{"m":{"textures":{"baseColor":"part:a/b~.png"}}}},"environment":{"map":"part:sky"}})";
  const SelfContained bundle = packed(document, files);
  EXPECT_EQ(bundle.parts.size(), 4u) << "each file once";
  FileAssets none({}, 0, 0);
  const RenderSpec meant =
      parse_render_request(document, AssetResolver(none, files, {}), generous_limits(), OutputFormat::kWebp);
  EXPECT_EQ(spec_hash(unpacked(bundle)).hex(), spec_hash(meant).hex());
  EXPECT_THAT(bundle.document, HasSubstr(R"("format": "webp")"));
}

TEST(Bundle, OfNothingIsTheDefaultPicture) {
  for (const char* document : {"{}", R"({"scene":{"model":"builtin:cube"}})"}) {
    const SelfContained bundle = packed(document, {});
    EXPECT_TRUE(bundle.parts.empty());
    EXPECT_EQ(unpacked(bundle).output.format, OutputFormat::kWebp);
  }
}

TEST(Bundle, NamesArePlain) {
  const SelfContained bundle =
      packed(R"({"environment":{"map":"part:../ü b.hdr"}})", {{"../ü b.hdr", Blob("#?RADIANCE\n")}});
  EXPECT_THAT(bundle.parts, ElementsAre(Pair("1-___b.hdr", ::testing::_)));
}

TEST(Bundle, SaysWhatDrewIt) {
  const BundleAbout about = parse_bundle_json(bundle_json({"0.1.0; \"x\"", true, "ab", "picture.png", "cd"}));
  EXPECT_EQ(about.fingerprint, "0.1.0; \"x\"");
  EXPECT_TRUE(about.is_exact);
  EXPECT_EQ(about.picture, "picture.png");
  EXPECT_EQ(about.sha256, "cd");
}

TEST(Bundle, GarbageIsRefused) {
  std::mt19937 random(3);
  const std::string good = bundle_json({"f", false, "ab", "picture.png", "cd"});
  for (int i = 0; i < 3000; ++i) {
    std::string text = good;
    for (auto changes = random() % 6; changes > 0; --changes)
      text[random() % text.size()] = static_cast<char>(random());
    text.resize(random() % (text.size() + 1));
    try {
      parse_bundle_json(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    }
  }
}

}  // namespace
}  // namespace furnace::api
