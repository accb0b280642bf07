#include "renderer/image/encode.hpp"
#include "renderer/image/png_chunks.hpp"
#include "renderer/image/png_deflate.hpp"
#include "renderer/image/png_filter.hpp"
#include "renderer/base/check.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <limits>
#include <span>

namespace furnace {

namespace {

// Minimum sum of absolute differences, the heuristic of the PNG specification (second edition, 12.8). Bytes are signed here.
std::uint64_t cost_of(std::span<const std::uint8_t> filtered) {
  std::uint64_t sum = 0;
  for (std::uint8_t byte : filtered) sum += std::min<std::uint8_t>(byte, static_cast<std::uint8_t>(-byte));
  return sum;
}

// PNG stores the more significant byte first.
Image big_endian(Image image) {
  for (std::uint16_t& sample : image.samples<std::uint16_t>())
    sample = static_cast<std::uint16_t>(sample << 8 | sample >> 8);
  return image;
}

// The rows as they are compressed. Neighbours are alike: one row in four chooses the filter for itself and the next three.
std::vector<std::uint8_t> filter_rows(const Image& image) {
  constexpr int kGroup = 4;
  const std::size_t size = image.row_bytes();
  const auto step = static_cast<std::size_t>(image.channels) * sample_bytes(image.type);
  std::vector<std::uint8_t> filtered((size + 1) * static_cast<std::size_t>(image.extent.height));
  std::vector<std::uint8_t> trial(size);
  const std::vector<std::uint8_t> nothing(size);
  const std::uint8_t* above = nothing.data();
  const std::uint8_t* row = image.samples<std::uint8_t>().data();
  std::uint8_t* out = filtered.data();
  PngFilter chosen = PngFilter::kSub;
  for (int y = 0; y < image.extent.height; ++y, above = row, row += size, out += size + 1) {
    if (y % kGroup == 1) {
      std::uint64_t lowest = std::numeric_limits<std::uint64_t>::max();
      for (PngFilter filter : {PngFilter::kUp, PngFilter::kAverage, PngFilter::kPaeth}) {
        png_filter(filter, row, above, size, step, trial.data());
        const std::uint64_t cost = cost_of(trial);
        if (cost < lowest) chosen = filter;
        lowest = std::min(lowest, cost);
      }
    }
    *out = static_cast<std::uint8_t>(chosen);
    png_filter(chosen, row, above, size, step, out + 1);
  }
  return filtered;
}

// Portable Network Graphics (third edition, 2025), 11.3.2.5: beside sRGB the numbers that stand for it, for readers that know
// gAMA and cHRM only. A cICP would say the same again.
void append_srgb(std::string& out) {
  const std::size_t tag = begin_chunk(out, "sRGB");
  out += '\0';  // perceptual intent
  end_chunk(out, tag);
  const std::size_t gamma = begin_chunk(out, "gAMA");
  append_big_endian(out, 45455);
  end_chunk(out, gamma);
  const std::size_t chromaticities = begin_chunk(out, "cHRM");
  // x and y of white, red, green, blue.
  for (const std::uint32_t part : {31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000})
    append_big_endian(out, part);
  end_chunk(out, chromaticities);
}

void append_text(std::string& out, const TextField& field) {
  const auto is_ascii = [](char c) { return static_cast<unsigned char>(c) < 0x80; };
  FURNACE_CHECK(!field.key.empty() && field.key.size() < 80, "a PNG keyword \"{}\"", field.key);
  const bool is_plain = std::ranges::all_of(field.value, is_ascii);
  const std::size_t chunk = begin_chunk(out, is_plain ? "tEXt" : "iTXt");
  out += field.key;
  out += '\0';
  if (!is_plain) out.append(4, '\0');  // not compressed, no language, no translated keyword
  out += field.value;
  end_chunk(out, chunk);
}

}  // namespace

void append_big_endian(std::string& out, std::uint32_t value) {
  for (int shift : {24, 16, 8, 0}) out.push_back(static_cast<char>(value >> shift));
}

void append_big_endian16(std::string& out, std::uint32_t value) {
  for (int shift : {8, 0}) out.push_back(static_cast<char>(value >> shift));
}

std::uint32_t png_checksum(std::span<const std::byte> bytes) {
  return libdeflate_crc32(0, bytes.data(), bytes.size());
}

std::size_t begin_chunk(std::string& out, std::string_view type) {
  const std::size_t start = out.size();
  append_big_endian(out, 0);
  out += type;
  return start;
}

void end_chunk(std::string& out, std::size_t start) {
  const std::size_t size = out.size() - start - 8;
  for (std::size_t i = 0; i < 4; ++i) out[start + i] = static_cast<char>(size >> (24 - 8 * i));
  append_big_endian(out, png_checksum(std::as_bytes(std::span(out)).subspan(start + 4, size + 4)));
}

void append_png_head(std::string& out, const Image& image) {
  static constexpr std::array<std::uint8_t, 4> kColorType = {0, 4, 2, 6};
  const bool is_wide = image.type == SampleType::kUint16;
  FURNACE_CHECK((is_wide || image.type == SampleType::kUint8) && image.extent.area() > 0,
                "a PNG of sample type {}", static_cast<int>(image.type));
  out += "\x89PNG\r\n\x1a\n";
  const std::size_t header = begin_chunk(out, "IHDR");
  append_big_endian(out, static_cast<std::uint32_t>(image.extent.width));
  append_big_endian(out, static_cast<std::uint32_t>(image.extent.height));
  out += is_wide ? '\x10' : '\x08';
  out += static_cast<char>(kColorType[static_cast<std::size_t>(image.channels - 1)]);
  out.append(3, '\0');
  end_chunk(out, header);
  if (image.color_space == ColorSpace::kSrgb) append_srgb(out);
}

void append_png_text(std::string& out, const std::vector<TextField>& metadata) {
  for (const TextField& field : metadata) append_text(out, field);
}

void append_png_rows(std::string& out, const Image& image) {
  append_run_deflated(filter_rows(image.type == SampleType::kUint16 ? big_endian(image) : image), out);
}

void append_png_end(std::string& out) {
  end_chunk(out, begin_chunk(out, "IEND"));
}

std::string encode_png(const Image& image, const std::vector<TextField>& metadata) {
  std::string png;
  append_png_head(png, image);
  append_png_text(png, metadata);
  const std::size_t rows = begin_chunk(png, "IDAT");
  append_png_rows(png, image);
  end_chunk(png, rows);
  append_png_end(png);
  return png;
}

}  // namespace furnace
