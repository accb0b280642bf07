// What can be asked of a decoder, each as one struct: its arguments, the function, the largest answer, and how an answer is
// judged that comes from a process which may lie. A new job: a JobKind, a struct here, a row in `decode_jobs`, a method of
// Decoder.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "renderer/decode/wire.hpp"
#include "renderer/image/decode.hpp"

namespace furnace::decode {

enum class JobKind : std::uint8_t {
  kTexture = 1,
  kEnvironment = 2,
  kFirstOfTests = 200,  // no program that ships knows these
};

using Bytes = std::span<const std::byte>;

struct TextureJob {
  using Result = Image;
  static constexpr JobKind kKind = JobKind::kTexture;
  static constexpr std::string_view kName = "texture";

  ColorSpace color_space = ColorSpace::kNonColor;
  DecodeLimits limits;

  Image run(Bytes file) const { return decode_texture(file, color_space, limits); }
  std::int64_t largest_result_bytes() const;
  bool accepts(const Image& image) const;
};

struct EnvironmentJob {
  using Result = DecodedEnvironment;
  static constexpr JobKind kKind = JobKind::kEnvironment;
  static constexpr std::string_view kName = "environment";

  DecodeLimits limits;

  DecodedEnvironment run(Bytes file) const { return decode_environment(file, limits); }
  std::int64_t largest_result_bytes() const;
  bool accepts(const DecodedEnvironment& environment) const;
};

// Whether it has the shape that the limits allow, and as many bytes as that shape needs.
bool is_whole(const Image& image, const DecodeLimits& limits);

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DecodeLimits>& limits) {
  wire.number(limits.max_side_px);
  wire.number(limits.max_area_px);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, Image>& image) {
  wire.number(image.extent.width);
  wire.number(image.extent.height);
  wire.number(image.channels);
  wire.choice(image.type, SampleType::kFloat32);
  wire.choice(image.color_space, ColorSpace::kNonColor);
  wire.array(image.pixels);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DecodedEnvironment>& environment) {
  fields(wire, environment.equirect);
  wire.number(environment.repairs.nan_samples);
  wire.number(environment.repairs.infinite_samples);
  wire.number(environment.repairs.negative_samples);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, TextureJob>& job) {
  wire.choice(job.color_space, ColorSpace::kNonColor);
  fields(wire, job.limits);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, EnvironmentJob>& job) {
  fields(wire, job.limits);
}

}  // namespace furnace::decode
