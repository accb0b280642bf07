// Nothing that comes over the wire is believed.
#include <functional>
#include <limits>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "renderer/decode/channel.hpp"
#include "renderer/decode/messages.hpp"

namespace furnace::decode {
namespace {

constexpr std::size_t kBlockBytes = 4096;

// A value on its way: what is said, and the memory for its arrays.
struct Sent {
  Descriptor block = empty_block(kBlockBytes);
  std::string bytes;
  bool fits = false;
};

template <class Value>
Sent send(const Value& value) {
  Sent sent;
  const Mapping block(sent.block.get(), kBlockBytes, Mapping::Access::kWrite);
  WireWriter writer(block.bytes());
  fields(writer, value);
  sent.bytes = writer.bytes();
  sent.fits = writer.fits();
  return sent;
}

Image small_image() {
  Image image = make_image({4, 2}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  for (float& sample : image.samples<float>()) sample = 0.5f;
  return image;
}

TEST(Wire, ValuesComeBack) {
  DecodedEnvironment said{small_image(), {1, 2, 3}};
  const Sent sent = send(said);
  ASSERT_TRUE(sent.fits);
  WireReader reader(sent.bytes, sent.block.get(), kBlockBytes);
  DecodedEnvironment heard;
  fields(reader, heard);
  EXPECT_TRUE(reader.ended_well());
  EXPECT_EQ(heard.equirect.extent, said.equirect.extent);
  EXPECT_TRUE(heard.equirect.pixels == said.equirect.pixels);
  EXPECT_EQ(heard.repairs, said.repairs);
  EXPECT_TRUE((EnvironmentJob{{8, 64}}.accepts(heard)));
}

TEST(Wire, ArraysThatDoNotFitAreNotWritten) {
  Image image = make_image({64, 64}, 4, SampleType::kUint8, ColorSpace::kSrgb);
  EXPECT_FALSE(send(image).fits);
}

TEST(Wire, TextsAreCutAtTheirLimit) {
  WireWriter writer;
  writer.text(std::string(100, 'x'), 10);
  std::string heard;
  WireReader reader(writer.bytes());
  reader.text(heard, 10);
  EXPECT_TRUE(reader.ended_well());
  EXPECT_EQ(heard, std::string(10, 'x'));
  WireReader strict(writer.bytes());
  strict.text(heard, 9);
  EXPECT_FALSE(strict.ended_well());
  EXPECT_EQ(heard, "");
}

// Whatever is cut off, added or turned over: an unsound reader, or a value that was checked.
TEST(Wire, NoiseIsNeverAccepted) {
  const EnvironmentJob job{{8, 64}};
  const Sent sent = send(DecodedEnvironment{small_image(), {}});
  const auto judge = [&](const std::string& bytes) {
    WireReader reader(bytes, sent.block.get(), kBlockBytes);
    DecodedEnvironment heard;
    fields(reader, heard);
    const bool accepted = job.accepts(heard) && reader.ended_well();
    if (accepted) {
      EXPECT_EQ(heard.equirect.pixels.size(), std::size_t(heard.equirect.extent.area()) * 12);
      EXPECT_LE(heard.equirect.extent.width, 8);
    }
    return accepted;
  };
  EXPECT_TRUE(judge(sent.bytes));
  EXPECT_FALSE(judge(sent.bytes + '\0'));
  for (std::size_t size = 0; size < sent.bytes.size(); ++size)
    EXPECT_FALSE(judge(sent.bytes.substr(0, size)));
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes = sent.bytes;
    for (int flips = 1 + int(random() % 4); flips > 0; --flips)
      bytes[random() % bytes.size()] = char(random());
    judge(bytes);
  }
  Reply reply;
  Error error;
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes(random() % 64, '\0');
    for (char& byte : bytes) byte = char(random() % (random() % 2 == 0 ? 256 : 4));
    WireReader reader(bytes);
    fields(reader, reply);
    fields(reader, error);
    EXPECT_LE(error.message.size(), bytes.size());
  }
}

TEST(Jobs, ATextureMustBeWhatWasAskedFor) {
  const TextureJob job{ColorSpace::kSrgb, {16, 64}};
  const Image good = make_image({8, 4}, 4, SampleType::kUint16, ColorSpace::kSrgb);
  EXPECT_TRUE(job.accepts({{good}, {}}));
  EXPECT_FALSE(job.accepts({}));
  const std::function<void(Image&)> lies[] = {
      [](Image& image) { image.extent.width = 0; },
      [](Image& image) {
        image.extent = {-8, -4};
      },
      [](Image& image) {
        image.extent = {17, 1};
      },
      [](Image& image) {
        image = make_image({16, 8}, 4, SampleType::kUint16, ColorSpace::kSrgb);
      },
      [](Image& image) { image.channels = 0; },
      [](Image& image) { image.channels = 5; },
      [](Image& image) { image.channels = 3; },
      [](Image& image) { image.type = SampleType::kFloat16; },
      [](Image& image) { image.color_space = ColorSpace::kLinear; },
      [](Image& image) { image.pixels.pop_back(); },
      [](Image& image) { image.pixels.emplace_back(); },
  };
  for (const auto& lie : lies) {
    Image image = good;
    lie(image);
    EXPECT_FALSE(job.accepts({{image}, {}})) << &lie - lies;
  }
}

// Each level half of the one above, and what is told is text.
TEST(Jobs, ATextureMustBeAChain) {
  const TextureJob job{ColorSpace::kSrgb, {16, 64}};
  const auto level = [](Extent extent) {
    return make_image(extent, 4, SampleType::kUint8, ColorSpace::kSrgb);
  };
  const DecodedTexture good{{level({7, 2}), level({3, 1}), level({1, 1})}, {{"a-code", "a remark"}}};
  EXPECT_TRUE(job.accepts(good));
  const std::function<void(DecodedTexture&)> lies[] = {
      [&](DecodedTexture& texture) {
        texture.levels.push_back(level({1, 1}));
      },
      [&](DecodedTexture& texture) {
        texture.levels[1] = level({4, 1});
      },
      [&](DecodedTexture& texture) {
        texture.levels[1] = level({3, 2});
      },
      [&](DecodedTexture& texture) { texture.levels[2].extent.height = 0; },
      [](DecodedTexture& texture) { texture.levels[2].pixels.pop_back(); },
      [](DecodedTexture& texture) { texture.levels[2].color_space = ColorSpace::kNonColor; },
      [](DecodedTexture& texture) {
        texture.levels[1] = make_image({3, 1}, 3, SampleType::kUint8, ColorSpace::kSrgb);
      },
      [](DecodedTexture& texture) {
        texture.levels[1] = make_image({3, 1}, 4, SampleType::kUint16, ColorSpace::kSrgb);
      },
      [](DecodedTexture& texture) { texture.remarks[0].code = ""; },
      [](DecodedTexture& texture) { texture.remarks[0].code = "a\ncode"; },
      [](DecodedTexture& texture) { texture.remarks[0].message = "\xff"; },
      [](DecodedTexture& texture) { texture.remarks.push_back({}); },
  };
  for (const auto& lie : lies) {
    DecodedTexture texture = good;
    lie(texture);
    EXPECT_FALSE(job.accepts(texture)) << &lie - lies;
  }
}

TEST(Wire, ListsAreBounded) {
  DecodedTexture many{{make_image({1, 1}, 4, SampleType::kUint8, ColorSpace::kSrgb)}, {}};
  many.remarks.resize(kMostRemarks, {std::string(1000, 'c'), std::string(1000, 'm')});
  const Sent sent = send(many);
  ASSERT_TRUE(sent.fits);
  EXPECT_LT(sent.bytes.size(), kMostMessageBytes / 2);
  DecodedTexture heard;
  WireReader reader(sent.bytes, sent.block.get(), kBlockBytes);
  fields(reader, heard);
  ASSERT_TRUE(reader.ended_well());
  ASSERT_EQ(heard.remarks.size(), kMostRemarks);
  EXPECT_EQ(heard.remarks.back().code, std::string(kMostCodeBytes, 'c'));
  EXPECT_EQ(heard.remarks.back().message, std::string(kMostRemarkBytes, 'm'));
  many.remarks.emplace_back();
  EXPECT_FALSE(send(many).fits);

  for (const std::uint32_t claim : {std::uint32_t(kMostLevels), std::uint32_t(kMostLevels) + 1, ~0u}) {
    WireWriter writer;
    writer.number(claim);
    WireReader liar(writer.bytes());
    fields(liar, heard);
    EXPECT_FALSE(liar.ended_well());
    EXPECT_LE(heard.levels.size(), kMostLevels);
  }
}

// As above, of every kind of answer.
template <class Job>
void expect_noise_is_judged(const Job& job, const typename Job::Result& good) {
  const Sent sent = send(good);
  ASSERT_TRUE(sent.fits);
  std::mt19937 random(2);
  int accepted = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes = sent.bytes;
    if (i > 0) bytes[random() % bytes.size()] = char(random() % (i % 2 == 0 ? 256 : 4));
    if (i % 5 == 4) bytes.resize(random() % bytes.size());
    WireReader reader(bytes, sent.block.get(), kBlockBytes);
    typename Job::Result heard;
    fields(reader, heard);
    accepted += job.accepts(heard) && reader.ended_well();
    if (i == 0) {
      EXPECT_EQ(accepted, 1);
    }
  }
  EXPECT_LT(accepted, 20'000);
}

TEST(Wire, NoiseIsJudged) {
  const auto level = [](Extent extent) {
    return make_image(extent, 4, SampleType::kUint8, ColorSpace::kSrgb);
  };
  expect_noise_is_judged(TextureJob{ColorSpace::kSrgb, {16, 64}},
                         {{level({4, 2}), level({2, 1})}, {{"code", "message"}}});
  DracoRequest request;
  request.attributes = {{0, DracoComponent::kFloat, 3}, {7, DracoComponent::kUnsignedShort, 4}};
  request.vertices = 4;
  request.most_triangles = 2;
  expect_noise_is_judged(
      DracoJob{request},
      {{0, 1, 2, 2, 1, 3}, {std::vector<std::byte>(4 * 12), std::vector<std::byte>(4 * 8)}});
  expect_noise_is_judged(MeshoptJob{{MeshoptMode::kAttributes, MeshoptFilter::kNone, 5, 8}},
                         {std::vector<std::byte>(40)});
}

TEST(Jobs, AnEnvironmentMustBeLight) {
  const EnvironmentJob job{{8, 64}};
  const DecodedEnvironment good{small_image(), {}};
  EXPECT_TRUE(job.accepts(good));
  DecodedEnvironment dark = good;
  dark.equirect.samples<float>()[0] = -0.0f;
  dark.equirect.samples<float>()[1] = std::numeric_limits<float>::max();
  EXPECT_TRUE(job.accepts(dark));
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -1.0f, -std::numeric_limits<float>::min()}) {
    DecodedEnvironment environment = good;
    environment.equirect.samples<float>()[23] = value;
    EXPECT_FALSE(job.accepts(environment)) << value;
  }
  const std::function<void(DecodedEnvironment&)> lies[] = {
      [](DecodedEnvironment& e) {
        e.equirect.extent = {2, 4};
      },
      [](DecodedEnvironment& e) { e.equirect.channels = 4; },
      [](DecodedEnvironment& e) { e.equirect.type = SampleType::kUint8; },
      [](DecodedEnvironment& e) { e.equirect.color_space = ColorSpace::kSrgb; },
      [](DecodedEnvironment& e) { e.repairs.nan_samples = -1; },
      [](DecodedEnvironment& e) { e.repairs.infinite_samples = 25; },
      [](DecodedEnvironment& e) { e.equirect.pixels.resize(12); },
  };
  for (const auto& lie : lies) {
    DecodedEnvironment environment = good;
    lie(environment);
    EXPECT_FALSE(job.accepts(environment)) << &lie - lies;
  }
}

TEST(Jobs, TheBlockHoldsTheLargestResult) {
  // Every chain of every size within the limits, and the gaps before its arrays.
  for (const auto& [side, area] :
       {std::pair{100, 50}, std::pair{5, 50}, std::pair{64, 4096}, std::pair{64, 1}, std::pair{1, 1}}) {
    const std::int64_t most = TextureJob{ColorSpace::kSrgb, {side, area}}.largest_result_bytes();
    EXPECT_LE(most, 8 * (area + area / 3 + 2 * side) + 64 * 31);
    for (int width = 1; width <= side; ++width) {
      std::int64_t bytes = 0;
      for (Extent level{width, std::min(side, area / width)}; level.height > 0;
           level = {std::max(level.width / 2, 1), std::max(level.height / 2, 1)}) {
        bytes = (bytes + 63) / 64 * 64 + level.area() * 8;
        if (level.area() == 1) break;
      }
      EXPECT_GE(most, bytes) << side << " " << area << " " << width;
    }
  }
  EXPECT_EQ((EnvironmentJob{{100, 50}}.largest_result_bytes()), 50 * 12);
}

}  // namespace
}  // namespace furnace::decode
