// Nothing that comes over the wire is believed.
#include <functional>
#include <limits>
#include <random>

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
  EXPECT_TRUE(job.accepts(good));
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
    EXPECT_FALSE(job.accepts(image)) << &lie - lies;
  }
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
  const TextureJob job{ColorSpace::kSrgb, {100, 50}};
  EXPECT_EQ(job.largest_result_bytes(), 50 * 8);
  EXPECT_EQ((TextureJob{ColorSpace::kSrgb, {5, 50}}.largest_result_bytes()), 25 * 8);
  EXPECT_EQ((EnvironmentJob{{100, 50}}.largest_result_bytes()), 50 * 12);
}

}  // namespace
}  // namespace furnace::decode
