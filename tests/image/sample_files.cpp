#include "tests/image/sample_files.hpp"

#include <cstdio>  // jpeglib.h wants it before itself
#include <jpeglib.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <avif/avif.h>
#include <png.h>
#include <webp/encode.h>

#include <array>
#include <csetjmp>
#include <cstdlib>
#include <memory>
#include <stdexcept>

namespace furnace::sample {

std::vector<std::uint8_t> noise(std::size_t size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> bytes(size);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

namespace {

[[noreturn]] void throw_png_error(png_structp, png_const_charp message) {
  throw std::runtime_error(message);
}

void set_transparency(png_structp png, png_infop info, const PngOptions& options) {
  if (options.transparency.empty()) return;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(options.transparency.data());
  const auto sample = [&](std::size_t i) {
    return static_cast<png_uint_16>(bytes[2 * i] << 8 | bytes[2 * i + 1]);
  };
  png_color_16 key{};
  if (options.color_type == PNG_COLOR_TYPE_GRAY) key.gray = sample(0);
  if (options.color_type == PNG_COLOR_TYPE_RGB) key = {0, sample(0), sample(1), sample(2), 0};
  png_set_tRNS(png, info, bytes, static_cast<int>(options.transparency.size()), &key);
}

}  // namespace

std::string png(int width, int height, const std::vector<std::uint8_t>& rows, const PngOptions& options) {
  std::string file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, throw_png_error, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &file,
      [](png_structp p, png_bytep bytes, std::size_t size) {
        static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(bytes), size);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), options.depth,
               options.color_type, options.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (!options.palette.empty()) {
    png_set_PLTE(png, info, reinterpret_cast<const png_color*>(options.palette.data()),
                 static_cast<int>(options.palette.size() / 3));
  }
  set_transparency(png, info, options);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, options.filters);
  png_write_info(png, info);
  const std::size_t stride = rows.size() / static_cast<std::size_t>(height);
  std::vector<png_bytep> pointers;
  for (int y = 0; y < height; ++y)
    pointers.push_back(const_cast<png_bytep>(rows.data()) + stride * static_cast<std::size_t>(y));
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

std::string flat_jpeg(int width, int height, const std::vector<std::uint8_t>& color, JpegKind kind) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);  // ends the process: these files are well-formed
  jpeg_create_compress(&encoder);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &bytes, &size);
  encoder.image_width = static_cast<JDIMENSION>(width);
  encoder.image_height = static_cast<JDIMENSION>(height);
  encoder.input_components = static_cast<int>(color.size());
  encoder.in_color_space = kind == JpegKind::kGrey ? JCS_GRAYSCALE : color.size() == 4 ? JCS_CMYK : JCS_RGB;
  jpeg_set_defaults(&encoder);
  if (color.size() == 4) {
    jpeg_set_colorspace(&encoder, kind == JpegKind::kAdobeCmyk ? JCS_YCCK : JCS_CMYK);
    encoder.write_Adobe_marker = kind == JpegKind::kAdobeCmyk;
  }
  if (kind == JpegKind::kProgressive) jpeg_simple_progression(&encoder);
  jpeg_set_quality(&encoder, 100, TRUE);
  jpeg_start_compress(&encoder, TRUE);
  std::vector<std::uint8_t> row;
  for (int x = 0; x < width; ++x) row.insert(row.end(), color.begin(), color.end());
  JSAMPROW pointer = row.data();
  for (int y = 0; y < height; ++y) jpeg_write_scanlines(&encoder, &pointer, 1);
  jpeg_finish_compress(&encoder);
  jpeg_destroy_compress(&encoder);
  std::string file(reinterpret_cast<char*>(bytes), size);
  std::free(bytes);
  return file;
}

std::string lossless_webp(int width, int height, int channels, const std::vector<std::uint8_t>& samples) {
  std::uint8_t* bytes = nullptr;
  const auto encode = channels == 4 ? WebPEncodeLosslessRGBA : WebPEncodeLosslessRGB;
  const std::size_t size = encode(samples.data(), width, height, width * channels, &bytes);
  std::string file(reinterpret_cast<char*>(bytes), size);
  WebPFree(bytes);
  return file;
}

namespace {

std::string avif(int width, int height, int channels, int depth, const std::vector<std::uint8_t>& samples,
                 avifPixelFormat format, avifMatrixCoefficients coefficients) {
  const std::unique_ptr<avifImage, decltype(&avifImageDestroy)> image(
      avifImageCreate(std::uint32_t(width), std::uint32_t(height), std::uint32_t(depth), format),
      avifImageDestroy);
  image->matrixCoefficients = coefficients;
  avifRGBImage rgb;
  avifRGBImageSetDefaults(&rgb, image.get());
  rgb.format = channels == 4 ? AVIF_RGB_FORMAT_RGBA : AVIF_RGB_FORMAT_RGB;
  rgb.pixels = const_cast<std::uint8_t*>(samples.data());
  rgb.rowBytes = std::uint32_t(width * channels * (depth > 8 ? 2 : 1));
  const std::unique_ptr<avifEncoder, decltype(&avifEncoderDestroy)> encoder(avifEncoderCreate(),
                                                                            avifEncoderDestroy);
  encoder->minQuantizer = encoder->maxQuantizer = AVIF_QUANTIZER_LOSSLESS;
  encoder->minQuantizerAlpha = encoder->maxQuantizerAlpha = AVIF_QUANTIZER_LOSSLESS;
  encoder->speed = AVIF_SPEED_FASTEST;
  avifRWData out = AVIF_DATA_EMPTY;
  if (avifImageRGBToYUV(image.get(), &rgb) != AVIF_RESULT_OK ||
      avifEncoderWrite(encoder.get(), image.get(), &out) != AVIF_RESULT_OK)
    throw std::runtime_error("libavif writes no AVIF");
  std::string file(reinterpret_cast<const char*>(out.data), out.size);
  avifRWDataFree(&out);
  return file;
}

}  // namespace

std::string lossless_avif(int width, int height, int channels, int depth,
                          const std::vector<std::uint8_t>& samples) {
  return avif(width, height, channels, depth, samples, AVIF_PIXEL_FORMAT_YUV444,
              AVIF_MATRIX_COEFFICIENTS_IDENTITY);
}

std::string subsampled_avif(int width, int height, int channels, const std::vector<std::uint8_t>& samples) {
  return avif(width, height, channels, 8, samples, AVIF_PIXEL_FORMAT_YUV420, AVIF_MATRIX_COEFFICIENTS_BT601);
}

std::string rgbe_header(int width, int height) {
  return "#?RADIANCE\n# made by a test\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " +
         std::to_string(width) + "\n";
}

std::string small_exr(Imf::Compression compression, bool is_tiled) {
  constexpr int kWidth = 24, kHeight = 12;
  std::vector<std::uint16_t> halves(kWidth * kHeight * 3);
  std::mt19937 random(11);
  for (auto& half : halves) half = static_cast<std::uint16_t>(0x3800 + next(random, 64));
  Imf::Header header(kWidth, kHeight, 1, {0, 0}, 1, Imf::INCREASING_Y, compression);
  Imf::FrameBuffer frame;
  for (std::size_t i = 0; i < 3; ++i) {
    const char* const name = std::array{"R", "G", "B"}[i];
    header.channels().insert(name, Imf::Channel(Imf::HALF));
    frame.insert(name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.data() + i), 6, 6 * kWidth));
  }
  Imf::StdOSStream stream;
  if (is_tiled) {
    header.setTileDescription(Imf::TileDescription(16, 8, Imf::ONE_LEVEL));
    Imf::TiledOutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  } else {
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(frame);
    file.writePixels(kHeight);
  }
  return stream.str();
}

std::string with_right_checksums(std::string png) {
  const auto be32 = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(png[at + i]);
    return value;
  };
  for (std::size_t at = 8; at + 12 <= png.size();) {
    const std::size_t size = be32(at);
    if (size > png.size() - at - 12) break;
    std::uint32_t crc = 0xffffffff;
    for (std::size_t i = at + 4; i < at + 8 + size; ++i) {
      crc ^= static_cast<std::uint8_t>(png[i]);
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    for (std::size_t i = 0; i < 4; ++i) png[at + 8 + size + i] = static_cast<char>(~crc >> (24 - 8 * i));
    at += size + 12;
  }
  return png;
}

}  // namespace furnace::sample
