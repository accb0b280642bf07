#include "renderer/image/vp9_stream.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <vpx/vp8cx.h>
#include <vpx/vpx_encoder.h>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

namespace furnace {
namespace {

// What libvpx looks ahead to place its hidden reference frames: it holds as many frames.
constexpr std::int64_t kMostFramesAhead = 16, kMostPxAhead = 32 << 20;
// libvpx's "speed", 0 to 9: of the good ones the quickest.
constexpr int kSpeed = 5;
constexpr int kCoarsestLevel = 63;

// The level of constant quality: spread so that 90 shows no loss and 50 is a small file that is still clean.
unsigned level_of(int quality) {
  return static_cast<unsigned>(std::lround(kCoarsestLevel * std::pow(1 - quality / 100.0, 0.6)));
}

}  // namespace

struct Vp9Stream::Encoder {
  Extent extent;
  Vp9Settings settings;
  vpx_codec_ctx_t codec = {};
  std::vector<Vp9Frame> frames;
  int added = 0;

  Encoder(Extent size, const Vp9Settings& wanted) : extent(size), settings(wanted) {
    vpx_codec_enc_cfg_t config;
    if (vpx_codec_enc_config_default(vpx_codec_vp9_cx(), &config, 0) != VPX_CODEC_OK) refuse();
    config.g_w = static_cast<unsigned>(extent.width);
    config.g_h = static_cast<unsigned>(extent.height);
    config.g_threads = 1;  // the pool has the others
    constexpr int kHundredths = 100;
    config.g_timebase = {kHundredths,
                         static_cast<int>(std::lround(kHundredths * settings.frames_per_second))};
    config.g_lag_in_frames = unsigned(std::min(kMostFramesAhead, kMostPxAhead / extent.area()));
    config.rc_end_usage = VPX_Q;
    config.kf_mode = VPX_KF_DISABLED;  // where they are told, so that two streams of one video agree
    if (vpx_codec_enc_init(&codec, vpx_codec_vp9_cx(), &config, 0) != VPX_CODEC_OK) refuse();
    const auto set = [this](auto control, auto value) {
      if (vpx_codec_control_(&codec, control, value) != VPX_CODEC_OK) refuse();
    };
    set(VP8E_SET_CPUUSED, kSpeed);
    set(VP8E_SET_CQ_LEVEL, level_of(settings.quality));
    set(VP9E_SET_COLOR_SPACE, static_cast<int>(VPX_CS_BT_709));
    set(VP9E_SET_COLOR_RANGE, static_cast<int>(VPX_CR_STUDIO_RANGE));
  }
  ~Encoder() { vpx_codec_destroy(&codec); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  [[noreturn]] void refuse() {
    const char* detail = vpx_codec_error_detail(&codec);
    fail(ErrorCode::kInternal, "the picture could not be written as VP9", {},
         detail ? detail : vpx_codec_error(&codec));
  }

  // Null: no more will come.
  void encode(const vpx_image_t* image, vpx_enc_frame_flags_t flags) {
    constexpr unsigned long kOneFrame = 1;
    if (vpx_codec_encode(&codec, image, added, kOneFrame, flags, VPX_DL_GOOD_QUALITY) != VPX_CODEC_OK)
      refuse();
    vpx_codec_iter_t at = nullptr;
    while (const vpx_codec_cx_pkt_t* packet = vpx_codec_get_cx_data(&codec, &at)) {
      if (packet->kind != VPX_CODEC_CX_FRAME_PKT) continue;
      const auto& frame = packet->data.frame;
      frames.push_back({std::string(static_cast<const char*>(frame.buf), frame.sz),
                        (frame.flags & VPX_FRAME_IS_KEY) != 0});
    }
  }
};

Vp9Stream::Vp9Stream(Extent extent, const Vp9Settings& settings)
    : encoder_(std::make_unique<Encoder>(extent, settings)) {}

Vp9Stream::~Vp9Stream() = default;

void Vp9Stream::add(const YuvPlanes& frame) {
  FURNACE_CHECK(frame.extent == encoder_->extent, "a frame of {} x {} px", frame.extent.width,
                frame.extent.height);
  // libvpx only reads what it is given here.
  const auto bytes = [](const std::vector<std::uint8_t>& plane) {
    return const_cast<unsigned char*>(plane.data());
  };
  vpx_image_t image;
  constexpr unsigned kRowAlignment = 1;
  vpx_img_wrap(&image, VPX_IMG_FMT_I420, static_cast<unsigned>(frame.extent.width),
               static_cast<unsigned>(frame.extent.height), kRowAlignment, bytes(frame.y));
  const int chroma_width = chroma_extent(frame.extent).width;
  image.planes[VPX_PLANE_U] = bytes(frame.cb);
  image.planes[VPX_PLANE_V] = bytes(frame.cr);
  image.stride[VPX_PLANE_Y] = frame.extent.width;
  image.stride[VPX_PLANE_U] = image.stride[VPX_PLANE_V] = chroma_width;
  image.cs = VPX_CS_BT_709;
  image.range = VPX_CR_STUDIO_RANGE;
  const bool is_key = encoder_->added % encoder_->settings.frames_per_key == 0;
  encoder_->encode(&image, is_key ? VPX_EFLAG_FORCE_KF : 0);
  ++encoder_->added;
}

std::vector<Vp9Frame> Vp9Stream::finish() {
  std::size_t known = 0;
  do {  // one call may leave frames behind
    known = encoder_->frames.size();
    encoder_->encode(nullptr, 0);
  } while (encoder_->frames.size() > known);
  FURNACE_CHECK(int(known) == encoder_->added, "{} of {} frames came back", known, encoder_->added);
  return std::move(encoder_->frames);
}

}  // namespace furnace
