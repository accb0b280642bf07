#include "renderer/image/codecs.hpp"
#include "renderer/base/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "Radiance HDR";

struct Rgbe {
  std::uint8_t r, g, b, e;
};
static_assert(sizeof(Rgbe) == 4);

// Threads: one. Owns: nothing; reads the file front to back.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> file) : left_(file) {}

  std::size_t left() const { return left_.size(); }

  std::string_view line() {
    const std::string_view text(reinterpret_cast<const char*>(left_.data()), left_.size());
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) fail_damaged(kFormat, "its header does not end");
    left_ = left_.subspan(end + 1);
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  std::uint8_t byte() { return static_cast<std::uint8_t>(take(1)[0]); }

  std::span<const std::byte> take(std::size_t count) {
    if (count > left_.size()) fail_damaged(kFormat, "it ends before its last pixel");
    const auto taken = left_.first(count);
    left_ = left_.subspan(count);
    return taken;
  }

  Rgbe pixel() {
    Rgbe pixel;
    std::memcpy(&pixel, take(4).data(), 4);
    return pixel;
  }

  std::optional<Rgbe> peek() const {
    if (left_.size() < 4) return std::nullopt;
    Rgbe pixel;
    std::memcpy(&pixel, left_.data(), 4);
    return pixel;
  }

 private:
  std::span<const std::byte> left_;
};

struct Resolution {
  std::int64_t width = 0;
  std::int64_t height = 0;
  bool bottom_up = false;
  bool right_to_left = false;
};

// "-Y 512 +X 1024": rows downwards, columns to the right.
Resolution parse_resolution(std::string_view line) {
  const auto axis = [&](char name, bool& positive, std::int64_t& size) {
    if (line.size() < 4 || (line[0] != '+' && line[0] != '-') || line[1] != name || line[2] != ' ')
      return false;
    positive = line[0] == '+';
    const auto [end, error] = std::from_chars(line.data() + 3, line.data() + line.size(), size);
    if (error != std::errc{}) return false;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    while (line.starts_with(' ')) line.remove_prefix(1);
    return true;
  };
  Resolution resolution;
  bool rightwards = true;
  const std::string whole(line.substr(0, 60));
  if (line.size() > 1 && line[1] == 'X') {
    fail(ErrorCode::kUnsupportedMedia,
         fmt::format("the Radiance HDR is stored column by column (\"{}\"); save it with \"-Y\" first",
                     whole));
  }
  if (!axis('Y', resolution.bottom_up, resolution.height) || !axis('X', rightwards, resolution.width) ||
      !line.empty()) {
    fail_damaged(kFormat, "its resolution line does not read as \"-Y height +X width\"");
  }
  resolution.right_to_left = !rightwards;
  return resolution;
}

Resolution read_header(Reader& reader) {
  reader.line();  // "#?RADIANCE"
  for (;;) {
    const std::string_view line = reader.line();
    if (line.empty()) break;
    constexpr std::string_view kKey = "FORMAT=";
    if (line.starts_with(kKey) && line.substr(kKey.size()) != "32-bit_rle_rgbe") {
      fail(ErrorCode::kUnsupportedMedia,
           fmt::format("the Radiance HDR has the format \"{}\"; only 32-bit_rle_rgbe is read",
                       line.substr(kKey.size(), 40)));
    }
  }
  return parse_resolution(reader.line());
}

// Ward 1991, "Real Pixels", and the later scheme of Radiance's color.c: the four components one after the
// other, each in runs (count above 128) and literal stretches.
void read_planar_row(Reader& reader, std::vector<Rgbe>& row) {
  std::uint8_t* const bytes = &row[0].r;
  for (std::size_t component = 0; component < 4; ++component) {
    for (std::size_t x = 0; x < row.size();) {
      const std::uint8_t code = reader.byte();
      const bool is_run = code > 128;
      const std::size_t count = is_run ? code - 128u : code;
      if (count == 0 || count > row.size() - x) fail_damaged(kFormat, "a run leaves its row");
      if (is_run) {
        const std::uint8_t value = reader.byte();
        for (std::size_t i = 0; i < count; ++i) bytes[4 * x++ + component] = value;
      } else {
        for (const std::byte value : reader.take(count))
          bytes[4 * x++ + component] = static_cast<std::uint8_t>(value);
      }
    }
  }
}

// The old scheme: pixels as they are, where (1, 1, 1, n) repeats the last one n times; consecutive repeats
// count in base 256.
void read_interleaved_row(Reader& reader, std::vector<Rgbe>& row) {
  int shift = 0;
  for (std::size_t x = 0; x < row.size();) {
    const Rgbe pixel = reader.pixel();
    if (pixel.r != 1 || pixel.g != 1 || pixel.b != 1) {
      row[x++] = pixel;
      shift = 0;
      continue;
    }
    if (x == 0 || shift > 24) fail_damaged(kFormat, "a run has no pixel to repeat");
    const std::size_t count = std::size_t{pixel.e} << shift;
    if (count > row.size() - x) fail_damaged(kFormat, "a run leaves its row");
    std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(x), count, row[x - 1]);
    x += count;
    shift += 8;
  }
}

bool is_planar(const Rgbe& start, std::size_t width) {
  return width >= 8 && width < 32768 && start.r == 2 && start.g == 2 && start.b < 128;
}

void read_row(Reader& reader, std::vector<Rgbe>& row) {
  const std::optional<Rgbe> start = reader.peek();
  if (!start || !is_planar(*start, row.size())) return read_interleaved_row(reader, row);
  reader.take(4);
  if (std::size_t{start->b} * 256 + start->e != row.size())
    fail_damaged(kFormat, "a row has the wrong width");
  read_planar_row(reader, row);
}

// mantissa / 256 * 2^(e - 128) without Ward's half step: what other readers do, and black stays black.
std::array<float, 256> scales() {
  std::array<float, 256> scales{};
  for (int e = 1; e < 256; ++e) scales[static_cast<std::size_t>(e)] = std::ldexp(1.0f, e - 136);
  return scales;
}

}  // namespace

Image decode_rgbe(std::span<const std::byte> file, const DecodeLimits& limits, Shape shape) {
  static const std::array<float, 256> scale_of_exponent = scales();
  Reader reader(file);
  const Resolution resolution = read_header(reader);
  check_extent(kFormat, resolution.width, resolution.height, limits, shape);
  if (reader.left() < static_cast<std::size_t>(4 * resolution.height))
    fail_damaged(kFormat, "it ends before its last row");

  const Extent extent{static_cast<int>(resolution.width), static_cast<int>(resolution.height)};
  Image image = make_image(extent, 3, SampleType::kFloat32, ColorSpace::kLinear);
  std::vector<Rgbe> row(static_cast<std::size_t>(extent.width));
  const std::size_t stride = row.size() * 3;
  for (int i = 0; i < extent.height; ++i) {
    read_row(reader, row);
    if (resolution.right_to_left) std::ranges::reverse(row);
    const int y = resolution.bottom_up ? extent.height - 1 - i : i;
    float* out = image.samples<float>().data() + static_cast<std::size_t>(y) * stride;
    for (const Rgbe& pixel : row) {
      const float scale = scale_of_exponent[pixel.e];
      *out++ = pixel.r * scale;
      *out++ = pixel.g * scale;
      *out++ = pixel.b * scale;
    }
  }
  return image;
}

}  // namespace furnace
