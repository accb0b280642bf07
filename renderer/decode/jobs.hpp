// What can be asked of a decoder, each as one struct: its arguments, the function, the largest answer, and how an answer is
// judged that comes from a process which may lie. A new job: a JobKind, a struct here, a row in `decode_jobs`, a method of
// Decoder.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "renderer/decode/wire.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/scene/plain_model.hpp"

namespace furnace::decode {

enum class JobKind : std::uint8_t {
  kTexture = 1,
  kEnvironment = 2,
  kModel = 3,
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

struct ModelJob {
  using Result = PlainModel;
  static constexpr JobKind kKind = JobKind::kModel;
  static constexpr std::string_view kName = "model";

  ModelFormat format = ModelFormat::kObj;
  std::uint64_t document_bytes = 0;  // of the file; behind them the text of its materials
  PlainModelLimits limits;

  PlainModel run(Bytes file) const;
  std::int64_t largest_result_bytes() const;
  bool accepts(const PlainModel& model) const { return is_sound(model, limits); }
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
void fields(Wire& wire, WireValue<Wire, PlainModelLimits>& limits) {
  auto& [max_vertices, max_elements, max_bytes, max_materials] = limits;
  wire.number(max_vertices);
  wire.number(max_elements);
  wire.number(max_bytes);
  wire.number(max_materials);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, PlainModel>& model) {
  auto& [text, materials, parts, positions, normals, uvs, colors, indices] = model;
  wire.array(text);
  wire.array(materials);
  wire.array(parts);
  wire.array(positions);
  wire.array(normals);
  wire.array(uvs);
  wire.array(colors);
  wire.array(indices);
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

template <class Wire>
void fields(Wire& wire, WireValue<Wire, ModelJob>& job) {
  wire.choice(job.format, ModelFormat::kPly);
  wire.number(job.document_bytes);
  fields(wire, job.limits);
}

}  // namespace furnace::decode
