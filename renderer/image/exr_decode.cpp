#include "renderer/image/codecs.hpp"
#include "renderer/image/exr_claims.hpp"
#include "renderer/image/exr_streams.hpp"
#include "renderer/base/error.hpp"

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "OpenEXR file";

struct Selection {
  int part = 0;
  bool is_luminance = false;
};

// The first part with R, G and B, or with Y alone.
Selection select_part(const std::vector<ExrPart>& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const ExrPart& part = parts[i];
    const bool is_rgb = part.has("R") && part.has("G") && part.has("B");
    if (!is_rgb && !part.has("Y")) continue;
    if (!is_rgb && (part.has("RY") || part.has("BY"))) {
      fail(ErrorCode::kUnsupportedMedia,
           "the OpenEXR file stores luminance and chroma; save it as RGB first");
    }
    const auto is_used = [&](const ExrChannel& channel) {
      return is_rgb ? channel.name == "R" || channel.name == "G" || channel.name == "B" : channel.name == "Y";
    };
    for (const ExrChannel& channel : part.channels) {
      if (is_used(channel) && channel.is_subsampled) {
        fail(ErrorCode::kUnsupportedMedia, "the OpenEXR file has subsampled channels; save it as RGB first");
      }
    }
    return {static_cast<int>(i), !is_rgb};
  }
  fail(ErrorCode::kUnsupportedMedia, "no part of the OpenEXR file has the channels R, G and B, or Y");
}

// Row by row: the data window may begin and end anywhere, the image is the display window. What the data
// window leaves out stays black.
void read_pixels(std::span<const std::byte> file, const ExrPart& part, const Selection& selection,
                 Image& image) {
  ExrSource stream(file);
  constexpr int kNoThreads = 0;
  constexpr bool kMendTable = false;
  Imf::MultiPartInputFile input(stream, kNoThreads, kMendTable);
  Imf::InputPart pixels(input, selection.part);

  const ExrWindow& data = part.data_window;
  const ExrWindow& display = part.display_window;
  std::vector<float> row(static_cast<std::size_t>(data.width()) * 3);
  Imf::FrameBuffer frame;
  const auto add_channel = [&](const char* name, std::size_t offset) {
    constexpr std::size_t kPixel = 3 * sizeof(float);
    // OpenEXR adds x * stride to the base; the base itself may lie outside of the row.
    char* const base =
        reinterpret_cast<char*>(row.data() + offset) - std::int64_t{data.min_x} * std::int64_t{kPixel};
    frame.insert(name, Imf::Slice(Imf::FLOAT, base, kPixel, 0));
  };
  if (selection.is_luminance) {
    add_channel("Y", 0);
  } else {
    add_channel("R", 0);
    add_channel("G", 1);
    add_channel("B", 2);
  }
  pixels.setFrameBuffer(frame);

  const std::int32_t begin_x = std::max(data.min_x, display.min_x),
                     end_x = std::min(data.max_x, display.max_x) + 1;
  const std::int32_t begin_y = std::max(data.min_y, display.min_y),
                     end_y = std::min(data.max_y, display.max_y) + 1;
  if (begin_x >= end_x || begin_y >= end_y)
    fail_damaged(kFormat, "its data lie outside of its display window");
  for (std::int32_t y = begin_y; y < end_y; ++y) {
    pixels.readPixels(y);
    if (selection.is_luminance) {
      for (std::size_t i = 0; i < row.size(); i += 3) row[i + 1] = row[i + 2] = row[i];
    }
    const float* const in = row.data() + std::size_t(begin_x - data.min_x) * 3;
    const std::size_t place =
        static_cast<std::size_t>(y - display.min_y) * static_cast<std::size_t>(image.extent.width) +
        static_cast<std::size_t>(begin_x - display.min_x);
    std::copy_n(in, static_cast<std::size_t>(end_x - begin_x) * 3, image.samples<float>().data() + place * 3);
  }
}

}  // namespace

Image decode_exr(std::span<const std::byte> file, const DecodeLimits& limits, Shape shape) {
  const std::vector<ExrPart> parts = read_exr_claims(file, limits);
  const Selection selection = select_part(parts);
  const ExrPart& part = parts[static_cast<std::size_t>(selection.part)];
  const ExrWindow& display = part.display_window;
  check_extent(kFormat, display.width(), display.height(), limits, shape);
  Image image = make_image({static_cast<int>(display.width()), static_cast<int>(display.height())}, 3,
                           SampleType::kFloat32, ColorSpace::kLinear);
  try {
    read_pixels(file, part, selection, image);
  } catch (const std::exception& error) {
    fail_damaged(kFormat, error.what());
  }
  return image;
}

}  // namespace furnace
