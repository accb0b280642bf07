// What the readers of materials and of their extensions share: numbers kept in range, references to textures.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "renderer/scene/gltf_read.hpp"

namespace furnace {

inline constexpr double kFloatMax = 1e30;  // leaves room for products in single precision

// A material's numbers, kept in range.
// Threads: one. Owns: nothing.
class Factors {
 public:
  Factors(const JsonObject& json, std::vector<Note>& notes) : json_(json), notes_(notes) {}

  float number(std::string_view key, double fallback, double low, double high) {
    return in_range(key, json_.number(key, fallback), low, high);
  }
  template <int N>
  glm::vec<N, float> vector(std::string_view key, glm::vec<N, float> fallback, double high = 1) {
    const auto values = json_.vector<N>(key);
    if (!values) return fallback;
    for (int i = 0; i < N; ++i) fallback[i] = in_range(key, (*values)[static_cast<std::size_t>(i)], 0, high);
    return fallback;
  }

 private:
  float in_range(std::string_view key, double value, double low, double high) {
    const double clamped = std::clamp(value, low, high);
    if (clamped != value) {
      notes_.push_back(
          {"value-clamped", json_.pointer_to(key), "is out of range and was brought back into it"});
    }
    return static_cast<float>(clamped);
  }

  const JsonObject& json_;
  std::vector<Note>& notes_;
};

// Errors: kUnprocessable for what single precision does not hold with room to spare.
inline float bounded(const JsonObject& json, std::string_view key, double value) {
  if (std::abs(value) > kFloatMax) json.refuse(key, "is too large");
  return static_cast<float>(value);
}

// gltf_read_material.cpp
std::optional<GltfTextureRef> read_texture_ref(const JsonObject& owner, std::string_view key,
                                               const GltfCounts& counts);

// gltf_read_layers.cpp: the ratified extensions that add lobes, and the archived specular-glossiness. `json` is the
// material.
void read_material_layers(const JsonObject& json, const GltfCounts& counts, GltfMaterial& material);

}  // namespace furnace
