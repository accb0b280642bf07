#include "renderer/image/encode.hpp"
#include "renderer/image/srgb_profile.hpp"
#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

#include <webp/encode.h>
#include <webp/mux.h>

#include <memory>

namespace furnace {

namespace {

[[noreturn]] void refuse(std::string detail) {
  fail(ErrorCode::kInternal, "the picture could not be written as WebP", {}, std::move(detail));
}

std::string xml_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '"') {
      out += "&quot;";
    } else {
      out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

// ISO 16684-1:2012, "Extensible metadata platform (XMP)": each field an attribute of one description.
std::string xmp_packet(const std::vector<TextField>& metadata) {
  std::string xmp =
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
      "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">"
      "<rdf:Description rdf:about=\"\" xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\" "
      "xmlns:furnace=\"urn:furnace\"";
  for (const TextField& field : metadata) {
    const bool is_tool = field.key == "Software";  // PNG's keyword for it
    FURNACE_CHECK(is_tool || field.key.starts_with("furnace:"), "an XMP property \"{}\"", field.key);
    xmp += " " + (is_tool ? "xmp:CreatorTool" : field.key) + "=\"" + xml_escaped(field.value) + "\"";
  }
  return xmp + "/></rdf:RDF></x:xmpmeta>";
}

// Threads: one. Owns: what libwebp wrote.
struct WebpBytes {
  WebPMemoryWriter writer;
  WebpBytes() { WebPMemoryWriterInit(&writer); }
  ~WebpBytes() { WebPMemoryWriterClear(&writer); }
  WebpBytes(const WebpBytes&) = delete;
  WebpBytes& operator=(const WebpBytes&) = delete;
};

void compress(const Image& image, const WebpSettings& settings, WebpBytes& bytes) {
  WebPConfig config;
  if (!WebPConfigInit(&config)) refuse("its configuration");
  if (settings.lossless) {
    constexpr int kLosslessLevel = 2;  // more costs more than drawing did, for a few per cent
    WebPConfigLosslessPreset(&config, kLosslessLevel);
  } else {
    config.quality = static_cast<float>(settings.quality);
    config.use_sharp_yuv = 1;  // chroma is halved in WebP; this keeps rendered edges
  }
  WebPPicture picture;
  if (!WebPPictureInit(&picture)) refuse("its picture");
  const std::unique_ptr<WebPPicture, decltype(&WebPPictureFree)> owner(&picture, WebPPictureFree);
  picture.use_argb = 1;
  picture.width = image.extent.width;
  picture.height = image.extent.height;
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &bytes.writer;
  const auto import = image.channels == 4 ? WebPPictureImportRGBA : WebPPictureImportRGB;
  if (!import(&picture, image.samples<std::uint8_t>().data(), static_cast<int>(image.row_bytes())) ||
      !WebPEncode(&config, &picture)) {
    refuse("error " + std::to_string(picture.error_code));
  }
}

}  // namespace

std::string encode_webp(const Image& image, const WebpSettings& settings,
                        const std::vector<TextField>& metadata) {
  FURNACE_CHECK(image.type == SampleType::kUint8 && (image.channels == 3 || image.channels == 4),
                "a WebP of {} channels, sample type {}", image.channels, static_cast<int>(image.type));
  WebpBytes bytes;
  compress(image, settings, bytes);

  const WebPData bare{bytes.writer.mem, bytes.writer.size};
  constexpr int kRefer = 0;
  const std::unique_ptr<WebPMux, decltype(&WebPMuxDelete)> mux(WebPMuxCreate(&bare, kRefer), WebPMuxDelete);
  const auto set = [&](const char* chunk, const std::string& content) {
    const WebPData data{reinterpret_cast<const std::uint8_t*>(content.data()), content.size()};
    constexpr int kCopy = 1;
    return WebPMuxSetChunk(mux.get(), chunk, &data, kCopy) == WEBP_MUX_OK;
  };
  WebPData file{nullptr, 0};
  if (!mux || !set("ICCP", srgb_icc_profile()) || !set("XMP ", xmp_packet(metadata)) ||
      WebPMuxAssemble(mux.get(), &file) != WEBP_MUX_OK) {
    refuse("its metadata");
  }
  const std::unique_ptr<WebPData, decltype(&WebPDataClear)> owner(&file, WebPDataClear);
  return {reinterpret_cast<const char*>(file.bytes), file.size};
}

}  // namespace furnace
