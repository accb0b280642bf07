#include "renderer/moments.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "renderer/scene/shutter.hpp"

namespace furnace {
namespace {

using MeshesByKey = std::map<ContentHash, SharedMesh>;

// Puts in place of meshes that are known those, and returns the bytes of the others.
std::int64_t share_meshes(MeshesByKey& known, Scene& scene) {
  std::int64_t bytes = 0;
  for (SharedMesh& mesh : scene.meshes) {
    const auto [entry, fresh] = known.try_emplace(mesh->key, mesh);
    mesh = entry->second;
    if (fresh) bytes += std::int64_t(mesh->byte_size());
  }
  return bytes;
}

// About what a moment takes on both sides beside its meshes.
std::int64_t bytes_of_lists(const Scene& scene) {
  constexpr std::size_t kOfPlace = 512, kOfMaterial = 4096;
  return std::int64_t((scene.instances.size() + scene.lights.size() + scene.cameras.size()) * kOfPlace +
                      scene.materials.size() * kOfMaterial);
}

MeshesByKey meshes_of(const Scene& scene) {
  MeshesByKey meshes;
  for (const SharedMesh& mesh : scene.meshes) meshes.emplace(mesh->key, mesh);
  return meshes;
}

}  // namespace

std::size_t ComposedMoments::byte_size() const {
  std::set<const Mesh*> seen;
  std::size_t size = sizeof(ComposedMoments);
  for (const auto& composed : scenes) {
    const Scene& scene = composed->scene;
    size += sizeof(ComposedScene) + scene.instances.capacity() * sizeof(Instance) +
            scene.materials.capacity() * sizeof(Material);
    for (const SharedMesh& mesh : scene.meshes)
      if (seen.insert(mesh.get()).second) size += mesh->byte_size();
  }
  return size;
}

ComposedMoments compose_moments(const SceneSpec& spec, const ComposedScene& middle, Shutter shutter,
                                std::int64_t most_bytes, const ImportAt& import_at) {
  ComposedMoments moments;
  MeshesByKey known = meshes_of(middle.scene);
  std::int64_t bytes = 0;
  for (std::size_t i = 0; i < std::size_t(shutter.moments);) {
    if (i == 0) moments.offsets_s = moment_offsets_s(shutter.subframes, shutter.moments, shutter.open_s);
    const SceneSpec then = scene_at(spec, moments.offsets_s[i]);
    ComposedScene composed = compose_scene(then, import_at(then.animations).get());
    bytes += share_meshes(known, composed.scene) + bytes_of_lists(composed.scene);
    moments.scenes.push_back(std::make_shared<const ComposedScene>(std::move(composed)));
    ++i;
    if (bytes <= most_bytes || shutter.moments == 1) continue;
    // As many as did fit, at their own times.
    shutter.moments = std::max(int(i) - 1, 1);
    moments.scenes.clear();
    known = meshes_of(middle.scene);
    bytes = 0;
    i = 0;
  }
  return moments;
}

}  // namespace furnace
