// Buffer views as the library and an encoder of our own compress them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include <meshoptimizer.h>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {

using Bytes = std::vector<std::uint8_t>;

// Smooth in most bytes, noise in some, constant in others: every width of deltas occurs.
inline Bytes sample_elements(std::size_t count, std::size_t stride) {
  std::mt19937 random(unsigned(count * 1000 + stride));
  Bytes bytes(count * stride);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < stride; ++k) {
      const unsigned noise = random() >> 8;
      const std::array<unsigned, 5> kinds{unsigned(i * k / 3), noise, 7u, unsigned(i) + noise % 4,
                                          noise % 40 == 0 ? noise : unsigned(i / 50)};
      bytes[i * stride + k] = std::uint8_t(kinds[k % kinds.size()]);
    }
  }
  return bytes;
}

inline Bytes encoded_by_library(const Bytes& elements, std::size_t stride) {
  const std::size_t count = elements.size() / stride;
  meshopt_encodeVertexVersion(0);
  Bytes out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), elements.data(), count, stride));
  return out;
}

// Writes version 1 with the first control mode that can hold each byte, or a wasteful one of `spread`.
class Version1 {
 public:
  Version1(std::size_t stride, std::vector<std::uint8_t> modes, unsigned spread)
      : stride_(stride), modes_(std::move(modes)), random_(spread) {}

  Bytes encode(const Bytes& elements) {
    out_ = {0xa1};
    const std::size_t count = elements.size() / stride_;
    const std::size_t block = std::min<std::size_t>(8192 / stride_ & ~15u, 256);
    Bytes last(elements.begin(), elements.begin() + std::ptrdiff_t(stride_));
    const Bytes baseline = last;
    for (std::size_t at = 0; at < count; at += block) {
      write_block(elements, at, std::min(block, count - at), last);
    }
    const std::size_t tail = stride_ + stride_ / 4;
    out_.resize(out_.size() + (tail < 24 ? 24 - tail : 0), 0);
    out_.insert(out_.end(), baseline.begin(), baseline.end());
    out_.insert(out_.end(), modes_.begin(), modes_.end());
    return out_;
  }

 private:
  static std::uint32_t word(const std::uint8_t* p) {
    return p[0] | p[1] << 8 | p[2] << 16 | std::uint32_t(p[3]) << 24;
  }
  template <class T>
  static T zigzag(T v) {
    return T(v >> (8 * sizeof(T) - 1) ? ~(v << 1) : v << 1);
  }

  std::uint32_t delta(std::uint32_t value, std::uint32_t last, std::uint8_t mode) const {
    if ((mode & 15) == 2) return std::rotl(value ^ last, mode >> 4);
    std::uint32_t result = 0;
    const unsigned step = (mode & 15) == 1 ? 16 : 8;
    for (unsigned shift = 0; shift < 32; shift += step) {
      const std::uint32_t difference = (value >> shift) - (last >> shift);
      result |= (step == 16 ? std::uint32_t(zigzag(std::uint16_t(difference)))
                            : std::uint32_t(zigzag(std::uint8_t(difference))))
                << shift;
    }
    return result;
  }

  void write_block(const Bytes& elements, std::size_t first, std::size_t count, Bytes& last) {
    std::vector<Bytes> deltas(stride_, Bytes((count + 15) / 16 * 16, 0));
    for (std::size_t c = 0; c < stride_; c += 4) {
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t* value = &elements[(first + i) * stride_ + c];
        const std::uint32_t d = delta(word(value), word(&last[c]), modes_[c / 4]);
        for (std::size_t k = 0; k < 4; ++k) deltas[c + k][i] = std::uint8_t(d >> (8 * k));
        std::copy_n(value, 4, &last[c]);
      }
    }
    Bytes controls(stride_ / 4, 0), data;
    for (std::size_t k = 0; k < stride_; ++k) {
      const bool zeros =
          std::all_of(deltas[k].begin(), deltas[k].end(), [](std::uint8_t d) { return d == 0; });
      const unsigned control = zeros && random_() % 2 ? 2 : random_() % 4 == 0 ? 3 : random_() % 2;
      controls[k / 4] |= std::uint8_t(control << (k % 4 * 2));
      write_bytes(deltas[k], count, control, data);
    }
    out_.insert(out_.end(), controls.begin(), controls.end());
    out_.insert(out_.end(), data.begin(), data.end());
  }

  void write_bytes(const Bytes& deltas, std::size_t count, unsigned control, Bytes& data) {
    if (control == 2) return;
    if (control == 3) {
      data.insert(data.end(), deltas.begin(), deltas.begin() + std::ptrdiff_t(count));
      return;
    }
    const std::array<unsigned, 4> widths =
        control == 0 ? std::array<unsigned, 4>{0, 1, 2, 4} : std::array<unsigned, 4>{1, 2, 4, 8};
    Bytes header((deltas.size() / 16 + 3) / 4, 0), groups;
    for (std::size_t g = 0; g < deltas.size() / 16; ++g) {
      unsigned mode = unsigned(random_() % 4);
      const auto group = std::span(deltas).subspan(g * 16, 16);
      const bool zeros = std::all_of(group.begin(), group.end(), [](std::uint8_t d) { return d == 0; });
      if (widths[mode] == 0 && !zeros) mode = 3;
      header[g / 4] |= std::uint8_t(mode << (g % 4 * 2));
      write_group(group, widths[mode], groups);
    }
    data.insert(data.end(), header.begin(), header.end());
    data.insert(data.end(), groups.begin(), groups.end());
  }

  static void write_group(std::span<const std::uint8_t> group, unsigned bits, Bytes& out) {
    if (bits == 0) return;
    if (bits == 8) {
      out.insert(out.end(), group.begin(), group.end());
      return;
    }
    const unsigned sentinel = (1u << bits) - 1, per_byte = 8 / bits;
    Bytes packed(2 * bits, 0), extra;
    for (unsigned i = 0; i < 16; ++i) {
      const unsigned code = std::min<unsigned>(group[i], sentinel);
      const unsigned place = bits == 1 ? i % 8 : (per_byte - 1 - i % per_byte) * bits;
      packed[i / per_byte] |= std::uint8_t(code << place);
      if (code == sentinel) extra.push_back(group[i]);
    }
    out.insert(out.end(), packed.begin(), packed.end());
    out.insert(out.end(), extra.begin(), extra.end());
  }

  const std::size_t stride_;
  const std::vector<std::uint8_t> modes_;
  std::mt19937 random_;
  Bytes out_;
};

// A triangle whose positions and indices are compressed, the plain buffer a placeholder.
inline GltfBuilder compressed_triangle(const std::string& name) {
  GltfBuilder builder;
  const std::vector<float> positions{0, 0, 0, 2, 0, 0, 0, 2, 0};
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(positions.data());
  const Bytes vertices = encoded_by_library({bytes, bytes + 36}, 12);
  const std::vector<std::uint32_t> triangle{0, 1, 2};
  Bytes indices(meshopt_encodeIndexBufferBound(3, 3));
  indices.resize(meshopt_encodeIndexBuffer(indices.data(), indices.size(), triangle.data(), 3));
  const auto add = [&](const Bytes& file, std::size_t at, std::size_t count, std::size_t stride,
                       const char* mode) {
    const int view = builder.add_view(file);
    Json& json = builder.json["bufferViews"][std::size_t(view)];
    const Json compressed = {{"buffer", 0},
                             {"byteOffset", json["byteOffset"]},
                             {"byteLength", file.size()},
                             {"byteStride", stride},
                             {"count", count},
                             {"mode", mode}};
    json = {{"buffer", 1}, {"byteOffset", at}, {"byteLength", count * stride}};
    json["extensions"][name] = compressed;
    return view;
  };
  const int vertex_view = add(vertices, 0, 3, 12, "ATTRIBUTES"),
            index_view = add(indices, 36, 3, 2, "TRIANGLES");
  const int position = builder.add(
      "accessors", {{"bufferView", vertex_view}, {"type", "VEC3"}, {"componentType", 5126}, {"count", 3}});
  const int index = builder.add(
      "accessors", {{"bufferView", index_view}, {"type", "SCALAR"}, {"componentType", 5123}, {"count", 3}});
  builder.show({{"attributes", {{"POSITION", position}}}, {"indices", index}});
  builder.json["extensionsRequired"] = builder.json["extensionsUsed"] = {name};
  return builder;
}

// `placeholder`: what the second buffer says of itself.
inline ModelBundle with_placeholder(const GltfBuilder& builder, Json placeholder) {
  ModelBundle bundle = builder.bundle();
  Json document = Json::parse(bundle.document.text());
  placeholder["byteLength"] = 4200;
  document["buffers"].push_back(std::move(placeholder));
  bundle.document = Blob(document.dump());
  bundle.seal();
  return bundle;
}

}  // namespace furnace::testing
