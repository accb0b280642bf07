// RFC 8794 (2020), "Extensible Binary Meta Language"; RFC 9559 (2024), "Matroska Media Container Format", of which WebM is a part.
#include "renderer/image/webm_container.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "renderer/base/check.hpp"

namespace furnace {
namespace {

enum class Id : std::uint32_t {
  kEbml = 0x1A45DFA3,
  kEbmlVersion = 0x4286,
  kEbmlReadVersion = 0x42F7,
  kEbmlMaxIdLength = 0x42F2,
  kEbmlMaxSizeLength = 0x42F3,
  kDocType = 0x4282,
  kDocTypeVersion = 0x4287,
  kDocTypeReadVersion = 0x4285,
  kSegment = 0x18538067,
  kSeekHead = 0x114D9B74,
  kSeek = 0x4DBB,
  kSeekId = 0x53AB,
  kSeekPosition = 0x53AC,
  kInfo = 0x1549A966,
  kTimestampScale = 0x2AD7B1,
  kDuration = 0x4489,
  kMuxingApp = 0x4D80,
  kWritingApp = 0x5741,
  kTracks = 0x1654AE6B,
  kTrackEntry = 0xAE,
  kTrackNumber = 0xD7,
  kTrackUid = 0x73C5,
  kTrackType = 0x83,
  kFlagLacing = 0x9C,
  kLanguage = 0x22B59C,
  kCodecId = 0x86,
  kDefaultDuration = 0x23E383,
  kMaxBlockAdditionId = 0x55EE,
  kVideo = 0xE0,
  kFlagInterlaced = 0x9A,
  kAlphaMode = 0x53C0,
  kPixelWidth = 0xB0,
  kPixelHeight = 0xBA,
  kColour = 0x55B0,
  kMatrixCoefficients = 0x55B1,
  kBitsPerChannel = 0x55B2,
  kChromaSubsamplingHorz = 0x55B3,
  kChromaSubsamplingVert = 0x55B4,
  kChromaSitingHorz = 0x55B7,
  kChromaSitingVert = 0x55B8,
  kRange = 0x55B9,
  kTransferCharacteristics = 0x55BA,
  kPrimaries = 0x55BB,
  kTags = 0x1254C367,
  kTag = 0x7373,
  kTargets = 0x63C0,
  kSimpleTag = 0x67C8,
  kTagName = 0x45A3,
  kTagString = 0x4487,
  kCues = 0x1C53BB6B,
  kCuePoint = 0xBB,
  kCueTime = 0xB3,
  kCueTrackPositions = 0xB7,
  kCueTrack = 0xF7,
  kCueClusterPosition = 0xF1,
  kCluster = 0x1F43B675,
  kTimestamp = 0xE7,
  kSimpleBlock = 0xA3,
  kBlockGroup = 0xA0,
  kBlock = 0xA1,
  kReferenceBlock = 0xFB,
  kBlockAdditions = 0x75A1,
  kBlockMore = 0xA6,
  kBlockAddId = 0xEE,
  kBlockAdditional = 0xA5,
};

constexpr std::uint64_t kTrack = 1;
constexpr double kMsPerSecond = 1000, kNsPerSecond = 1e9;

std::string big_endian(std::uint64_t value, int bytes) {
  std::string out;
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xFF);
  return out;
}

int bytes_of(std::uint64_t value) {
  return std::max(1, (int(std::bit_width(value)) + 7) / 8);
}

// RFC 8794, section 4: as short as it can be; all ones would be an unknown size.
std::string variable_size(std::uint64_t size) {
  int bytes = 1;
  while (size >= (1ull << 7 * bytes) - 1) ++bytes;
  return big_endian(size | 1ull << 7 * bytes, bytes);
}

std::string id_bytes(Id id) {
  const auto value = static_cast<std::uint32_t>(id);
  return big_endian(value, bytes_of(value));
}

std::string element(Id id, std::string_view payload) {
  std::string out = id_bytes(id) + variable_size(payload.size());
  out += payload;
  return out;
}

std::string number(Id id, std::uint64_t value) {
  return element(id, big_endian(value, bytes_of(value)));
}

// Eight bytes whatever the value, so that what it says does not move what it speaks of.
std::string position(Id id, std::uint64_t value) {
  return element(id, big_endian(value, 8));
}

std::string head() {
  return element(Id::kEbml, number(Id::kEbmlVersion, 1) + number(Id::kEbmlReadVersion, 1) +
                                number(Id::kEbmlMaxIdLength, 4) + number(Id::kEbmlMaxSizeLength, 8) +
                                element(Id::kDocType, "webm") + number(Id::kDocTypeVersion, 4) +
                                number(Id::kDocTypeReadVersion, 2));
}

std::string info(double duration_ms) {
  constexpr std::uint64_t kNsPerMs = 1'000'000;
  return element(Id::kInfo,
                 number(Id::kTimestampScale, kNsPerMs) +
                     element(Id::kDuration, big_endian(std::bit_cast<std::uint64_t>(duration_ms), 8)) +
                     element(Id::kMuxingApp, "Furnace") + element(Id::kWritingApp, "Furnace"));
}

// ITU-T H.273 (2021): the numbers of matrix, transfer function and primaries.
std::string colour() {
  constexpr std::uint64_t kBt709 = 1, kSrgbTransfer = 13, kLimited = 1, kHalved = 1, kAtLeft = 1,
                          kBetween = 2;
  return element(Id::kColour,
                 number(Id::kMatrixCoefficients, kBt709) + number(Id::kBitsPerChannel, 8) +
                     number(Id::kChromaSubsamplingHorz, kHalved) +
                     number(Id::kChromaSubsamplingVert, kHalved) + number(Id::kChromaSitingHorz, kAtLeft) +
                     number(Id::kChromaSitingVert, kBetween) + number(Id::kRange, kLimited) +
                     number(Id::kTransferCharacteristics, kSrgbTransfer) + number(Id::kPrimaries, kBt709));
}

std::string tracks(Extent extent, double frame_s, bool has_alpha) {
  constexpr std::uint64_t kIsVideo = 1, kProgressive = 2;
  std::string video = number(Id::kFlagInterlaced, kProgressive) +
                      number(Id::kPixelWidth, std::uint64_t(extent.width)) +
                      number(Id::kPixelHeight, std::uint64_t(extent.height));
  if (has_alpha) video += number(Id::kAlphaMode, 1);
  std::string entry = number(Id::kTrackNumber, kTrack) + number(Id::kTrackUid, kTrack) +
                      number(Id::kTrackType, kIsVideo) + number(Id::kFlagLacing, 0) +
                      element(Id::kLanguage, "und") + element(Id::kCodecId, "V_VP9") +
                      number(Id::kDefaultDuration, std::uint64_t(std::llround(frame_s * kNsPerSecond)));
  if (has_alpha) entry += number(Id::kMaxBlockAdditionId, 1);
  return element(Id::kTracks, element(Id::kTrackEntry, entry + element(Id::kVideo, video + colour())));
}

std::string tags(const std::vector<TextField>& metadata) {
  std::string fields = element(Id::kTargets, "");
  for (const TextField& field : metadata)
    fields += element(Id::kSimpleTag, element(Id::kTagName, field.key == "Software" ? "ENCODER" : field.key) +
                                          element(Id::kTagString, field.value));
  return element(Id::kTags, element(Id::kTag, fields));
}

// Frames from one key to the next; its time is that of the first.
struct Cluster {
  std::uint64_t time_ms;
  std::string bytes;
};

std::string block(std::int64_t relative_ms, unsigned flags, const std::string& bytes) {
  FURNACE_CHECK(relative_ms <= INT16_MAX, "a frame {} ms after its key", relative_ms);
  return variable_size(kTrack) + big_endian(std::uint64_t(relative_ms), 2) + static_cast<char>(flags) + bytes;
}

std::vector<Cluster> clusters(double frame_ms, std::span<const Vp9Frame> color,
                              std::span<const Vp9Frame> alpha) {
  constexpr unsigned kIsKey = 0x80;
  std::vector<Cluster> out;
  const auto time_ms = [&](std::size_t frame) { return std::llround(double(frame) * frame_ms); };
  for (std::size_t i = 0; i < color.size(); ++i) {
    if (color[i].is_key) {
      const auto now_ms = std::uint64_t(time_ms(i));
      out.push_back({now_ms, number(Id::kTimestamp, now_ms)});
    }
    Cluster& cluster = out.back();
    const std::int64_t relative_ms = time_ms(i) - std::int64_t(cluster.time_ms);
    if (alpha.empty()) {
      cluster.bytes +=
          element(Id::kSimpleBlock, block(relative_ms, color[i].is_key ? kIsKey : 0, color[i].bytes));
      continue;
    }
    std::string group = element(Id::kBlock, block(relative_ms, 0, color[i].bytes));
    if (!color[i].is_key)  // of a frame that needs the one before, signed
      group += element(Id::kReferenceBlock, big_endian(std::uint64_t(time_ms(i - 1) - time_ms(i)), 8));
    const std::string more =
        element(Id::kBlockMore, number(Id::kBlockAddId, 1) + element(Id::kBlockAdditional, alpha[i].bytes));
    cluster.bytes += element(Id::kBlockGroup, group + element(Id::kBlockAdditions, more));
  }
  for (Cluster& cluster : out) cluster.bytes = element(Id::kCluster, cluster.bytes);
  return out;
}

std::string cues(std::span<const Cluster> clusters, std::uint64_t begin) {
  std::string points;
  for (const Cluster& cluster : clusters) {
    points += element(Id::kCuePoint,
                      number(Id::kCueTime, cluster.time_ms) +
                          element(Id::kCueTrackPositions,
                                  number(Id::kCueTrack, kTrack) + position(Id::kCueClusterPosition, begin)));
    begin += cluster.bytes.size();
  }
  return element(Id::kCues, points);
}

struct Place {
  Id id;
  std::uint64_t begin;  // from the segment's first byte
};

std::string seek_head(std::span<const Place> places) {
  std::string seeks;
  for (const Place& place : places)
    seeks += element(Id::kSeek,
                     element(Id::kSeekId, id_bytes(place.id)) + position(Id::kSeekPosition, place.begin));
  return element(Id::kSeekHead, seeks);
}

}  // namespace

std::string webm_file(Extent extent, const AnimationTiming& timing, std::span<const Vp9Frame> color,
                      std::span<const Vp9Frame> alpha, const std::vector<TextField>& metadata) {
  FURNACE_CHECK(!color.empty() && color.front().is_key && (alpha.empty() || alpha.size() == color.size()),
                "{} frames with {} of alpha", color.size(), alpha.size());
  const double frame_s = 1 / timing.frames_per_second;
  const std::vector<Cluster> parts = clusters(frame_s * kMsPerSecond, color, alpha);
  const std::string about = info(double(color.size()) * frame_s * kMsPerSecond),
                    track = tracks(extent, frame_s, !alpha.empty()), words = tags(metadata);
  // What stands where depends on sizes alone, and no size on what stands where.
  Place places[] = {{Id::kInfo, 0}, {Id::kTracks, 0}, {Id::kTags, 0}, {Id::kCues, 0}};
  places[0].begin = seek_head(places).size();
  places[1].begin = places[0].begin + about.size();
  places[2].begin = places[1].begin + track.size();
  places[3].begin = places[2].begin + words.size();
  std::string body = seek_head(places) + about + track + words;
  body += cues(parts, places[3].begin + cues(parts, 0).size());
  for (const Cluster& cluster : parts) body += cluster.bytes;
  return head() + element(Id::kSegment, body);
}

}  // namespace furnace
