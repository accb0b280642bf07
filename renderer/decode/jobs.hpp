// What can be asked of a decoder, each as one struct: its arguments, the function, the largest answer, and how an answer is
// judged that comes from a process which may lie. A new job: a JobKind, a struct here, a row in `decode_jobs`, a method of
// Decoder.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/decode/wire.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/scene/draco_decode.hpp"
#include "renderer/scene/meshopt_decode.hpp"
#include "renderer/scene/plain_model.hpp"

namespace furnace::decode {

enum class JobKind : std::uint8_t {
  kTexture = 1,
  kEnvironment = 2,
  kDraco = 3,
  kMeshopt = 4,
  kModel = 5,
  kFirstOfTests = 200,  // no program that ships knows these
};

using Bytes = std::span<const std::byte>;

struct TextureJob {
  using Result = DecodedTexture;
  static constexpr JobKind kKind = JobKind::kTexture;
  static constexpr std::string_view kName = "texture";

  ColorSpace color_space = ColorSpace::kNonColor;
  DecodeLimits limits;

  DecodedTexture run(Bytes file) const { return decode_texture(file, color_space, limits); }
  std::int64_t largest_result_bytes() const;
  bool accepts(const DecodedTexture& texture) const;
};

struct EnvironmentJob {
  using Result = DecodedEnvironment;
  static constexpr JobKind kKind = JobKind::kEnvironment;
  static constexpr std::string_view kName = "environment";

  DecodeLimits limits;
  EnvironmentLayout layout = EnvironmentLayout::kAuto;

  DecodedEnvironment run(Bytes file) const { return decode_environment(file, limits, layout); }
  std::int64_t largest_result_bytes() const;
  bool accepts(const DecodedEnvironment& environment) const;
};

struct DracoJob {
  using Result = DracoMesh;
  static constexpr JobKind kKind = JobKind::kDraco;
  static constexpr std::string_view kName = "draco";

  DracoRequest request;  // one that check_draco_request takes

  DracoMesh run(Bytes file) const { return decode_draco(file, request); }
  std::int64_t largest_result_bytes() const;
  bool accepts(const DracoMesh& mesh) const;
};

struct MeshoptElements {
  std::vector<std::byte> bytes;
};

struct MeshoptJob {
  using Result = MeshoptElements;
  static constexpr JobKind kKind = JobKind::kMeshopt;
  static constexpr std::string_view kName = "meshopt";

  MeshoptLayout layout;  // a sound one

  MeshoptElements run(Bytes file) const { return {decode_meshopt(file, layout)}; }
  std::int64_t largest_result_bytes() const { return std::int64_t(layout.count * layout.stride); }
  bool accepts(const MeshoptElements& elements) const {
    return elements.bytes.size() == layout.count * layout.stride;
  }
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

// What a list may have, and a text in one.
inline constexpr std::size_t kMostLevels = 31, kMostRemarks = 8;
inline constexpr std::size_t kMostCodeBytes = 64, kMostRemarkBytes = 512;

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
void fields(Wire& wire, WireValue<Wire, TextureRemark>& remark) {
  auto& [code, message] = remark;
  wire.text(code, kMostCodeBytes);
  wire.text(message, kMostRemarkBytes);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DecodedTexture>& texture) {
  auto& [levels, remarks] = texture;
  wire.list(levels, kMostLevels, [&](auto& level) { fields(wire, level); });
  wire.list(remarks, kMostRemarks, [&](auto& remark) { fields(wire, remark); });
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
  auto& [equirect, repairs, layout] = environment;
  fields(wire, equirect);
  fields(wire, repairs);
  wire.choice(layout, kLastEnvironmentLayout);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DracoAttribute>& attribute) {
  auto& [id, component, components] = attribute;
  wire.number(id);
  auto code = std::uint16_t(component);
  wire.number(code);
  if constexpr (Wire::kReads) component = DracoComponent(code);
  wire.number(components);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DracoRequest>& request) {
  auto& [attributes, vertices, most_triangles, most_bytes] = request;
  wire.list(attributes, kMostDracoAttributes, [&](auto& attribute) { fields(wire, attribute); });
  wire.number(vertices);
  wire.number(most_triangles);
  wire.number(most_bytes);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DracoMesh>& mesh) {
  auto& [indices, attributes] = mesh;
  wire.array(indices);
  wire.list(attributes, kMostDracoAttributes, [&](auto& attribute) { wire.array(attribute); });
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, MeshoptLayout>& layout) {
  auto& [mode, filter, count, stride] = layout;
  wire.choice(mode, MeshoptMode::kIndices);
  wire.choice(filter, MeshoptFilter::kColor);
  wire.number(count);
  wire.number(stride);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, MeshoptElements>& elements) {
  wire.array(elements.bytes);
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
  wire.choice(job.layout, kLastEnvironmentLayout);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, DracoJob>& job) {
  fields(wire, job.request);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, MeshoptJob>& job) {
  fields(wire, job.layout);
}

template <class Wire>
void fields(Wire& wire, WireValue<Wire, ModelJob>& job) {
  wire.choice(job.format, ModelFormat::kPly);
  wire.number(job.document_bytes);
  fields(wire, job.limits);
}

}  // namespace furnace::decode
