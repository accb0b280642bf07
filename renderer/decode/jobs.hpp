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

// Bindings name every member: a type that grows does not compile until its new member has a place here.

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DecodeLimits>& limits) {
  auto& [max_side_px, max_area_px] = limits;
  wire.number(max_side_px);
  wire.number(max_area_px);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, Image>& image) {
  auto& [extent, channels, type, color_space, pixels] = image;
  wire.number(extent.width);
  wire.number(extent.height);
  wire.number(channels);
  wire.choice(type, SampleType::kFloat32);
  wire.choice(color_space, ColorSpace::kNonColor);
  wire.array(pixels);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, RepairReport>& repairs) {
  auto& [nan_samples, infinite_samples, negative_samples] = repairs;
  wire.number(nan_samples);
  wire.number(infinite_samples);
  wire.number(negative_samples);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DecodedEnvironment>& environment) {
  auto& [equirect, repairs] = environment;
  fields(wire, equirect);
  fields(wire, repairs);
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
