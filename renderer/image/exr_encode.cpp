#include "renderer/image/encode.hpp"
#include "renderer/image/exr_streams.hpp"
#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <string>

namespace furnace {
namespace {

Imf::Compression imf_compression(ExrCompression compression) {
  switch (compression) {
    case ExrCompression::kNone:
      return Imf::NO_COMPRESSION;
    case ExrCompression::kZip:
      return Imf::ZIP_COMPRESSION;
    case ExrCompression::kPiz:
      return Imf::PIZ_COMPRESSION;
    case ExrCompression::kDwaa:
      return Imf::DWAA_COMPRESSION;
  }
  return Imf::NO_COMPRESSION;
}

Imf::PixelType pixel_type(const Image& image) {
  FURNACE_CHECK(image.type == SampleType::kFloat16 || image.type == SampleType::kFloat32,
                "an OpenEXR of sample type {}", static_cast<int>(image.type));
  return image.type == SampleType::kFloat16 ? Imf::HALF : Imf::FLOAT;
}

// Channels `prefix` + letter of an image, in a file's header and as where its pixels come from.
void add_channels(const Image& image, const std::string& prefix, std::string_view letters,
                  Imf::Header& header, Imf::FrameBuffer& frame) {
  const Imf::PixelType type = pixel_type(image);
  const std::size_t sample = sample_bytes(image.type), pixel = sample * letters.size();
  FURNACE_CHECK(letters.size() == static_cast<std::size_t>(image.channels), "{} channels {}", image.channels,
                letters);
  for (std::size_t channel = 0; channel < letters.size(); ++channel) {
    const std::string name = prefix + letters[channel];
    header.channels().insert(name, Imf::Channel(type));
    // OpenEXR's slices serve reading too, hence not const.
    char* const base =
        const_cast<char*>(reinterpret_cast<const char*>(image.pixels.data())) + channel * sample;
    frame.insert(name, Imf::Slice(type, base, pixel, image.row_bytes()));
  }
}

}  // namespace

std::string encode_exr(const Image& image, const std::vector<TextField>& metadata,
                       std::optional<ExrCompression> compression) {
  // Both lossless. PIZ writes halves twice as fast as ZIP and smaller; on noisy floats it is twice as slow.
  const bool is_half = pixel_type(image) == Imf::HALF;
  return encode_exr_layers(image, {}, metadata,
                           compression.value_or(is_half ? ExrCompression::kPiz : ExrCompression::kZip));
}

std::string encode_exr_layers(const Image& image, const std::vector<ImageLayer>& layers,
                              const std::vector<TextField>& metadata,
                              std::optional<ExrCompression> compression) {
  static constexpr std::string_view kLetters[] = {"Y", "YA", "RGB", "RGBA"};
  try {
    Imf::Header header(image.extent.width, image.extent.height);
    header.compression() = imf_compression(compression.value_or(ExrCompression::kZip));
    header.zipCompressionLevel() = 1;
    Imf::addChromaticities(header, Imf::Chromaticities());  // OpenEXR's defaults are those of Rec.709
    Imf::FrameBuffer frame;
    add_channels(image, "", kLetters[image.channels - 1], header, frame);
    std::size_t bytes = image.byte_size();
    for (const ImageLayer& layer : layers) {
      FURNACE_CHECK(layer.image.extent == image.extent, "a layer of {} px beside a picture of {}",
                    layer.image.extent.width, image.extent.width);
      add_channels(layer.image, layer.name + ".", layer.channels, header, frame);
      bytes += layer.image.byte_size();
    }
    for (const TextField& field : metadata) header.insert(field.key, Imf::StringAttribute(field.value));

    ExrSink stream(bytes);
    {
      constexpr int kNoThreads = 0;
      Imf::OutputFile file(stream, header, kNoThreads);
      file.setFrameBuffer(frame);
      file.writePixels(image.extent.height);
    }  // writes the table of chunks
    return stream.take();
  } catch (const std::exception& error) {
    fail(ErrorCode::kInternal, "the picture could not be written as OpenEXR", {}, error.what());
  }
}

}  // namespace furnace
