#include "renderer/image/exr_claims.hpp"

#include "renderer/image/codecs.hpp"
#include "renderer/base/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "OpenEXR file";

// The layout is that of "OpenEXR File Layout" (openexr.com); numbers are little-endian.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

  std::size_t left() const { return left_.size(); }

  template <class Number>
  Number number() {
    Number value;
    std::memcpy(&value, take(sizeof(Number)).data(), sizeof(Number));
    return value;
  }

  std::string_view name() {
    constexpr std::size_t kLongestName = 255;
    const std::string_view text(reinterpret_cast<const char*>(left_.data()),
                                std::min(left_.size(), kLongestName + 1));
    const std::size_t end = text.find('\0');
    if (end == std::string_view::npos) fail_damaged(kFormat, "a name in its header does not end");
    left_ = left_.subspan(end + 1);
    return text.substr(0, end);
  }

  std::span<const std::byte> take(std::size_t size) {
    if (size > left_.size()) fail_damaged(kFormat, "its header does not end");
    const auto taken = left_.first(size);
    left_ = left_.subspan(size);
    return taken;
  }

 private:
  std::span<const std::byte> left_;
};

ExrWindow parse_window(Reader value) {
  ExrWindow window;
  window.min_x = value.number<std::int32_t>();
  window.min_y = value.number<std::int32_t>();
  window.max_x = value.number<std::int32_t>();
  window.max_y = value.number<std::int32_t>();
  return window;
}

std::vector<ExrChannel> parse_channels(Reader value) {
  constexpr std::size_t kMostChannels = 1024;
  std::vector<ExrChannel> channels;
  for (;;) {
    const std::string_view name = value.name();
    if (name.empty()) {
      if (value.left() > 0) fail_damaged(kFormat, "its list of channels");
      return channels;
    }
    constexpr std::int32_t kHalf = 1;
    const auto type = value.number<std::int32_t>();
    value.take(4);  // perceptual linearity and padding
    const auto x_sampling = value.number<std::int32_t>();
    const auto y_sampling = value.number<std::int32_t>();
    if (type < 0 || type > 2 || x_sampling < 1 || y_sampling < 1)
      fail_damaged(kFormat, "its list of channels");
    channels.push_back({std::string(name), type == kHalf ? 2 : 4, x_sampling != 1 || y_sampling != 1});
    if (channels.size() > kMostChannels)
      fail(ErrorCode::kTooLarge, "the OpenEXR file has more than 1024 channels");
  }
}

// Bytes of the types whose size the library knows: it passes over the size that is said, and would find another header behind
// a wrong one than we did.
void check_size(std::string_view type, const Reader& value) {
  static constexpr std::pair<std::string_view, std::size_t> kSizes[] = {{"box2i", 16},
                                                                        {"box2f", 16},
                                                                        {"chromaticities", 32},
                                                                        {"compression", 1},
                                                                        {"double", 8},
                                                                        {"envmap", 1},
                                                                        {"deepImageState", 1},
                                                                        {"float", 4},
                                                                        {"int", 4},
                                                                        {"keycode", 28},
                                                                        {"m33f", 36},
                                                                        {"m33d", 72},
                                                                        {"m44f", 64},
                                                                        {"m44d", 128},
                                                                        {"lineOrder", 1},
                                                                        {"v2i", 8},
                                                                        {"v2f", 8},
                                                                        {"v2d", 16},
                                                                        {"rational", 8},
                                                                        {"tiledesc", 9},
                                                                        {"v3i", 12},
                                                                        {"v3f", 12},
                                                                        {"v3d", 24},
                                                                        {"timecode", 8}};
  for (const auto& [name, size] : kSizes)
    if (name == type && value.left() != size)
      fail_damaged(kFormat, "an attribute of another size than its type has");
  if (type != "preview") return;
  Reader preview(value);
  const auto width = preview.number<std::uint32_t>(), height = preview.number<std::uint32_t>();
  if (preview.left() / 4 != std::uint64_t{width} * height || preview.left() % 4 != 0)
    fail_damaged(kFormat, "a preview of another size than it says");
}

// One header; nothing when there is none (the end of a multi-part list).
bool parse_part(Reader& reader, ExrPart& part) {
  bool has_windows[2] = {};
  for (bool is_first = true;; is_first = false) {
    const std::string_view name = reader.name();
    if (name.empty()) {
      if (is_first) return false;
      break;
    }
    const std::string_view type = reader.name();
    const Reader value(reader.take(reader.number<std::uint32_t>()));
    check_size(type, value);
    if (name == "dataWindow" && type == "box2i") {
      part.data_window = parse_window(value);
      has_windows[0] = true;
    } else if (name == "displayWindow" && type == "box2i") {
      part.display_window = parse_window(value);
      has_windows[1] = true;
    } else if (name == "channels" && type == "chlist") {
      part.channels = parse_channels(value);
    } else if (name == "compression" && type == "compression") {
      part.compression = Reader(value).number<std::uint8_t>();
    } else if (name == "tiles" && type == "tiledesc") {
      Reader tiles(value);
      part.is_tiled = true;
      part.tile_width = tiles.number<std::uint32_t>();
      part.tile_height = tiles.number<std::uint32_t>();
      part.tile_mode = tiles.number<std::uint8_t>();
    } else if (name == "type" && type == "string") {
      Reader text(value);
      const auto bytes = text.take(text.left());
      part.is_deep =
          std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).starts_with("deep");
    }
  }
  if (!has_windows[0] || !has_windows[1] || part.channels.empty())
    fail_damaged(kFormat, "its header lacks its windows or its channels");
  return true;
}

std::int64_t rows_per_chunk(std::uint8_t compression) {
  // none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB
  static constexpr std::int64_t kRows[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
  if (compression >= std::size(kRows)) {
    fail(ErrorCode::kUnsupportedMedia,
         fmt::format("the OpenEXR file has the unknown compression {}", compression));
  }
  return kRows[compression];
}

std::int64_t divide_up(std::int64_t size, std::int64_t by) {
  return (size + by - 1) / by;
}

// Tiles along one side of each level.
std::vector<std::int64_t> tiles_by_level(std::int64_t size, std::int64_t tile, bool has_levels,
                                         bool rounds_up, std::int64_t longest) {
  std::vector<std::int64_t> counts = {divide_up(size, tile)};
  for (; has_levels && longest > 1; counts.push_back(divide_up(size, tile))) {
    const auto halve = [&](std::int64_t n) {
      return std::max<std::int64_t>(1, rounds_up ? divide_up(n, 2) : n / 2);
    };
    size = halve(size);
    longest = halve(longest);
  }
  return counts;
}

std::int64_t chunk_count(const ExrPart& part) {
  const std::int64_t width = part.data_window.width(), height = part.data_window.height();
  if (!part.is_tiled) return divide_up(height, rows_per_chunk(part.compression));
  const int levels = part.tile_mode & 15;  // one, mip-mapped, rip-mapped
  const bool rounds_up = part.tile_mode >> 4;
  const auto counts = [&](std::int64_t size, std::int64_t tile) {
    return tiles_by_level(size, tile, levels != 0, rounds_up, levels == 1 ? std::max(width, height) : size);
  };
  const std::vector<std::int64_t> across = counts(width, part.tile_width),
                                  down = counts(height, part.tile_height);
  std::int64_t sum = 0;
  for (std::size_t y = 0; y < down.size(); ++y) {
    for (std::size_t x = 0; x < across.size(); ++x) sum += levels == 2 || x == y ? across[x] * down[y] : 0;
  }
  return sum;
}

void check_part(const ExrPart& part, const DecodeLimits& limits) {
  constexpr std::int64_t kMostChunkBytes = 256 << 20;  // unpacked at once
  constexpr std::int32_t kFarthest = 1 << 24;          // px from the origin, so that sums of coordinates fit
  check_extent(kFormat, part.data_window.width(), part.data_window.height(), limits);
  check_extent(kFormat, part.display_window.width(), part.display_window.height(), limits);
  for (const ExrWindow& window : {part.data_window, part.display_window}) {
    if (std::min(window.min_x, window.min_y) < -kFarthest ||
        std::max(window.max_x, window.max_y) > kFarthest) {
      fail_damaged(kFormat, "its windows are too far from the origin");
    }
  }
  if (part.is_tiled) {
    check_extent("OpenEXR tile", part.tile_width, part.tile_height, limits);
    if ((part.tile_mode & 15) > 2 || (part.tile_mode >> 4) > 1) fail_damaged(kFormat, "its tiles");
  }
  std::int64_t pixel_bytes = 0;
  for (const ExrChannel& channel : part.channels) pixel_bytes += channel.sample_bytes;
  std::int64_t chunk_pixels = part.data_window.width() * rows_per_chunk(part.compression);
  if (part.is_tiled) chunk_pixels = std::max(chunk_pixels, std::int64_t{part.tile_width} * part.tile_height);
  if (chunk_pixels > kMostChunkBytes / pixel_bytes) {
    fail(ErrorCode::kTooLarge, "the OpenEXR file packs too many bytes into one block");
  }
}

}  // namespace

bool ExrPart::has(std::string_view channel) const {
  return std::ranges::any_of(channels,
                             [&](const ExrChannel& candidate) { return candidate.name == channel; });
}

std::vector<ExrPart> read_exr_claims(std::span<const std::byte> file, const DecodeLimits& limits) {
  constexpr std::uint32_t kDeep = 0x800, kMultiPart = 0x1000;
  constexpr std::size_t kMostParts = 1024;
  Reader reader(file);
  reader.take(4);  // the magic number
  const auto version = reader.number<std::uint32_t>();
  if ((version & 0xff) != 2) fail(ErrorCode::kUnsupportedMedia, "the OpenEXR file has an unknown version");

  std::vector<ExrPart> parts;
  for (ExrPart part; parse_part(reader, part); part = {}) {
    parts.push_back(std::move(part));
    if (!(version & kMultiPart)) break;
    if (parts.size() > kMostParts) fail(ErrorCode::kTooLarge, "the OpenEXR file has more than 1024 parts");
  }
  if (parts.empty()) fail_damaged(kFormat, "it has no header");

  std::int64_t chunks = 0;
  for (const ExrPart& part : parts) {
    if ((version & kDeep) || part.is_deep) {
      fail(ErrorCode::kUnsupportedMedia, "the OpenEXR file holds deep data; flatten it first");
    }
    check_part(part, limits);
    chunks += chunk_count(part);
  }
  // A chunk is an entry of 8 bytes in the table and a head of at least 8 bytes.
  if (chunks > static_cast<std::int64_t>(reader.left()) / 16)
    fail_damaged(kFormat, "it ends before its last pixel");
  return parts;
}

}  // namespace furnace
