#include "renderer/image/exr_parts.hpp"
#include "renderer/image/codecs.hpp"
#include "renderer/image/exr_claims.hpp"
#include "renderer/image/exr_streams.hpp"
#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "OpenEXR file";
constexpr const char* kChannels[] = {"R", "G", "B", "A"};
constexpr std::size_t kSampleBytes = 2, kPixelBytes = 8;
constexpr int kNoThreads = 0;
// Measured on a bake of 20 MB, with checksum and a warm disk: it loads in 63 ms, against 160 with PIZ (7.0 MB) and 346 with
// ZIP (7.4 MB); it saves in 80 ms, against 364 and 1272.
constexpr Imf::Compression kCompression = Imf::NO_COMPRESSION;

Imf::FrameBuffer frame_of(const Image& image) {
  Imf::FrameBuffer frame;
  // OpenEXR's slices serve reading and writing, hence not const.
  char* const base = const_cast<char*>(reinterpret_cast<const char*>(image.pixels.data()));
  for (std::size_t i = 0; i < std::size(kChannels); ++i) {
    frame.insert(kChannels[i],
                 Imf::Slice(Imf::HALF, base + i * kSampleBytes, kPixelBytes, image.row_bytes()));
  }
  return frame;
}

// The format wants one display window for all parts: the first part's.
Imf::Header header_of(const NamedImage& part, const Extent& display) {
  const Extent& extent = part.image->extent;
  const auto window = [](const Extent& size) {
    return Imath::Box2i({0, 0}, {size.width - 1, size.height - 1});
  };
  Imf::Header header(window(display), window(extent));
  header.compression() = kCompression;
  header.setName(std::string(part.name));
  header.setType(Imf::SCANLINEIMAGE);
  for (const char* channel : kChannels) header.channels().insert(channel, Imf::Channel(Imf::HALF));
  return header;
}

// Stricter than the format: what we did not write is not ours to read.
void check_claims(const std::vector<ExrPart>& parts, std::size_t file_bytes) {
  std::uint64_t pixel_bytes = 0;
  for (const ExrPart& part : parts) {
    const bool is_plain = !part.is_tiled && part.compression == kCompression && part.data_window.min_x == 0 &&
                          part.data_window.min_y == 0 && part.channels.size() == std::size(kChannels);
    if (!is_plain) fail_damaged(kFormat, "a part is not of our making");
    for (const ExrChannel& channel : part.channels) {
      if (channel.sample_bytes != std::int64_t(kSampleBytes) || channel.is_subsampled) {
        fail_damaged(kFormat, "a channel is not of our making");
      }
    }
    for (const char* channel : kChannels) {
      if (!part.has(channel)) fail_damaged(kFormat, "a channel is missing");
    }
    pixel_bytes +=
        std::uint64_t(part.data_window.width()) * std::uint64_t(part.data_window.height()) * kPixelBytes;
    if (pixel_bytes > file_bytes) fail_damaged(kFormat, "it ends before its last pixel");
  }
}

ExrParts read_parts(std::span<const std::byte> file, const std::vector<ExrPart>& claims) {
  ExrSource stream(file);
  constexpr bool kMendTable = false;
  Imf::MultiPartInputFile input(stream, kNoThreads, kMendTable);
  if (input.parts() != int(claims.size())) fail_damaged(kFormat, "its parts cannot be counted");

  ExrParts out;
  for (int i = 0; i < input.parts(); ++i) {
    const Imf::Header& header = input.header(i);
    const ExrWindow& window = claims[std::size_t(i)].data_window;
    if (header.dataWindow() != Imath::Box2i({0, 0}, {window.max_x, window.max_y}) || !header.hasName()) {
      fail_damaged(kFormat, "its header says two things");
    }
    Image image =
        make_image({int(window.width()), int(window.height())}, 4, SampleType::kFloat16, ColorSpace::kLinear);
    Imf::InputPart part(input, i);
    part.setFrameBuffer(frame_of(image));
    part.readPixels(0, window.max_y);
    if (!out.images.emplace(header.name(), std::move(image)).second) {
      fail_damaged(kFormat, "two parts have one name");
    }
  }
  const Imf::Header& first = input.header(0);
  for (auto entry = first.begin(); entry != first.end(); ++entry) {
    const bool is_formats =
        std::string_view("name") == entry.name() || std::string_view("type") == entry.name();
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&entry.attribute());
    if (text && !is_formats) out.attributes.emplace(entry.name(), text->value());
  }
  return out;
}

}  // namespace

std::string encode_exr_parts(std::span<const NamedImage> parts, const std::vector<TextField>& attributes) {
  FURNACE_CHECK(!parts.empty(), "an OpenEXR file of no parts");
  std::size_t pixel_bytes = 0;
  for (const NamedImage& part : parts) {
    FURNACE_CHECK(part.image->type == SampleType::kFloat16 && part.image->channels == 4,
                  "a part of {} channels of sample type {}", part.image->channels,
                  static_cast<int>(part.image->type));
    pixel_bytes += part.image->byte_size();
  }
  try {
    std::vector<Imf::Header> headers;
    for (const NamedImage& part : parts) headers.push_back(header_of(part, parts.front().image->extent));
    for (const TextField& field : attributes) {
      headers.front().insert(field.key, Imf::StringAttribute(field.value));
    }
    ExrSink stream(pixel_bytes + pixel_bytes / 16 + 65536);
    {
      constexpr bool kOverrideShared = false;
      Imf::MultiPartOutputFile file(stream, headers.data(), int(headers.size()), kOverrideShared, kNoThreads);
      for (std::size_t i = 0; i < parts.size(); ++i) {
        Imf::OutputPart part(file, int(i));
        part.setFrameBuffer(frame_of(*parts[i].image));
        part.writePixels(parts[i].image->extent.height);
      }
    }  // writes the tables of chunks
    return stream.take();
  } catch (const std::exception& error) {
    fail(ErrorCode::kInternal, "the parts could not be written as OpenEXR", {}, error.what());
  }
}

ExrParts decode_exr_parts(std::span<const std::byte> file, const DecodeLimits& limits) {
  if (sniff_image_format(file) != ImageFormat::kExr) {
    fail(ErrorCode::kUnsupportedMedia, "the file is not OpenEXR");
  }
  const std::vector<ExrPart> claims = read_exr_claims(file, limits);
  check_claims(claims, file.size());
  try {
    return read_parts(file, claims);
  } catch (const std::bad_alloc&) {
    throw;  // says nothing about the file
  } catch (const std::exception& error) {
    fail_damaged(kFormat, error.what());
  }
}

}  // namespace furnace
