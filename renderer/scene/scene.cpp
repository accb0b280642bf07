#include "renderer/scene/scene.hpp"

namespace furnace {
namespace {

template <class T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

// The comparisons let a NaN coordinate fall through.
void Bounds::add(const glm::vec3& point) {
  min = glm::min(min, point);
  max = glm::max(max, point);
}

void Bounds::add(const Bounds& other) {
  if (other.empty()) return;
  add(other.min);
  add(other.max);
}

std::size_t Mesh::byte_size() const {
  return sizeof(Mesh) + name.capacity() + bytes_of(positions) + bytes_of(normals) + bytes_of(tangents) +
         bytes_of(uvs[0]) + bytes_of(uvs[1]) + bytes_of(colors) + bytes_of(indices);
}

std::size_t Scene::byte_size() const {
  std::size_t size = sizeof(Scene) + bytes_of(materials) + bytes_of(instances) + bytes_of(cameras) +
                     bytes_of(lights) + bytes_of(variants) + bytes_of(notes);
  for (const SharedMesh& mesh : meshes) size += mesh->byte_size();
  for (const SceneImage& image : images)
    size += sizeof(SceneImage) + image.pointer.capacity() + image.encoded.size();
  return size;
}

Bounds world_bounds(const Scene& scene) {
  Bounds bounds;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[instance.mesh];
    if (mesh.indices.empty()) continue;
    const glm::dmat4 world_from_model(instance.world_from_model);
    for (const glm::vec3& position : mesh.positions)
      bounds.add(glm::vec3(world_from_model * glm::dvec4(position, 1)));
  }
  return bounds;
}

}  // namespace furnace
