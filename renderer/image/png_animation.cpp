// Portable Network Graphics (third edition, 2025), 11.3.6: animation as frames after the first, in chunks of their own.
#include <cmath>
#include <utility>

#include "renderer/image/encode.hpp"
#include "renderer/image/png_chunks.hpp"
#include "renderer/base/check.hpp"

namespace furnace {

namespace {

class PngAnimation final : public AnimationEncoder {
 public:
  PngAnimation(const AnimationTiming& timing, std::vector<TextField> metadata)
      : timing_(timing), metadata_(std::move(metadata)) {}

  void add(const Image& frame) override {
    if (added_ == 0) begin(frame);
    append_frame_control(frame);
    const std::size_t rows = begin_chunk(png_, added_ == 0 ? "IDAT" : "fdAT");
    if (added_ > 0) append_big_endian(png_, sequence_++);
    append_png_rows(png_, frame);
    end_chunk(png_, rows);
    ++added_;
  }

  std::string finish() override {
    FURNACE_CHECK(added_ == timing_.frames, "{} frames of {}", added_, timing_.frames);
    append_png_end(png_);
    return std::move(png_);
  }

 private:
  void begin(const Image& first) {
    append_png_head(png_, first);
    append_png_text(png_, metadata_);
    const std::size_t control = begin_chunk(png_, "acTL");
    append_big_endian(png_, static_cast<std::uint32_t>(timing_.frames));
    append_big_endian(png_, static_cast<std::uint32_t>(timing_.loops));
    end_chunk(png_, control);
  }

  void append_frame_control(const Image& frame) {
    const std::size_t control = begin_chunk(png_, "fcTL");
    append_big_endian(png_, sequence_++);
    append_big_endian(png_, static_cast<std::uint32_t>(frame.extent.width));
    append_big_endian(png_, static_cast<std::uint32_t>(frame.extent.height));
    append_big_endian(png_, 0);
    append_big_endian(png_, 0);
    // The delay is a fraction of 16-bit numbers, s: exact for rates of two decimals.
    constexpr double kNumerator = 100;
    append_big_endian16(png_, static_cast<std::uint32_t>(kNumerator));
    append_big_endian16(png_,
                        static_cast<std::uint32_t>(std::lround(kNumerator * timing_.frames_per_second)));
    png_ += '\0';  // leave the frame as it is; the next covers all of it
    png_ += '\0';  // alpha replaces
    end_chunk(png_, control);
  }

  const AnimationTiming timing_;
  const std::vector<TextField> metadata_;
  std::string png_;
  int added_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace

std::unique_ptr<AnimationEncoder> png_animation(const AnimationTiming& timing,
                                                const std::vector<TextField>& metadata) {
  return std::make_unique<PngAnimation>(timing, metadata);
}

}  // namespace furnace
