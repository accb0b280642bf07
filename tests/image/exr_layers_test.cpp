// Layers beside a picture, as OpenEXR itself reads them.
#include "renderer/image/encode.hpp"
#include "renderer/image/exr_streams.hpp"

#include <gtest/gtest.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <limits>
#include <set>

namespace furnace {
namespace {

Image floats(int channels, SampleType type, float first) {
  Image image = make_image({5, 3}, channels, type, ColorSpace::kLinear);
  for (std::size_t i = 0; i < 15 * std::size_t(channels); ++i) {
    if (type == SampleType::kFloat16)
      image.samples<std::uint16_t>()[i] = half_from_float(first + float(i));
    else
      image.samples<float>()[i] = first + float(i);
  }
  return image;
}

TEST(ExrLayers, StandAsChannelsOfOnePart) {
  std::vector<ImageLayer> layers = {{"depth", "Z", floats(1, SampleType::kFloat32, 1000.1f)},
                                    {"normal", "XYZ", floats(3, SampleType::kFloat16, 2)}};
  layers[0].image.samples<float>()[4] = std::numeric_limits<float>::infinity();
  const std::string file =
      encode_exr_layers(floats(3, SampleType::kFloat16, 1), layers, {{"cryptomatte/1234567/name", "x"}});
  ExrSource source(std::as_bytes(std::span(file)));
  Imf::InputFile input(source);
  const Imf::Header& header = input.header();
  EXPECT_EQ(header.compression(), Imf::ZIP_COMPRESSION);
  ASSERT_NE(header.findTypedAttribute<Imf::StringAttribute>("cryptomatte/1234567/name"), nullptr);

  const Imf::ChannelList& channels = header.channels();
  std::set<std::string> names, layer_names;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) names.insert(channel.name());
  EXPECT_EQ(names, (std::set<std::string>{"R", "G", "B", "depth.Z", "normal.X", "normal.Y", "normal.Z"}));
  channels.layers(layer_names);
  EXPECT_EQ(layer_names, (std::set<std::string>{"depth", "normal"}));
  EXPECT_EQ(channels["R"].type, Imf::HALF);
  EXPECT_EQ(channels["depth.Z"].type, Imf::FLOAT);
  EXPECT_EQ(channels["normal.Y"].type, Imf::HALF);

  std::vector<float> depth(15), normal_y(15), green(15);
  const Imath::Box2i window = header.dataWindow();
  Imf::FrameBuffer frame;
  frame.insert("depth.Z", Imf::Slice::Make(Imf::FLOAT, depth.data(), window));
  frame.insert("normal.Y", Imf::Slice::Make(Imf::FLOAT, normal_y.data(), window));
  frame.insert("G", Imf::Slice::Make(Imf::FLOAT, green.data(), window));
  input.setFrameBuffer(frame);
  input.readPixels(0, 2);
  for (std::size_t i = 0; i < 15; ++i) {
    EXPECT_EQ(depth[i], layers[0].image.samples<float>()[i]);
    EXPECT_EQ(normal_y[i], 2 + float(3 * i + 1));
    EXPECT_EQ(green[i], 1 + float(3 * i + 1));
  }
}

TEST(ExrLayers, WithoutAnyItIsThePictureAlone) {
  const Image image = floats(4, SampleType::kFloat32, 0);
  EXPECT_EQ(encode_exr_layers(image, {}, {}, ExrCompression::kPiz),
            encode_exr(image, {}, ExrCompression::kPiz));
}

}  // namespace
}  // namespace furnace
