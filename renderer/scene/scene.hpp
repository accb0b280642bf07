// A scene as values: what an importer or a builder makes and every other floor reads. Flat, in world space,
// no GL.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/base/blob.hpp"
#include "renderer/scene/light.hpp"
#include "renderer/scene/material.hpp"

namespace furnace {

struct Bounds {
  glm::vec3 min{std::numeric_limits<float>::infinity()};
  glm::vec3 max{-std::numeric_limits<float>::infinity()};

  bool empty() const { return min.x > max.x; }
  void add(const glm::vec3& point);
  void add(const Bounds& other);
};

enum class Topology { kPoints, kLines, kTriangles };  // strips, fans and loops are expanded by the importer

// One drawable primitive in model space. Attribute arrays are empty or as long as `positions`.
// Triangles always have normals (imported or generated flat); tangents when a material of theirs needs them.
struct Mesh {
  ContentHash key;  // of all that it was made from; equal for the same mesh in another scene
  std::string name;
  Topology topology = Topology::kTriangles;
  std::vector<glm::vec3> positions;  // m
  std::vector<glm::vec3> normals;    // unit; points and lines without normals are shaded unlit
  std::vector<glm::vec4> tangents;   // unit xyz, w = +-1: bitangent = w * cross(normal, tangent)
  std::array<std::vector<glm::vec2>, 2> uvs;
  std::vector<glm::vec4> colors;       // linear, COLOR_0
  std::vector<std::uint32_t> indices;  // never empty for a drawable mesh; every index < positions.size()
  Bounds bounds;

  std::size_t byte_size() const;
};

// Shared by the scenes that have it: compositions of one model, moments of one clip.
using SharedMesh = std::shared_ptr<const Mesh>;

struct SceneImage {
  Blob encoded;  // what decode_texture reads
  // Place in the model's own document, e.g. "/images/3", or in the request, "/scene/materials/gold/textures/normal".
  std::string pointer;
};

struct Instance {
  int mesh = 0;      // index into Scene::meshes
  int material = 0;  // index into Scene::materials
  glm::mat4 world_from_model{1};
  std::string node_name;  // never empty: of a node without one its JSON pointer
  // Tells it from the others of its scene; the same at every time of an animation.
  std::int64_t place = 0;
};

struct CameraNode {
  std::string name;
  glm::mat4 world_from_view{1};
  bool orthographic = false;
  double fov_y_rad = 0.8;
  std::optional<double> aspect_ratio;      // none: the picture's
  double half_width = 1, half_height = 1;  // m, orthographic
  double z_near = 0.01;                    // m
  std::optional<double> z_far;             // m; none: infinite, perspective only
};

struct SceneAnimation {
  std::string name;
  double duration_s = 0;
};

// Something that was not drawn as asked, or was mended: part of a render's report; an error under "strict".
struct Note {
  std::string code;     // stable, kebab-case: "extension-ignored", "normals-generated", ...
  std::string pointer;  // into the model's document
  std::string message;

  bool operator==(const Note&) const = default;
};

// Threads: immutable once built. Owns: all it names.
struct Scene {
  ContentHash hash;                 // of everything the scene was built from
  std::vector<SharedMesh> meshes;   // none of them null
  std::vector<Material> materials;  // never empty
  std::vector<SceneImage> images;
  std::vector<Instance> instances;
  std::vector<CameraNode> cameras;
  std::vector<Light> lights;
  std::vector<std::string> variants;  // names that the model knows (KHR_materials_variants), chosen or not
  std::vector<SceneAnimation> animations;  // that the model knows, played or not
  std::vector<Note> notes;

  std::size_t byte_size() const;
};

// World bounds of every vertex (exact, not of transformed boxes); empty for a scene that draws nothing.
Bounds world_bounds(const Scene& scene);

}  // namespace furnace
