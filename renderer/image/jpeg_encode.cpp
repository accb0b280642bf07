#include "renderer/image/encode.hpp"
#include "renderer/image/srgb_profile.hpp"
#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

#include <cstdio>  // jpeglib.h wants it before itself
#include <jpeglib.h>

#include <csetjmp>
#include <cstdlib>

namespace furnace {

namespace {

// libjpeg reports through longjmp, which must not cross a destructor: write() keeps nothing that has one. Threads: one. Owns:
// the encoder's state and the file.
class JpegWriter {
 public:
  JpegWriter() {
    encoder_.err = jpeg_std_error(&errors_);
    encoder_.client_data = this;
    errors_.error_exit = [](j_common_ptr common) {
      static_cast<JpegWriter*>(common->client_data)->bail_out();
    };
    errors_.output_message = [](j_common_ptr) {};
  }
  ~JpegWriter() {
    jpeg_destroy_compress(&encoder_);
    std::free(file_);
  }
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;

  bool write(const Image& image, int quality, const std::string& profile,
             const std::vector<std::string>& comments) {
    if (setjmp(escape_)) return false;
    jpeg_create_compress(&encoder_);
    jpeg_mem_dest(&encoder_, &file_, &file_bytes_);
    encoder_.image_width = static_cast<JDIMENSION>(image.extent.width);
    encoder_.image_height = static_cast<JDIMENSION>(image.extent.height);
    encoder_.input_components = image.channels;
    encoder_.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&encoder_);
    jpeg_set_quality(&encoder_, quality, TRUE);
    encoder_.dct_method = JDCT_ISLOW;  // integers: the same bytes on every processor
    encoder_.optimize_coding = TRUE;
    // 4:4:4: rendered edges between saturated colours show halved chroma.
    encoder_.comp_info[0].h_samp_factor = encoder_.comp_info[0].v_samp_factor = 1;
    jpeg_start_compress(&encoder_, TRUE);
    if (!profile.empty()) {
      jpeg_write_icc_profile(&encoder_, reinterpret_cast<const JOCTET*>(profile.data()),
                             static_cast<unsigned>(profile.size()));
    }
    for (const std::string& comment : comments) {
      jpeg_write_marker(&encoder_, JPEG_COM, reinterpret_cast<const JOCTET*>(comment.data()),
                        static_cast<unsigned>(comment.size()));
    }
    const std::uint8_t* row = image.samples<std::uint8_t>().data();
    for (int y = 0; y < image.extent.height; ++y, row += image.row_bytes()) {
      // libjpeg's rows serve reading too, hence not const.
      JSAMPROW rows[] = {const_cast<JSAMPROW>(row)};
      jpeg_write_scanlines(&encoder_, rows, 1);
    }
    jpeg_finish_compress(&encoder_);
    return true;
  }

  std::string_view file() const { return {reinterpret_cast<const char*>(file_), file_bytes_}; }
  const char* message() const { return message_; }

 private:
  [[noreturn]] void bail_out() {
    errors_.format_message(reinterpret_cast<j_common_ptr>(&encoder_), message_);
    std::longjmp(escape_, 1);
  }

  jpeg_compress_struct encoder_{};
  jpeg_error_mgr errors_{};
  std::jmp_buf escape_;
  char message_[JMSG_LENGTH_MAX] = "";
  unsigned char* file_ = nullptr;
  unsigned long file_bytes_ = 0;
};

}  // namespace

std::string encode_jpeg(const Image& image, int quality, const std::vector<TextField>& metadata) {
  FURNACE_CHECK(image.type == SampleType::kUint8 && (image.channels == 1 || image.channels == 3),
                "a JPEG of {} channels, sample type {}", image.channels, static_cast<int>(image.type));
  constexpr std::size_t kMaxCommentBytes = 65533;  // JPEG, ITU-T T.81, B.2.4: two bytes of length
  std::vector<std::string> comments;
  for (const TextField& field : metadata) {
    comments.push_back(field.key + ": " + field.value);
    FURNACE_CHECK(comments.back().size() <= kMaxCommentBytes, "a JPEG comment of {} bytes",
                  comments.back().size());
  }
  // A profile of three channels does not fit a grey picture.
  const std::string profile = image.channels == 3 ? srgb_icc_profile() : std::string();
  JpegWriter writer;
  if (!writer.write(image, quality, profile, comments)) {
    fail(ErrorCode::kInternal, "the picture could not be written as JPEG", {}, writer.message());
  }
  return std::string(writer.file());
}

}  // namespace furnace
