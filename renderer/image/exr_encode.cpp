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

#include <cstring>
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

}  // namespace

std::string encode_exr(const Image& image, const std::vector<TextField>& metadata,
                       std::optional<ExrCompression> compression) {
  static constexpr const char* kNames[4][4] = {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
  const bool is_half = image.type == SampleType::kFloat16;
  FURNACE_CHECK(is_half || image.type == SampleType::kFloat32, "an OpenEXR of sample type {}",
                static_cast<int>(image.type));
  const Imf::PixelType type = is_half ? Imf::HALF : Imf::FLOAT;
  const std::size_t sample = sample_bytes(image.type),
                    pixel = sample * static_cast<std::size_t>(image.channels);
  try {
    Imf::Header header(image.extent.width, image.extent.height);
    // Both lossless. PIZ writes halves twice as fast as ZIP and smaller; on noisy floats it is twice as slow.
    header.compression() =
        imf_compression(compression.value_or(is_half ? ExrCompression::kPiz : ExrCompression::kZip));
    header.zipCompressionLevel() = 1;
    Imf::addChromaticities(header, Imf::Chromaticities());  // OpenEXR's defaults are those of Rec.709
    Imf::FrameBuffer frame;
    for (int channel = 0; channel < image.channels; ++channel) {
      const char* const name = kNames[image.channels - 1][channel];
      header.channels().insert(name, Imf::Channel(type));
      // OpenEXR's slices serve reading too, hence not const.
      char* const base = const_cast<char*>(reinterpret_cast<const char*>(image.pixels.data())) +
                         static_cast<std::size_t>(channel) * sample;
      frame.insert(name, Imf::Slice(type, base, pixel, image.row_bytes()));
    }
    for (const TextField& field : metadata) header.insert(field.key, Imf::StringAttribute(field.value));

    ExrSink stream(image.byte_size());
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
