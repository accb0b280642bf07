// Images -> file bytes in memory. Same image, same bytes.
#pragma once

#include "renderer/image/image.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace furnace {

struct TextField {
  std::string key;
  std::string value;
};

// kUint8 or kUint16 sRGB, 3 or 4 channels (straight alpha), tagged sRGB. Settings were chosen by bench: encoding must
// cost less than drawing the picture did. Errors: kInternal when the codec refuses. Threads: any.
std::string encode_png(const Image& image, const std::vector<TextField>& metadata);

// Linear RGB(A), alpha premultiplied, channels R G B (A), kFloat16 or kFloat32 as the image's type says.
// Tagged with its primaries and white. Without a `compression`: PIZ for kFloat16, ZIP for kFloat32.
enum class ExrCompression { kNone, kZip, kPiz, kDwaa };  // kDwaa is lossy
std::string encode_exr(const Image& image, const std::vector<TextField>& metadata,
                       std::optional<ExrCompression> compression = {});

// A picture beside another of the same size.
struct ImageLayer {
  std::string name;      // unique in its file, without a period
  std::string channels;  // a letter each, in the order of the image's; all different
  Image image;           // kFloat16 or kFloat32
};
// The same with layers in one part: channels NAME.LETTER. Without a `compression`: ZIP, whose blocks compositors read fastest.
std::string encode_exr_layers(const Image& image, const std::vector<ImageLayer>& layers,
                              const std::vector<TextField>& metadata,
                              std::optional<ExrCompression> compression = {});

// kUint8 sRGB, 1 or 3 channels: baseline, chroma not halved; metadata as comments. `quality` is libjpeg's, 1 to 100.
std::string encode_jpeg(const Image& image, int quality, const std::vector<TextField>& metadata);

struct WebpSettings {
  bool lossless = false;  // exact where alpha is not 0
  int quality = 90;       // libwebp's, 1 to 100, of what is not lossless; alpha always is
};
// kUint8 sRGB, 3 or 4 channels (straight alpha), at most kMaxWebpSidePx a side; metadata as XMP, where a key is "Software" or
// begins with "furnace:".
inline constexpr int kMaxWebpSidePx = 16383;
std::string encode_webp(const Image& image, const WebpSettings& settings,
                        const std::vector<TextField>& metadata);

// Pictures one after the other in one file, which does not keep them as images.
// Threads: one. Owns: what it has written.
class AnimationEncoder {
 public:
  virtual ~AnimationEncoder() = default;
  // All of one extent, type and number of channels.
  virtual void add(const Image& frame) = 0;
  // After as many frames as were announced.
  virtual std::string finish() = 0;
};
struct AnimationTiming {
  int frames = 2;
  double frames_per_second = 24;  // [0.1, 120]
  int loops = 0;                  // 0: for ever
};
// Frames as of encode_png and of encode_webp, each shown alone, with its alpha. Errors: as theirs.
std::unique_ptr<AnimationEncoder> png_animation(const AnimationTiming& timing,
                                                const std::vector<TextField>& metadata);
std::unique_ptr<AnimationEncoder> webp_animation(const AnimationTiming& timing, const WebpSettings& settings,
                                                 const std::vector<TextField>& metadata);
// VP9 with halved chroma, in WebM: BT.709 with sRGB's transfer function, a frame every 5 s that can be sought. kUint8 sRGB, 3 or 4
// channels (straight alpha); `quality` 1 to 100, of alpha too; of `timing` no loops, which is the player's. Errors: as theirs.
std::unique_ptr<AnimationEncoder> webm_video(const AnimationTiming& timing, int quality,
                                             const std::vector<TextField>& metadata);

}  // namespace furnace
