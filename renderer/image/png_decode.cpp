// PNG (W3C Recommendation, second edition, 2003) over libdeflate: about twice as fast as libpng, whose
// inflate works in small steps, and textures are most of what a new model costs.
#include "renderer/image/codecs.hpp"
#include "renderer/image/png_filter.hpp"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <vector>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "PNG";

using Bytes = std::span<const std::uint8_t>;

std::uint32_t big_endian_32(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 |
         bytes[3];
}

std::uint16_t big_endian_16(const std::uint8_t* bytes) {
  return static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
}

enum ColorType : std::uint8_t { kGrey = 0, kRgb = 2, kPalette = 3, kGreyAlpha = 4, kRgba = 6 };

struct Header {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint8_t depth = 0;  // bits per stored sample
  std::uint8_t color_type = 0;
  bool interlaced = false;

  int stored_channels() const {
    switch (color_type) {
      case kRgb:
        return 3;
      case kGreyAlpha:
        return 2;
      case kRgba:
        return 4;
      default:
        return 1;
    }
  }
  std::size_t row_bytes(std::uint32_t columns) const {
    return (std::size_t{columns} * static_cast<std::size_t>(stored_channels()) * depth + 7) / 8;
  }
  // The distance at which filters look back.
  std::size_t filter_step() const {
    return std::max<std::size_t>(1, static_cast<std::size_t>(stored_channels()) * depth / 8);
  }
};

// What the chunks say.
struct Contents {
  Header header;
  std::array<std::array<std::uint8_t, 4>, 256> palette{};  // RGBA; black beyond its end
  std::size_t palette_size = 0;
  bool has_alpha = false;              // tRNS
  std::array<std::uint16_t, 3> key{};  // the transparent colour of grey and RGB
  bool pixels_have_begun = false;      // an IDAT was met
  std::vector<Bytes> compressed;       // IDAT
  std::size_t compressed_size = 0;
};

Header parse_header(Bytes data) {
  if (data.size() != 13) fail_damaged(kFormat, "its header has the wrong size");
  Header header{big_endian_32(&data[0]), big_endian_32(&data[4]), data[8], data[9], data[12] == 1};
  const bool is_power = std::has_single_bit(header.depth) && header.depth <= 16;
  const bool fits_type =
      header.color_type == kGrey      ? true
      : header.color_type == kPalette ? header.depth <= 8
      : header.color_type == kRgb || header.color_type == kGreyAlpha || header.color_type == kRgba
          ? header.depth >= 8
          : false;
  if (!is_power || !fits_type) {
    fail_damaged(kFormat, fmt::format("colour type {} with {} bits", header.color_type, header.depth));
  }
  if (data[10] != 0 || data[11] != 0 || data[12] > 1)
    fail_damaged(kFormat, "an unknown compression, filter or interlace");
  return header;
}

void parse_palette(Bytes data, Contents& contents) {
  if (data.size() % 3 != 0 || data.empty() || data.size() > 768)
    fail_damaged(kFormat, "its palette has the wrong size");
  contents.palette_size = data.size() / 3;
  for (auto& entry : contents.palette) entry = {0, 0, 0, 255};
  for (std::size_t i = 0; i < data.size(); ++i) contents.palette[i / 3][i % 3] = data[i];
}

void parse_transparency(Bytes data, Contents& contents) {
  const std::uint8_t type = contents.header.color_type;
  if (type == kPalette) {
    if (data.size() > contents.palette_size) fail_damaged(kFormat, "more transparency than palette");
    for (std::size_t i = 0; i < data.size(); ++i) contents.palette[i][3] = data[i];
  } else if (type == kGrey || type == kRgb) {
    const std::size_t channels = type == kGrey ? 1 : 3;
    if (data.size() != 2 * channels) fail_damaged(kFormat, "its transparent colour has the wrong size");
    for (std::size_t i = 0; i < channels; ++i) contents.key[i] = big_endian_16(&data[2 * i]);
  } else {
    return;  // it has alpha already
  }
  contents.has_alpha = true;
}

void parse_chunk(std::uint32_t type, Bytes data, Contents& contents) {
  constexpr auto kName = [](const char(&name)[5]) consteval {
    return std::uint32_t(name[0]) << 24 | std::uint32_t(name[1]) << 16 | std::uint32_t(name[2]) << 8 |
           std::uint32_t(name[3]);
  };
  switch (type) {
    case kName("IHDR"):
      fail_damaged(kFormat, "it has two headers");
    case kName("PLTE"):
      return parse_palette(data, contents);
    case kName("tRNS"):
      // Behind the pixels it has no place (section 5.6), and image_header.cpp does not look for it there.
      if (!contents.pixels_have_begun) parse_transparency(data, contents);
      return;
    case kName("IDAT"):
      contents.pixels_have_begun = true;
      if (data.empty()) return;
      contents.compressed.push_back(data);
      contents.compressed_size += data.size();
      return;
    default:
      if (!(type & 0x20000000u)) fail_damaged(kFormat, "it needs a chunk that is not known");
  }
}

// Everything before IEND; an ancillary chunk with a wrong checksum counts as absent.
Contents parse(Bytes file, const DecodeLimits& limits) {
  constexpr std::size_t kSignature = 8, kFrame = 12;  // a chunk's length, name and checksum
  Contents contents;
  bool is_first = true;
  for (Bytes left = file.subspan(kSignature); left.size() >= kFrame;) {
    const std::size_t size = big_endian_32(&left[0]);
    if (size > left.size() - kFrame) break;
    const std::uint32_t type = big_endian_32(&left[4]);
    const Bytes data = left.subspan(8, size);
    const bool is_sound = libdeflate_crc32(0, &left[4], size + 4) == big_endian_32(&left[8 + size]);
    left = left.subspan(size + kFrame);

    constexpr std::uint32_t kIhdr = 0x49484452, kIend = 0x49454e44, kAncillary = 0x20000000;
    if (!is_sound && (type & kAncillary)) continue;
    if (!is_sound) fail_damaged(kFormat, "a checksum is wrong");
    if (is_first != (type == kIhdr)) fail_damaged(kFormat, "its header is not where it belongs");
    if (is_first) {
      contents.header = parse_header(data);
      check_extent(kFormat, contents.header.width, contents.header.height, limits);
      is_first = false;
      continue;
    }
    if (type == kIend) break;
    parse_chunk(type, data, contents);
  }
  if (contents.compressed.empty()) fail_damaged(kFormat, "it has no pixels");
  if (contents.header.color_type == kPalette && contents.palette_size == 0)
    fail_damaged(kFormat, "it has no palette");
  return contents;
}

// One pass of Adam7; a picture that is not interlaced is a single pass over all pixels.
struct Pass {
  std::uint32_t x0, y0, dx, dy;
  std::uint32_t columns(const Header& header) const {
    return header.width > x0 ? (header.width - x0 + dx - 1) / dx : 0;
  }
  std::uint32_t rows(const Header& header) const {
    return header.height > y0 ? (header.height - y0 + dy - 1) / dy : 0;
  }
};

std::span<const Pass> passes_of(const Header& header) {
  static constexpr Pass kWhole[] = {{0, 0, 1, 1}};
  static constexpr Pass kAdam7[] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                    {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
  return header.interlaced ? std::span<const Pass>(kAdam7) : std::span<const Pass>(kWhole);
}

std::size_t raw_size(const Header& header) {
  std::size_t size = 0;
  for (const Pass& pass : passes_of(header)) {
    const std::uint32_t columns = pass.columns(header);
    if (columns > 0) size += (header.row_bytes(columns) + 1) * pass.rows(header);
  }
  return size;
}

struct RawRows {
  std::unique_ptr<std::uint8_t[]> bytes;
  std::size_t size = 0;
};

RawRows inflate(const Contents& contents) {
  constexpr std::size_t kMaxRatio = 1032;  // of deflate, as zlib's documentation says
  constexpr std::size_t kSurplus =
      4096;  // some writers append a little; what is beyond the last row is dropped
  RawRows rows;
  rows.size = raw_size(contents.header);
  if (rows.size / kMaxRatio > contents.compressed_size)
    fail_damaged(kFormat, "it ends before its last pixel");

  Bytes compressed = contents.compressed.front();
  std::vector<std::uint8_t> joined;
  if (contents.compressed.size() > 1) {
    joined.reserve(contents.compressed_size);
    for (Bytes part : contents.compressed) joined.insert(joined.end(), part.begin(), part.end());
    compressed = joined;
  }
  rows.bytes = std::make_unique_for_overwrite<std::uint8_t[]>(rows.size + kSurplus);
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  std::size_t got = 0;
  const libdeflate_result result = libdeflate_zlib_decompress(
      decompressor.get(), compressed.data(), compressed.size(), rows.bytes.get(), rows.size + kSurplus, &got);
  if (result != LIBDEFLATE_SUCCESS || got < rows.size) fail_damaged(kFormat, "its compressed pixels");
  return rows;
}

std::uint32_t stored_sample(const std::uint8_t* row, std::size_t index, int depth) {
  if (depth == 8) return row[index];
  if (depth == 16) return big_endian_16(row + 2 * index);
  const std::size_t bit = index * static_cast<std::size_t>(depth);
  return (row[bit / 8] >> (8 - depth - static_cast<int>(bit % 8))) & ((1u << depth) - 1u);
}

// Writes row samples in their final form, `step` pixels apart. Sample is the image's type.
template <class Sample>
void expand_row(const Contents& contents, const std::uint8_t* row, std::uint32_t columns, Sample* out,
                std::size_t step) {
  const Header& header = contents.header;
  const auto stored = static_cast<std::size_t>(header.stored_channels());
  if (header.color_type == kPalette) {
    const std::size_t channels = contents.has_alpha ? 4 : 3;
    for (std::uint32_t x = 0; x < columns; ++x, out += step * channels) {
      const auto& entry = contents.palette[stored_sample(row, x, header.depth)];
      for (std::size_t channel = 0; channel < channels; ++channel) out[channel] = entry[channel];
    }
    return;
  }
  // Grey of 1, 2 and 4 bits is spread over 0..255.
  const std::uint32_t spread = header.depth < 8 ? 255u / ((1u << header.depth) - 1u) : 1u;
  const auto opaque = static_cast<Sample>(header.depth == 16 ? 65535 : 255);
  const std::size_t channels = stored + (contents.has_alpha ? 1 : 0);
  for (std::uint32_t x = 0; x < columns; ++x, out += step * channels) {
    bool is_key = true;
    for (std::size_t channel = 0; channel < stored; ++channel) {
      const std::uint32_t sample = stored_sample(row, x * stored + channel, header.depth);
      is_key = is_key && channel < 3 && sample == contents.key[channel];
      out[channel] = static_cast<Sample>(sample * spread);
    }
    if (contents.has_alpha) out[stored] = is_key ? Sample{0} : opaque;
  }
}

void unfilter_or_fail(std::uint8_t* row, const std::uint8_t* above, std::size_t size, std::size_t step,
                      std::uint8_t filter) {
  if (filter > 4) fail_damaged(kFormat, "an unknown filter");
  png_unfilter(static_cast<PngFilter>(filter), row, above, size, step);
}

template <class Sample>
void decode_rows(const Contents& contents, const RawRows& raw, Image& image) {
  const Header& header = contents.header;
  const auto channels = static_cast<std::size_t>(image.channels);
  std::uint8_t* row = raw.bytes.get();
  for (const Pass& pass : passes_of(header)) {
    const std::uint32_t columns = pass.columns(header);
    if (columns == 0) continue;
    const std::size_t size = header.row_bytes(columns);
    const std::vector<std::uint8_t> nothing(size);
    const std::uint8_t* above = nothing.data();
    for (std::uint32_t y = pass.y0; y < header.height; y += pass.dy, row += size + 1) {
      unfilter_or_fail(row + 1, above, size, header.filter_step(), row[0]);
      above = row + 1;
      Sample* const out =
          image.samples<Sample>().data() + (std::size_t{y} * header.width + pass.x0) * channels;
      const bool is_final = sizeof(Sample) == 1 && header.depth == 8 && pass.dx == 1 &&
                            header.color_type != kPalette && !contents.has_alpha;
      if (is_final) {
        std::memcpy(out, above, size);
      } else {
        expand_row(contents, above, columns, out, pass.dx);
      }
    }
  }
}

}  // namespace

Image decode_png(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits) {
  const Contents contents = parse({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()}, limits);
  const Header& header = contents.header;
  const RawRows raw = inflate(contents);
  const int stored = header.color_type == kPalette ? 3 : header.stored_channels();
  const SampleType type = header.depth == 16 ? SampleType::kUint16 : SampleType::kUint8;
  Image image = make_image({static_cast<int>(header.width), static_cast<int>(header.height)},
                           stored + (contents.has_alpha ? 1 : 0), type, color_space);
  if (type == SampleType::kUint16) {
    decode_rows<std::uint16_t>(contents, raw, image);
  } else {
    decode_rows<std::uint8_t>(contents, raw, image);
  }
  return image;
}

}  // namespace furnace
