#include "renderer/image/codecs.hpp"
#include "renderer/base/error.hpp"

#include <cstdio>  // jpeglib.h wants it before itself
#include <jpeglib.h>
#include <jerror.h>

#include <csetjmp>
#include <vector>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "JPEG";
constexpr int kMaxScans =
    200;  // real progressive files have about ten; each costs a pass over the whole picture

// libjpeg reports through longjmp, which must not cross a destructor: the member functions that call libjpeg
// keep nothing that has one, and say by their result whether they got through. Threads: one. Owns: the
// decoder's state.
class JpegReader {
 public:
  explicit JpegReader(std::span<const std::byte> file) {
    decoder_.err = jpeg_std_error(&errors_);
    decoder_.client_data = this;
    errors_.error_exit = [](j_common_ptr common) { self(common).bail_out(); };
    errors_.emit_message = [](j_common_ptr common, int level) { self(common).note_warning(level); };
    errors_.output_message = [](j_common_ptr) {};
    progress_.progress_monitor = [](j_common_ptr common) { self(common).limit_scans(); };
    is_open_ = open(file);
  }
  ~JpegReader() { jpeg_destroy_decompress(&decoder_); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  bool is_open() const { return is_open_; }
  std::int64_t width() const { return decoder_.image_width; }
  std::int64_t height() const { return decoder_.image_height; }
  bool is_grey() const { return decoder_.jpeg_color_space == JCS_GRAYSCALE; }
  bool is_cmyk() const {
    return decoder_.jpeg_color_space == JCS_CMYK || decoder_.jpeg_color_space == JCS_YCCK;
  }
  // Adobe's programs write CMYK inverted, and say that they wrote it.
  bool is_inverted() const { return decoder_.saw_Adobe_marker; }
  bool ended_early() const { return ended_early_; }
  const char* message() const { return message_; }

  bool start() {
    if (setjmp(escape_)) return false;
    decoder_.out_color_space = is_grey() ? JCS_GRAYSCALE : is_cmyk() ? JCS_CMYK : JCS_RGB;
    return jpeg_start_decompress(&decoder_);
  }

  bool read_row(std::uint8_t* row) {
    if (setjmp(escape_)) return false;
    return jpeg_read_scanlines(&decoder_, &row, 1) == 1;
  }

 private:
  static JpegReader& self(j_common_ptr common) { return *static_cast<JpegReader*>(common->client_data); }

  bool open(std::span<const std::byte> file) {
    if (setjmp(escape_)) return false;
    jpeg_create_decompress(&decoder_);
    decoder_.progress = &progress_;
    jpeg_mem_src(&decoder_, reinterpret_cast<const unsigned char*>(file.data()), file.size());
    return jpeg_read_header(&decoder_, TRUE) == JPEG_HEADER_OK;
  }

  [[noreturn]] void bail_out() {
    errors_.format_message(reinterpret_cast<j_common_ptr>(&decoder_), message_);
    std::longjmp(escape_, 1);
  }

  void note_warning(int level) {
    if (level < 0 && errors_.msg_code == JWRN_JPEG_EOF) ended_early_ = true;
  }

  void limit_scans() {
    if (decoder_.input_scan_number <= kMaxScans) return;
    std::snprintf(message_, sizeof(message_), "it has more than %d scans", kMaxScans);
    std::longjmp(escape_, 1);
  }

  jpeg_decompress_struct decoder_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  std::jmp_buf escape_;
  char message_[JMSG_LENGTH_MAX] = "its header";
  bool is_open_ = false;
  bool ended_early_ = false;
};

// As browsers do without a colour profile: RGB = (1 - CMY) (1 - K).
void rgb_from_cmyk(std::span<const std::uint8_t> cmyk, bool inverted, std::uint8_t* rgb) {
  const int flip = inverted ? 0 : 255;
  for (std::size_t i = 0; i < cmyk.size(); i += 4) {
    const int white = cmyk[i + 3] ^ flip;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      *rgb++ = static_cast<std::uint8_t>(((cmyk[i + channel] ^ flip) * white + 127) / 255);
    }
  }
}

}  // namespace

Image decode_jpeg(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits) {
  JpegReader reader(file);
  if (!reader.is_open()) fail_damaged(kFormat, reader.message());
  check_extent(kFormat, reader.width(), reader.height(), limits);
  if (!reader.start()) fail_damaged(kFormat, reader.message());

  const Extent extent{static_cast<int>(reader.width()), static_cast<int>(reader.height())};
  Image image = make_image(extent, reader.is_grey() ? 1 : 3, SampleType::kUint8, color_space);
  std::vector<std::uint8_t> cmyk_row(reader.is_cmyk() ? static_cast<std::size_t>(extent.width) * 4 : 0);
  for (int y = 0; y < extent.height; ++y) {
    std::uint8_t* const row =
        image.samples<std::uint8_t>().data() + static_cast<std::size_t>(y) * image.row_bytes();
    if (!reader.read_row(reader.is_cmyk() ? cmyk_row.data() : row)) fail_damaged(kFormat, reader.message());
    if (reader.is_cmyk()) rgb_from_cmyk(cmyk_row, reader.is_inverted(), row);
  }
  if (reader.ended_early()) fail_damaged(kFormat, "it ends before its last pixel");
  return image;
}

}  // namespace furnace
