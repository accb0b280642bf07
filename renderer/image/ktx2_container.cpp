#include "renderer/image/ktx2_container.hpp"

#include "renderer/image/codecs.hpp"
#include "renderer/base/error.hpp"

#include <algorithm>
#include <bit>
#include <string>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "KTX2";
constexpr std::size_t kHeader = 80, kLevelEntry = 24;

std::uint64_t read_u64(std::span<const std::byte> bytes, std::size_t at) {
  return read_u32(bytes, at) | std::uint64_t(read_u32(bytes, at + 4)) << 32;
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::byte> section(std::span<const std::byte> file, std::uint64_t offset, std::uint64_t size,
                                   std::string_view what) {
  if (offset > file.size() || size > file.size() - offset) fail_damaged(kFormat, what);
  return file.subspan(offset, size);
}

[[noreturn]] void refuse(const std::string& what) {
  fail(ErrorCode::kUnsupportedMedia, "a KTX2 texture must be a single picture; this one " + what);
}

// The basic data format descriptor: 24 bytes after the total size, then 16 a sample.
void read_descriptor(std::span<const std::byte> dfd, Ktx2& out) {
  constexpr std::size_t kSamples = 28, kSample = 16;
  if (dfd.size() < kSamples + kSample) fail_damaged(kFormat, "its data format descriptor");
  out.model = std::to_integer<std::uint8_t>(dfd[12]);
  out.transfer = std::to_integer<std::uint8_t>(dfd[14]);
  out.premultiplied = (std::to_integer<unsigned>(dfd[15]) & 1) != 0;
  const std::size_t end = std::min<std::size_t>(dfd.size(), std::size_t(read_u16(dfd, 10)) + 4);
  for (std::size_t at = kSamples; at + kSample <= end; at += kSample)
    out.channels.push_back(std::to_integer<std::uint8_t>(dfd[at + 3]) & 15);
  if (out.channels.empty()) fail_damaged(kFormat, "its data format descriptor");
}

void read_value(std::string_view key, std::string_view value, Ktx2& out) {
  value = value.substr(0, value.find('\0'));
  if (key == "KTXswizzle") {
    if (value.size() != 4 || value.find_first_not_of("rgba01") != std::string_view::npos)
      fail_damaged(kFormat, "its KTXswizzle");
    std::copy(value.begin(), value.end(), out.swizzle.begin());
  } else if (key == "KTXorientation") {
    if (value.size() != 2) fail_damaged(kFormat, "its KTXorientation");
    out.right_to_left = value[0] == 'l';
    out.bottom_up = value[1] == 'u';
  }
}

void read_metadata(std::span<const std::byte> bytes, Ktx2& out) {
  while (bytes.size() >= 4) {
    const std::size_t size = read_u32(bytes, 0);
    if (size > bytes.size() - 4) fail_damaged(kFormat, "its metadata");
    const std::string_view entry = text_of(bytes.subspan(4, size));
    const std::size_t end = entry.find('\0');
    if (end == std::string_view::npos) fail_damaged(kFormat, "its metadata");
    read_value(entry.substr(0, end), entry.substr(end + 1), out);
    bytes = bytes.subspan(std::min(bytes.size(), 4 + (size + 3) / 4 * 4));
  }
}

Extent check_shape(std::span<const std::byte> file, const DecodeLimits& limits) {
  const std::uint32_t width = read_u32(file, 20), height = read_u32(file, 24), depth = read_u32(file, 28);
  const std::uint32_t layers = read_u32(file, 32), faces = read_u32(file, 36);
  if (depth != 0) refuse("is a volume");
  if (faces != 1) refuse("is a cube map");
  if (layers != 0) refuse("is an array");
  if (height == 0) refuse("has one dimension");
  check_extent(kFormat, width, height, {kMostSidePx, limits.max_area_px});
  return {int(width), int(height)};
}

}  // namespace

std::uint16_t read_u16(std::span<const std::byte> bytes, std::size_t at) {
  return std::uint16_t(std::to_integer<unsigned>(bytes[at]) | std::to_integer<unsigned>(bytes[at + 1]) << 8);
}

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
  return read_u16(bytes, at) | std::uint32_t(read_u16(bytes, at + 2)) << 16;
}

Ktx2 open_ktx2(std::span<const std::byte> file, const DecodeLimits& limits) {
  if (file.size() < kHeader) fail_damaged(kFormat, "its header");
  Ktx2 out;
  out.vk_format = read_u32(file, 12);
  const Extent extent = check_shape(file, limits);
  const std::uint32_t level_count = std::max<std::uint32_t>(read_u32(file, 40), 1);
  const std::uint32_t scheme = read_u32(file, 44);
  if (scheme > std::uint32_t(Ktx2Scheme::kZlib))
    fail(ErrorCode::kUnsupportedMedia,
         "the supercompression scheme " + std::to_string(scheme) + " of this KTX2 is not read");
  out.scheme = Ktx2Scheme(scheme);
  if (level_count > std::uint32_t(std::bit_width(unsigned(std::max(extent.width, extent.height)))))
    fail_damaged(kFormat, "it claims more levels than there can be");

  read_descriptor(section(file, read_u32(file, 48), read_u32(file, 52), "its data format descriptor"), out);
  read_metadata(section(file, read_u32(file, 56), read_u32(file, 60), "its metadata"), out);
  out.global_data = section(file, read_u64(file, 64), read_u64(file, 72), "its global data");
  const auto index = section(file, kHeader, level_count * kLevelEntry, "its level index");
  for (std::uint32_t level = 0; level < level_count; ++level) {
    const std::size_t at = level * kLevelEntry;
    out.levels.push_back({{std::max(extent.width >> level, 1), std::max(extent.height >> level, 1)},
                          section(file, read_u64(index, at), read_u64(index, at + 8), "its level index")});
  }
  return out;
}

}  // namespace furnace
