#include "renderer/image/encode.hpp"
#include "renderer/image/srgb_profile.hpp"
#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

#include <webp/encode.h>
#include <webp/mux.h>

#include <cmath>
#include <memory>
#include <utility>

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

WebPConfig config_of(const WebpSettings& settings) {
  WebPConfig config;
  if (!WebPConfigInit(&config)) refuse("its configuration");
  if (settings.lossless) {
    constexpr int kLosslessLevel = 2;  // more costs more than drawing did, for a few per cent
    WebPConfigLosslessPreset(&config, kLosslessLevel);
  } else {
    config.quality = static_cast<float>(settings.quality);
    config.use_sharp_yuv = 1;  // chroma is halved in WebP; this keeps rendered edges
  }
  return config;
}

// Threads: one. Owns: a copy of an image as libwebp takes it.
class Picture {
 public:
  explicit Picture(const Image& image) {
    FURNACE_CHECK(image.type == SampleType::kUint8 && (image.channels == 3 || image.channels == 4),
                  "a WebP of {} channels, sample type {}", image.channels, static_cast<int>(image.type));
    if (!WebPPictureInit(&picture)) refuse("its picture");
    picture.use_argb = 1;
    picture.width = image.extent.width;
    picture.height = image.extent.height;
    const auto import = image.channels == 4 ? WebPPictureImportRGBA : WebPPictureImportRGB;
    if (!import(&picture, image.samples<std::uint8_t>().data(), static_cast<int>(image.row_bytes())))
      refuse("error " + std::to_string(picture.error_code));
  }
  ~Picture() { WebPPictureFree(&picture); }
  Picture(const Picture&) = delete;
  Picture& operator=(const Picture&) = delete;

  WebPPicture picture;
};

void compress(const Image& image, const WebpSettings& settings, WebpBytes& bytes) {
  const WebPConfig config = config_of(settings);
  Picture source(image);
  source.picture.writer = WebPMemoryWrite;
  source.picture.custom_ptr = &bytes.writer;
  if (!WebPEncode(&config, &source.picture)) refuse("error " + std::to_string(source.picture.error_code));
}

// The file with its colour profile and metadata.
std::string with_metadata(const WebPData& bare, const std::vector<TextField>& metadata) {
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

// Only what changed from frame to frame is kept, and equal frames become one that lasts longer: libwebpmux' doing.
class WebpAnimation final : public AnimationEncoder {
 public:
  WebpAnimation(const AnimationTiming& timing, const WebpSettings& settings, std::vector<TextField> metadata)
      : timing_(timing), config_(config_of(settings)), metadata_(std::move(metadata)) {}

  void add(const Image& frame) override {
    Picture source(frame);
    if (added_ == 0) begin(frame.extent);
    if (!WebPAnimEncoderAdd(encoder_.get(), &source.picture, time_ms(added_), &config_))
      refuse(WebPAnimEncoderGetError(encoder_.get()));
    ++added_;
  }

  std::string finish() override {
    FURNACE_CHECK(added_ == timing_.frames, "{} frames of {}", added_, timing_.frames);
    WebPData file{nullptr, 0};
    if (!WebPAnimEncoderAdd(encoder_.get(), nullptr, time_ms(added_), nullptr) ||
        !WebPAnimEncoderAssemble(encoder_.get(), &file))
      refuse(WebPAnimEncoderGetError(encoder_.get()));
    const std::unique_ptr<WebPData, decltype(&WebPDataClear)> owner(&file, WebPDataClear);
    return with_metadata(file, metadata_);
  }

 private:
  void begin(Extent canvas) {
    WebPAnimEncoderOptions options;
    if (!WebPAnimEncoderOptionsInit(&options)) refuse("its options");
    options.anim_params.loop_count = timing_.loops;
    encoder_.reset(WebPAnimEncoderNew(canvas.width, canvas.height, &options));
    if (!encoder_) refuse("its encoder");
  }

  int time_ms(int frame) const {
    return static_cast<int>(std::lround(frame * 1000.0 / timing_.frames_per_second));
  }

  const AnimationTiming timing_;
  const WebPConfig config_;
  const std::vector<TextField> metadata_;
  std::unique_ptr<WebPAnimEncoder, decltype(&WebPAnimEncoderDelete)> encoder_{nullptr, WebPAnimEncoderDelete};
  int added_ = 0;
};

}  // namespace

std::string encode_webp(const Image& image, const WebpSettings& settings,
                        const std::vector<TextField>& metadata) {
  WebpBytes bytes;
  compress(image, settings, bytes);
  return with_metadata({bytes.writer.mem, bytes.writer.size}, metadata);
}

std::unique_ptr<AnimationEncoder> webp_animation(const AnimationTiming& timing, const WebpSettings& settings,
                                                 const std::vector<TextField>& metadata) {
  return std::make_unique<WebpAnimation>(timing, settings, metadata);
}

}  // namespace furnace
