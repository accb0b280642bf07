// Videos, read by others: the container by libwebm's parser, VP9 by libvpx.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>
#include <webm/buffer_reader.h>
#include <webm/callback.h>
#include <webm/webm_parser.h>

#include "renderer/image/encode.hpp"

namespace furnace {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Gt;
using Bytes = std::vector<std::uint8_t>;

struct VideoFrame {
  std::int64_t time_ms = 0;
  bool is_key = false;
  Bytes color, alpha;
};

// Threads: one. Owns: what it heard.
class Video : public webm::Callback {
 public:
  explicit Video(const std::string& file) {
    webm::BufferReader reader(Bytes(file.begin(), file.end()));
    webm::WebmParser parser;
    is_whole = parser.Feed(this, &reader).completed_ok();
  }

  webm::Status OnSegmentBegin(const webm::ElementMetadata& metadata, webm::Action* action) override {
    segment_begin_ = metadata.position + metadata.header_size;
    return webm::Callback::OnSegmentBegin(metadata, action);
  }
  webm::Status OnElementBegin(const webm::ElementMetadata& metadata, webm::Action* action) override {
    begins[metadata.id].push_back(metadata.position - segment_begin_);
    return webm::Callback::OnElementBegin(metadata, action);
  }
  webm::Status OnSeek(const webm::ElementMetadata&, const webm::Seek& seek) override {
    seeks[seek.id.value()] = seek.position.value();
    return webm::Status(webm::Status::kOkCompleted);
  }
  webm::Status OnInfo(const webm::ElementMetadata&, const webm::Info& heard) override {
    info = heard;
    return webm::Status(webm::Status::kOkCompleted);
  }
  webm::Status OnTrackEntry(const webm::ElementMetadata&, const webm::TrackEntry& heard) override {
    track = heard;
    return webm::Status(webm::Status::kOkCompleted);
  }
  webm::Status OnCuePoint(const webm::ElementMetadata&, const webm::CuePoint& cue) override {
    cues[cue.time.value()] = cue.cue_track_positions.at(0).value().cluster_position.value();
    return webm::Status(webm::Status::kOkCompleted);
  }
  webm::Status OnTag(const webm::ElementMetadata&, const webm::Tag& tag) override {
    for (const auto& field : tag.tags) tags[field.value().name.value()] = field.value().string.value();
    return webm::Status(webm::Status::kOkCompleted);
  }
  webm::Status OnClusterBegin(const webm::ElementMetadata&, const webm::Cluster& cluster,
                              webm::Action* action) override {
    cluster_ms_ = std::int64_t(cluster.timecode.value());
    *action = webm::Action::kRead;
    return webm::Status(webm::Status::kOkCompleted);
  }
  webm::Status OnSimpleBlockEnd(const webm::ElementMetadata&, const webm::SimpleBlock& block) override {
    frames.push_back({cluster_ms_ + block.timecode, block.is_key_frame, color_, {}});
    return webm::Status(webm::Status::kOkCompleted);
  }
  webm::Status OnBlockGroupEnd(const webm::ElementMetadata&, const webm::BlockGroup& group) override {
    const auto& more = group.additions.value().block_mores.at(0).value();
    frames.push_back(
        {cluster_ms_ + group.block.value().timecode, group.references.empty(), color_, more.data.value()});
    return webm::Status(webm::Status::kOkCompleted);
  }
  webm::Status OnFrame(const webm::FrameMetadata&, webm::Reader* reader, std::uint64_t* left) override {
    color_.resize(*left);
    std::uint64_t read = 0;
    const webm::Status status = reader->Read(*left, color_.data(), &read);
    *left -= read;
    return status;
  }

  bool is_whole = false;
  std::map<webm::Id, std::vector<std::uint64_t>> begins;  // from the segment's first byte
  std::map<webm::Id, std::uint64_t> seeks;
  std::map<std::uint64_t, std::uint64_t> cues;  // ms: from the segment's first byte
  std::map<std::string, std::string> tags;
  webm::Info info;
  webm::TrackEntry track;
  std::vector<VideoFrame> frames;

 private:
  std::uint64_t segment_begin_ = 0;
  std::int64_t cluster_ms_ = 0;
  Bytes color_;
};

// Threads: one. Owns: the decoder.
class Vp9Decoder {
 public:
  Vp9Decoder() { vpx_codec_dec_init(&codec_, vpx_codec_vp9_dx(), nullptr, 0); }
  ~Vp9Decoder() { vpx_codec_destroy(&codec_); }
  // The next picture; null when there is none.
  const vpx_image_t* decode(const Bytes& frame) {
    if (vpx_codec_decode(&codec_, frame.data(), unsigned(frame.size()), nullptr, 0) != VPX_CODEC_OK)
      return nullptr;
    vpx_codec_iter_t at = nullptr;
    return vpx_codec_get_frame(&codec_, &at);
  }

 private:
  vpx_codec_ctx_t codec_ = {};
};

double luma_of(const vpx_image_t& image, int x, int y) {
  return (double(image.planes[VPX_PLANE_Y][y * image.stride[VPX_PLANE_Y] + x]) - 16) / 219;
}

// ITU-R BT.709-6, backwards, at a place with chroma of its own; 0 to 1.
std::array<double, 3> rgb_of(const vpx_image_t& image, int x, int y) {
  const double bright = luma_of(image, x, y);
  const auto chroma = [&](int plane) {
    return (double(image.planes[plane][y / 2 * image.stride[plane] + x / 2]) - 128) / 224;
  };
  const double red = bright + 1.5748 * chroma(VPX_PLANE_V), blue = bright + 1.8556 * chroma(VPX_PLANE_U);
  return {red, (bright - 0.2126 * red - 0.0722 * blue) / 0.7152, blue};
}

constexpr Extent kExtent = {72, 50};

// A square that wanders over a gradient; the square is opaque, of what is around it nothing shows where alpha is 0.
Image frame_image(int frame, int channels, Extent extent = kExtent) {
  Image image = make_image(extent, channels, SampleType::kUint8, ColorSpace::kSrgb);
  std::size_t i = 0;
  for (int y = 0; y < extent.height; ++y)
    for (int x = 0; x < extent.width; ++x) {
      const bool inside = std::abs(x - 2 * frame - 12) < 10 && std::abs(y - 24) < 10;
      const bool is_seen = inside || channels == 3;
      const int px[] = {inside ? 220 : 3 * x, inside ? 40 : 90, inside ? 60 : 2 * y, inside ? 255 : 0};
      for (int c = 0; c < channels; ++c)
        image.samples<std::uint8_t>()[i++] = std::uint8_t(is_seen ? px[c] : 0);
    }
  return image;
}

std::string video_of(int frames, double frames_per_second, int channels, int quality = 90,
                     Extent extent = kExtent) {
  const auto encoder = webm_video({frames, frames_per_second, 0}, quality,
                                  {{"Software", "Furnace"}, {"furnace:request", "7"}});
  for (int i = 0; i < frames; ++i) encoder->add(frame_image(i, channels, extent));
  return encoder->finish();
}

TEST(WebmVideo, HasEveryFrameAtItsTime) {
  const std::string file = video_of(25, 30, 3);
  EXPECT_EQ(video_of(25, 30, 3), file) << "the same frames, the same bytes";
  const Video video(file);
  ASSERT_TRUE(video.is_whole);
  ASSERT_EQ(video.frames.size(), 25u);
  for (int i = 0; i < 25; ++i) {
    EXPECT_EQ(video.frames[std::size_t(i)].time_ms, std::lround(i * 1000.0 / 30));
    EXPECT_EQ(video.frames[std::size_t(i)].is_key, i == 0);
  }
  EXPECT_NEAR(video.info.duration.value(), 25 * 1000.0 / 30, 1e-6);
  EXPECT_EQ(video.track.codec_id.value(), "V_VP9");
  EXPECT_EQ(video.track.video.value().pixel_width.value(), 72u);
  EXPECT_EQ(video.track.video.value().pixel_height.value(), 50u);
  EXPECT_FALSE(video.track.video.value().alpha_mode.is_present());
  EXPECT_EQ(video.tags.at("ENCODER"), "Furnace");
  EXPECT_EQ(video.tags.at("furnace:request"), "7");
}

// Of what is flat there is nothing to lose, so that matrix, range and the order of planes are seen.
TEST(WebmVideo, KeepsColors) {
  const Video video(video_of(3, 24, 3));
  const webm::Colour colour = video.track.video.value().colour.value();
  EXPECT_EQ(int(colour.matrix_coefficients.value()), 1);
  EXPECT_EQ(int(colour.range.value()), 1);
  EXPECT_EQ(int(colour.transfer_characteristics.value()), 13);
  Vp9Decoder decoder;
  for (int i = 0; i < 3; ++i) {
    const vpx_image_t* image = decoder.decode(video.frames[std::size_t(i)].color);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->cs, VPX_CS_BT_709);
    EXPECT_EQ(image->range, VPX_CR_STUDIO_RANGE);
    const Image expected = frame_image(i, 3);
    for (const auto& [x, y] : {std::pair{12, 24}, std::pair{60, 10}, std::pair{40, 44}, std::pair{2, 2}}) {
      const auto rgb = rgb_of(*image, x, y);
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(255 * rgb[c], expected.samples<std::uint8_t>()[std::size_t(y * 72 + x) * 3 + c], 6)
            << i << ": " << x << ", " << y;
    }
  }
}

// Chroma lies where it says that it does: a ramp of red stays in its place.
TEST(WebmVideo, ChromaLiesUponTheLeftColumn) {
  Image ramp = make_image({32, 8}, 3, SampleType::kUint8, ColorSpace::kSrgb);
  for (int i = 0; i < 32 * 8; ++i)
    ramp.samples<std::uint8_t>()[std::size_t(i) * 3] = std::uint8_t(8 * (i % 32));
  const auto encoder = webm_video({2, 24, 0}, 100, {});
  encoder->add(ramp);
  encoder->add(ramp);
  const Video video(encoder->finish());
  Vp9Decoder decoder;
  const vpx_image_t* image = decoder.decode(video.frames.at(0).color);
  ASSERT_TRUE(image);
  for (int x = 2; x < 30; x += 2) {
    const double expected = 128 + 224 * (1 - 0.2126) / 1.5748 * 8 * x / 255;
    EXPECT_NEAR(image->planes[VPX_PLANE_V][image->stride[VPX_PLANE_V] + x / 2], expected, 1.01) << x;
  }
}

TEST(WebmVideo, TransparencyIsASecondStream) {
  const Video video(video_of(12, 24, 4));
  ASSERT_TRUE(video.is_whole);
  EXPECT_EQ(video.track.video.value().alpha_mode.value(), 1u);
  ASSERT_EQ(video.frames.size(), 12u);
  Vp9Decoder color_decoder, alpha_decoder;
  for (int i = 0; i < 12; ++i) {
    const VideoFrame& frame = video.frames[std::size_t(i)];
    EXPECT_EQ(frame.is_key, i == 0);
    const vpx_image_t *color = color_decoder.decode(frame.color), *alpha = alpha_decoder.decode(frame.alpha);
    ASSERT_TRUE(color && alpha);
    const int middle = 2 * i + 12;
    for (const int x : {middle - 8, middle, middle + 8}) {
      EXPECT_NEAR(alpha->planes[VPX_PLANE_Y][24 * alpha->stride[VPX_PLANE_Y] + x], 255, 8) << i;
      EXPECT_NEAR(255 * rgb_of(*color, x, 24)[0], 220, 8) << i;
    }
    EXPECT_NEAR(alpha->planes[VPX_PLANE_Y][2 * alpha->stride[VPX_PLANE_Y] + 70], 0, 4) << i;
    // Nor does black, which nobody drew, come near the edge.
    EXPECT_NEAR(255 * rgb_of(*color, middle + 9, 24)[0], 220, 12) << i;
  }
}

TEST(WebmVideo, CanBeSought) {
  for (const int channels : {3, 4}) {
    const Video video(video_of(23, 2, channels));  // a key each 5 s
    ASSERT_TRUE(video.is_whole);
    std::vector<std::int64_t> keys_ms;
    for (const VideoFrame& frame : video.frames)
      if (frame.is_key) keys_ms.push_back(frame.time_ms);
    EXPECT_THAT(keys_ms, ElementsAre(0, 5000, 10000));
    const auto& clusters = video.begins.at(webm::Id::kCluster);
    ASSERT_EQ(clusters.size(), 3u);
    ASSERT_EQ(video.cues.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(video.cues.at(std::uint64_t(keys_ms[i])), clusters[i]);
    for (const webm::Id id : {webm::Id::kInfo, webm::Id::kTracks, webm::Id::kTags, webm::Id::kCues})
      EXPECT_EQ(video.seeks.at(id), video.begins.at(id).at(0));
    // What begins with a key needs nothing before it.
    Vp9Decoder color, alpha;
    EXPECT_TRUE(color.decode(video.frames[10].color));
    if (channels == 4) {
      EXPECT_TRUE(alpha.decode(video.frames[10].alpha));
    }
  }
}

// Rates so low that a frame stands longer than a cluster can count, and sides of any parity.
TEST(WebmVideo, TakesAnyRateAndSize) {
  const Video slow(video_of(5, 0.1, 3));
  ASSERT_TRUE(slow.is_whole);
  ASSERT_EQ(slow.frames.size(), 5u);
  EXPECT_EQ(slow.frames[4].time_ms, 40'000);
  for (const Extent extent : {Extent{1, 1}, Extent{2, 3}, Extent{33, 17}, Extent{300, 7}, Extent{5, 260}}) {
    const Video video(video_of(3, 120, 4, 50, extent));
    ASSERT_EQ(video.frames.size(), 3u) << extent.width;
    Vp9Decoder decoder;
    for (const VideoFrame& frame : video.frames) {
      const vpx_image_t* image = decoder.decode(frame.color);
      ASSERT_TRUE(image);
      EXPECT_EQ((Extent{int(image->d_w), int(image->d_h)}), extent);
    }
  }
}

TEST(WebmVideo, QualityIsSize) {
  std::vector<std::ptrdiff_t> growth;
  std::size_t before = 0;
  for (const int quality : {1, 50, 90, 100}) {
    const std::size_t size = video_of(10, 24, 3, quality).size();
    growth.push_back(std::ptrdiff_t(size) - std::ptrdiff_t(before));
    before = size;
  }
  EXPECT_THAT(growth, Each(Gt(0)));
}

}  // namespace
}  // namespace furnace
