#include "renderer/scene/gltf_deform.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/base/error.hpp"

namespace furnace {

namespace {

// How far from 1 a vertex's weights may sum before it is told: 8-bit weights that were each rounded stay well
// within.
constexpr double kWeightTolerance = 0.01;

template <int N>
void add_displacement(std::vector<glm::vec<N, float>>& values,
                      const std::vector<glm::vec<N, float>>& displacement, double weight,
                      const std::string& pointer) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto moved = glm::vec<N, double>(values[i]) + weight * glm::vec<N, double>(displacement[i]);
    for (int c = 0; c < N; ++c) {
      if (!std::isfinite(static_cast<float>(moved[c]))) {
        fail(ErrorCode::kUnprocessable, "displacement " + std::to_string(i) + " is not finite or too large",
             pointer);
      }
    }
    values[i] = glm::vec<N, float>(moved);
  }
}

void add_tangent_displacement(std::vector<glm::vec4>& tangents, const std::vector<glm::vec3>& displacement,
                              double weight, const std::string& pointer) {
  std::vector<glm::vec3> directions(tangents.begin(), tangents.end());
  add_displacement<3>(directions, displacement, weight, pointer);
  for (std::size_t i = 0; i < tangents.size(); ++i) tangents[i] = glm::vec4(directions[i], tangents[i].w);
}

// Normals and tangents that a mesh has not are made of what was displaced.
void note_displaced_nothing(const std::string& semantic, const std::string& pointer, GltfNotes& notes) {
  if (semantic == "NORMAL" || semantic == "TANGENT" || semantic.starts_with('_')) return;
  notes.add("morph-attribute-ignored", pointer, "displaces what the mesh does not have, or what is not read");
}

void add_target(const GltfData& data, const GltfAttributes& target, double weight, const std::string& pointer,
                Mesh& mesh, GltfNotes& notes) {
  for (const auto& [semantic, accessor] : target) {
    const std::string at = pointer + "/" + semantic;
    if (semantic == "POSITION") {
      add_displacement<3>(mesh.positions, data.read_vectors<glm::vec3>(accessor), weight, at);
    } else if (semantic == "NORMAL" && !mesh.normals.empty()) {
      add_displacement<3>(mesh.normals, data.read_vectors<glm::vec3>(accessor), weight, at);
    } else if (semantic == "TANGENT" && !mesh.tangents.empty()) {
      add_tangent_displacement(mesh.tangents, data.read_vectors<glm::vec3>(accessor), weight, at);
    } else if (semantic == "TEXCOORD_0" && !mesh.uvs[0].empty()) {
      add_displacement<2>(mesh.uvs[0], data.read_vectors<glm::vec2>(accessor), weight, at);
    } else if (semantic == "TEXCOORD_1" && !mesh.uvs[1].empty()) {
      add_displacement<2>(mesh.uvs[1], data.read_vectors<glm::vec2>(accessor), weight, at);
    } else if (semantic == "COLOR_0" && !mesh.colors.empty()) {
      add_displacement<4>(mesh.colors, data.read_vectors<glm::vec4>(accessor), weight, at);
    } else {
      note_displaced_nothing(semantic, at, notes);
    }
  }
}

// det(M) * inverse(transpose(M)): takes normals, and stays finite for a flattening M.
glm::dmat3 cofactors(const glm::dmat3& m) {
  return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

// One vertex's joints with their weights, normalised.
class Blend {
 public:
  Blend(std::span<const glm::dmat4> joints, const std::string& pointer, GltfNotes& notes)
      : joints_(joints), pointer_(pointer), notes_(notes) {}

  glm::dmat4 matrix(const std::vector<GltfVertices::Influences>& influences, std::size_t vertex) {
    glm::dmat4 sum(0);
    double total = 0;
    for (std::size_t set = 0; set < influences.size(); ++set) {
      for (int i = 0; i < 4; ++i) {
        const double weight = checked_weight(influences[set].weights[vertex][i], set);
        if (weight == 0) continue;
        sum += weight * joint(influences[set].joints[vertex][i], set);
        total += weight;
      }
    }
    if (total == 0) {
      notes_.add("weights-repaired", pointer_ + "/WEIGHTS_0",
                 "has vertices without any weight; their first joint was used");
      return joint(influences[0].joints[vertex][0], 0);
    }
    if (std::abs(total - 1) > kWeightTolerance) {
      notes_.add("weights-repaired", pointer_ + "/WEIGHTS_0",
                 "has weights that do not sum to 1; they were normalised");
    }
    return sum / total;
  }

 private:
  double checked_weight(float weight, std::size_t set) {
    const auto at = [&] { return pointer_ + "/WEIGHTS_" + std::to_string(set); };
    if (!std::isfinite(weight)) fail(ErrorCode::kUnprocessable, "has weights that are not finite", at());
    if (weight >= 0) return weight;
    notes_.add("weights-repaired", at(), "has negative weights; they count as 0");
    return 0;
  }

  const glm::dmat4& joint(std::uint32_t index, std::size_t set) const {
    if (index >= joints_.size()) {
      fail(ErrorCode::kUnprocessable,
           "names joint " + std::to_string(index) + "; the skin has " + std::to_string(joints_.size()),
           pointer_ + "/JOINTS_" + std::to_string(set));
    }
    return joints_[index];
  }

  std::span<const glm::dmat4> joints_;
  const std::string& pointer_;
  GltfNotes& notes_;
};

void turn_inside_out(Mesh& mesh) {
  if (mesh.topology == Topology::kTriangles) {
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
      std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  }
  for (glm::vec4& tangent : mesh.tangents) tangent.w = -tangent.w;
}

}  // namespace

void apply_morph_targets(const GltfDocument& document, const GltfData& data, const GltfPrimitiveRef& ref,
                         std::span<const double> weights, Mesh& mesh, GltfNotes& notes) {
  const GltfPrimitive& primitive = primitive_of(document, ref);
  const std::size_t count = std::min(weights.size(), primitive.targets.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (weights[i] == 0) continue;
    add_target(data, primitive.targets[i], weights[i], ref.pointer() + "/targets/" + std::to_string(i), mesh,
               notes);
  }
  // glTF 2.0, section 3.7.2.2: displaced colours are clamped.
  if (count > 0) {
    for (glm::vec4& color : mesh.colors) color = glm::clamp(color, 0.0f, 1.0f);
  }
}

void apply_skin(GltfVertices& vertices, std::span<const glm::dmat4> world_from_bind,
                const std::string& pointer, GltfNotes& notes) {
  Mesh& mesh = vertices.mesh;
  Blend blend(world_from_bind, pointer, notes);
  std::size_t mirrored = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::dmat4 matrix = blend.matrix(vertices.influences, i);
    const glm::dmat3 linear(matrix);
    const bool mirrors = glm::determinant(linear) < 0;
    mirrored += mirrors ? 1 : 0;
    mesh.positions[i] = glm::vec3(matrix * glm::dvec4(mesh.positions[i], 1));
    if (!mesh.normals.empty()) {
      const glm::dvec3 normal = cofactors(linear) * glm::dvec3(mesh.normals[i]) * (mirrors ? -1.0 : 1.0);
      mesh.normals[i] = glm::vec3(normal / std::max(glm::length(normal), 1e-300));
    }
    if (!mesh.tangents.empty()) {
      const glm::dvec3 tangent = linear * glm::dvec3(mesh.tangents[i]);
      mesh.tangents[i] = glm::vec4(tangent / std::max(glm::length(tangent), 1e-300), mesh.tangents[i].w);
    }
  }
  if (mirrored * 2 > mesh.positions.size()) turn_inside_out(mesh);
}

}  // namespace furnace
