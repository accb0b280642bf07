// One picture of each kind that a format knows, small.
#include <array>
#include <random>

#include <OpenEXR/ImfCompression.h>
#include <zstd.h>

#include "renderer/image/encode.hpp"
#include "renderer/image/exr_parts.hpp"
#include "tests/fuzz/seeds.hpp"
#include "tests/image/etc1s_files.hpp"
#include "tests/image/ktx2_files.hpp"
#include "tests/image/sample_files.hpp"

namespace furnace::fuzz {
namespace {

Image picture(Extent extent, int channels, SampleType type, std::uint32_t seed) {
  const bool floats = type == SampleType::kFloat16 || type == SampleType::kFloat32;
  Image image = make_image(extent, channels, type, floats ? ColorSpace::kLinear : ColorSpace::kSrgb);
  std::mt19937 random(seed);
  if (type == SampleType::kUint8 || type == SampleType::kUint16)
    for (std::byte& byte : image.pixels) byte = std::byte(random() >> 3);
  if (type == SampleType::kFloat16)
    for (std::uint16_t& half : image.samples<std::uint16_t>()) half = std::uint16_t(0x3800 + random() % 1024);
  if (type == SampleType::kFloat32)
    for (float& value : image.samples<float>()) value = float(random() % 1000) / 100;
  return image;
}

std::vector<std::string> png_files() {
  std::vector<std::string> files;
  struct Kind {
    int color_type, depth;
    std::size_t row_bytes;
  };
  for (const Kind& kind :
       {Kind{0, 1, 2}, Kind{0, 2, 3}, Kind{0, 8, 9}, Kind{0, 16, 18}, Kind{2, 8, 27}, Kind{2, 16, 54},
        Kind{3, 4, 5}, Kind{3, 8, 9}, Kind{4, 8, 18}, Kind{6, 8, 36}, Kind{6, 16, 72}}) {
    for (const bool interlaced : {false, true}) {
      sample::PngOptions options;
      options.color_type = kind.color_type;
      options.depth = kind.depth;
      options.interlaced = interlaced;
      if (kind.color_type == 3)
        options.palette = std::string(3u << kind.depth, 'x'), options.transparency = "abc";
      if (kind.color_type == 2 && interlaced) options.transparency = std::string("\0\1\0\1\0\1", 6);
      files.push_back(sample::png(9, 5, sample::noise(kind.row_bytes * 5, 1), options));
    }
  }
  files.push_back(encode_png(picture({6, 5}, 4, SampleType::kUint8, 3), {{"Software", "a test"}}));
  return files;
}

std::vector<std::string> jpeg_files() {
  using enum sample::JpegKind;
  std::vector<std::string> files = {sample::flat_jpeg(20, 12, {90}, kGrey)};
  for (const auto kind : {kRgb, kProgressive})
    files.push_back(sample::flat_jpeg(20, 12, {200, 100, 30}, kind));
  for (const auto kind : {kCmyk, kAdobeCmyk})
    files.push_back(sample::flat_jpeg(20, 12, {200, 100, 30, 4}, kind));
  for (const int quality : {20, 90})
    files.push_back(encode_jpeg(picture({17, 9}, 3, SampleType::kUint8, 5), quality, {{"furnace:a", "b"}}));
  return files;
}

std::vector<std::string> webp_files() {
  std::vector<std::string> files;
  for (const int channels : {3, 4}) {
    files.push_back(sample::lossless_webp(9, 7, channels, sample::noise(63u * unsigned(channels), 7)));
    files.push_back(encode_webp(picture({16, 9}, channels, SampleType::kUint8, 8),
                                {.lossless = false, .quality = 60}, {}));
  }
  return files;
}

std::vector<std::string> avif_files() {
  std::vector<std::string> files;
  for (const int channels : {3, 4}) {
    files.push_back(sample::lossless_avif(9, 7, channels, 8, sample::noise(63u * unsigned(channels), 7)));
    files.push_back(sample::subsampled_avif(8, 6, channels, sample::noise(48u * unsigned(channels), 8)));
  }
  files.push_back(sample::lossless_avif(5, 4, 3, 10, std::vector<std::uint8_t>(120, 1)));
  return files;
}

std::string packed_by_zstd(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
  return out;
}

std::string noise_text(std::size_t size, std::uint32_t seed) {
  const std::vector<std::uint8_t> bytes = sample::noise(size, seed);
  return {bytes.begin(), bytes.end()};
}

std::vector<std::string> ktx2_files() {
  std::vector<std::string> files;
  struct Plain {
    std::uint32_t vk_format;
    std::size_t texel_bytes;
  };
  for (const Plain& plain : {Plain{9, 1}, Plain{16, 2}, Plain{23, 3}, Plain{30, 3}, Plain{37, 4},
                             Plain{43, 4}, Plain{44, 4}, Plain{77, 4}}) {
    sample::Ktx2Parts parts;
    parts.vk_format = plain.vk_format;
    parts.width = 5, parts.height = 3, parts.level_count = 2;
    parts.metadata = {{"KTXorientation", "rd"}, {"KTXswizzle", "rgb1"}};
    parts.levels = {noise_text(15 * plain.texel_bytes, 1), noise_text(2 * plain.texel_bytes, 2)};
    files.push_back(sample::ktx2(parts));
  }
  // Any bits are a block of UASTC in nearly every case.
  for (const std::uint32_t scheme : {0u, 2u}) {
    sample::Ktx2Parts parts;
    parts.vk_format = 0, parts.model = kDfModelUastc, parts.scheme = scheme;
    parts.width = 13, parts.height = 10;
    const std::string blocks = noise_text(16 * 12, scheme);
    parts.levels = {scheme == 0 ? blocks : packed_by_zstd(blocks)};
    files.push_back(sample::ktx2(parts));
  }
  std::vector<std::uint8_t> rgb, second;
  for (unsigned seed = 0; seed < 3; ++seed)
    files.push_back(sample::etc1s_file(seed, {20 + int(seed), 17}, rgb, second));
  return files;
}

std::vector<std::string> hdr_files() {
  std::string planar = sample::rgbe_header(16, 8), old = sample::rgbe_header(16, 2),
              flat = sample::rgbe_header(4, 2), cross = sample::rgbe_header(4, 3);
  for (int y = 0; y < 8; ++y) {
    planar += std::string({2, 2, 0, 16});
    for (int component = 0; component < 4; ++component)
      planar += std::string({'\x8a', 100, 6, 1, 2, 3, 4, 5, 6});
  }
  for (int y = 0; y < 2; ++y) old += std::string({9, 8, 7, 120, 1, 1, 1, 10, 5, 4, 3, 120, 1, 1, 1, 4});
  flat += noise_text(32, 4);
  cross += noise_text(48, 5);
  return {planar, old, flat, cross};
}

std::vector<std::string> exr_files() {
  std::vector<std::string> files;
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
        Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::DWAA_COMPRESSION}) {
    for (const bool tiled : {false, true}) files.push_back(sample::small_exr(compression, tiled));
  }
  for (const SampleType type : {SampleType::kFloat16, SampleType::kFloat32})
    files.push_back(encode_exr(picture({10, 5}, 4, type, 6), {{"capDate", "today"}}));
  const Image image = picture({6, 3}, 3, SampleType::kFloat16, 7);
  files.push_back(
      encode_exr_layers(image, {{"depth", "Z", picture({6, 3}, 1, SampleType::kFloat32, 8)}}, {}));
  return files;
}

std::vector<std::string> exr_parts_files() {
  const Image first = picture({4, 4}, 4, SampleType::kFloat16, 1),
              second = picture({2, 2}, 4, SampleType::kFloat16, 2);
  const std::vector<NamedImage> one = {{"level0", &first}}, two = {{"level0", &first}, {"level1", &second}};
  return {encode_exr_parts(one, {}), encode_exr_parts(two, {{"furnace", "a text"}, {"b", "c"}})};
}

}  // namespace

void add_image_seeds(Seeds& seeds) {
  seeds["png"] = png_files();
  seeds["jpeg"] = jpeg_files();
  seeds["webp"] = webp_files();
  seeds["avif"] = avif_files();
  seeds["ktx2"] = ktx2_files();
  seeds["hdr"] = hdr_files();
  seeds["exr"] = exr_files();
  seeds["exr_parts"] = exr_parts_files();
}

}  // namespace furnace::fuzz
