#include "renderer/image/image_header.hpp"

#include "renderer/image/decode.hpp"
#include "renderer/image/png_chunks.hpp"

#include <algorithm>
#include <array>

namespace furnace {

namespace {

// Bytes with a bound: what lies beyond the end reads as 0.
// Threads: one. Owns: nothing.
class Bytes {
 public:
  explicit Bytes(std::span<const std::byte> file) : file_(file) {}

  std::size_t size() const { return file_.size(); }
  bool has(std::size_t offset, std::size_t count) const {
    return offset <= file_.size() && count <= file_.size() - offset;
  }
  std::uint32_t at(std::size_t offset) const {
    return offset < file_.size() ? std::to_integer<std::uint32_t>(file_[offset]) : 0;
  }
  std::uint32_t little(std::size_t offset, int count) const {
    std::uint32_t value = 0;
    for (int i = count - 1; i >= 0; --i) value = value << 8 | at(offset + static_cast<std::size_t>(i));
    return value;
  }
  std::uint32_t big(std::size_t offset, int count) const {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i) value = value << 8 | at(offset + static_cast<std::size_t>(i));
    return value;
  }
  // There must be as many.
  std::span<const std::byte> part(std::size_t offset, std::size_t count) const {
    return file_.subspan(offset, count);
  }
  bool matches(std::size_t offset, std::string_view text) const {
    if (!has(offset, text.size())) return false;
    for (std::size_t i = 0; i < text.size(); ++i)
      if (at(offset + i) != static_cast<unsigned char>(text[i])) return false;
    return true;
  }

 private:
  std::span<const std::byte> file_;
};

// Real files have a few tens of chunks or segments before their pixels; a hostile one could have millions.
constexpr int kMaxSteps = 4096;

// PNG (second edition, 2003), section 11: IHDR comes first, tRNS before the pixels.
void read_png(const Bytes& file, ImageHeader& header) {
  constexpr std::size_t kFirstChunk = 8, kChunkFrame = 12;
  if (!file.matches(kFirstChunk + 4, "IHDR") || !file.has(kFirstChunk, 25)) return;
  header.width = file.big(16, 4);
  header.height = file.big(20, 4);
  header.bits = file.at(24) == 16 ? 16 : 8;
  const std::uint32_t color_type = file.at(25);
  const bool grey = color_type == 0 || color_type == 4;
  bool alpha = color_type >= 4;
  std::size_t at = kFirstChunk;
  for (int step = 0; step < kMaxSteps && file.has(at, kChunkFrame); ++step) {
    if (file.matches(at + 4, "IDAT")) break;
    const std::size_t size = file.big(at, 4);
    if (file.matches(at + 4, "tRNS") && file.has(at, kChunkFrame + size)) {
      // As the decoder: one with a wrong checksum counts as absent.
      alpha = alpha || png_checksum(file.part(at + 4, size + 4)) == file.big(at + 8 + size, 4);
    }
    at += kChunkFrame + size;
  }
  header.channels = (grey ? 1 : 3) + (alpha ? 1 : 0);
}

// ITU-T T.81, annex B: marker segments until the frame header.
void read_jpeg(const Bytes& file, ImageHeader& header) {
  constexpr std::uint32_t kHuffman = 0xc4, kReserved = 0xc8, kArithmetic = 0xcc, kScan = 0xda;
  std::size_t at = 2;
  for (int step = 0; step < kMaxSteps && file.has(at, 4); ++step) {
    if (file.at(at) != 0xff) return;
    const std::uint32_t marker = file.at(at + 1);
    if (marker == 0xff) {  // fill
      ++at;
      continue;
    }
    const std::uint32_t length = file.big(at + 2, 2);
    if (marker == kScan || length < 2) return;
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != kHuffman && marker != kReserved &&
                       marker != kArithmetic;
    if (frame) {
      if (!file.has(at, 10)) return;
      header.height = file.big(at + 5, 2);
      header.width = file.big(at + 7, 2);
      header.channels = file.at(at + 9) == 1 ? 1 : 3;
      header.bits = 8;
      return;
    }
    at += 2 + std::size_t{length};
  }
}

// RFC 9649: the extended header, else that of the one bitstream.
void read_webp(const Bytes& file, ImageHeader& header) {
  if (!file.has(0, 30)) return;
  header.bits = 8;
  header.channels = 3;
  if (file.matches(12, "VP8X")) {
    constexpr std::uint32_t kAlpha = 0x10;
    header.width = file.little(24, 3) + 1;
    header.height = file.little(27, 3) + 1;
    if ((file.at(20) & kAlpha) != 0) header.channels = 4;
  } else if (file.matches(12, "VP8L") && file.at(20) == 0x2f) {
    const std::uint32_t bits = file.little(21, 4);
    header.width = (bits & 0x3fff) + 1;
    header.height = (bits >> 14 & 0x3fff) + 1;
    if ((bits >> 28 & 1) != 0) header.channels = 4;
  } else if (file.matches(12, "VP8 ") && file.matches(23, "\x9d\x01\x2a")) {
    header.width = file.little(26, 2) & 0x3fff;
    header.height = file.little(28, 2) & 0x3fff;
  }
}

// KTX File Format 2.0, section 3: fixed places. What its samples become when they are decoded depends on the GPU.
void read_ktx2(const Bytes& file, ImageHeader& header) {
  header.width = file.little(20, 4);
  header.height = std::max(file.little(24, 4), header.width > 0 ? 1u : 0u);
}

struct Row {
  ImageFormat format;
  std::string_view name;
  void (*read)(const Bytes& file, ImageHeader& header);  // null: only a reader of the whole file finds more
};

constexpr std::array kRows = {
    Row{ImageFormat::kPng, "PNG", read_png},    Row{ImageFormat::kJpeg, "JPEG", read_jpeg},
    Row{ImageFormat::kWebp, "WebP", read_webp}, Row{ImageFormat::kKtx2, "KTX2", read_ktx2},
    Row{ImageFormat::kAvif, "AVIF", nullptr},
};

}  // namespace

std::optional<ImageHeader> read_image_header(std::span<const std::byte> file) {
  const ImageFormat format = sniff_image_format(file);
  for (const Row& row : kRows) {
    if (row.format != format) continue;
    ImageHeader header;
    header.format = row.name;
    if (row.read != nullptr) row.read(Bytes(file), header);
    return header;
  }
  return std::nullopt;
}

}  // namespace furnace
