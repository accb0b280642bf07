// A scene with everything decoded and baked: what the CPU side hands to the GL thread. Immutable values, no GL.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "renderer/base/content_hash.hpp"
#include "renderer/ibl/light_sums.hpp"
#include "renderer/ibl/octahedral_atlas.hpp"
#include "renderer/ibl/suns.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/residency/packed_mesh.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

struct PreparedMesh {
  ContentHash key;                   // of the mesh's source and place in it
  std::shared_ptr<const Mesh> mesh;  // shares its scene's life
  // Null when it was resident on the GPU a moment ago, so nothing was packed.
  std::shared_ptr<const PackedMesh> packed;
  // Where the environment casts shadows: the triangles that stand for the mesh in them (scene/occluder.hpp). Null as `packed`.
  std::shared_ptr<const std::vector<std::uint32_t>> occluder;
};

// Of PreparedMesh::occluder, by that of its mesh.
inline ContentHash occluder_key_of(const ContentHash& mesh) {
  return HashBuilder().add("occluder").add(mesh).finish();
}

struct PreparedTexture {
  ContentHash key;  // of the encoded bytes and the colour space
  // RGBA kUint8 or kUint16, the largest first, each half as large as the one before; levels that are missing at the end
  // are made of the last. Null when it was resident on the GPU a moment ago, so nothing was decoded.
  std::shared_ptr<const std::vector<Image>> levels;
  float lowest_green = 0;  // [0, 1], of `levels`: the lowest roughness in a metallic-roughness map
};

// What a bake found, for reports.
struct EnvironmentSummary {
  bool operator==(const EnvironmentSummary&) const = default;

  Extent size;                                              // px, of the map
  EnvironmentLayout layout = EnvironmentLayout::kEquirect;  // of its file
  RepairReport repairs;
  std::array<double, 3> mean{};  // solid-angle weighted radiance, linear Rec. 709
  double peak = 0;
  double horizontal_illuminance_lux = 0;  // if the map's values are luminances in cd/m2
  double bake_ms = 0;                     // wall time of the bake; never in a picture
  std::vector<Sun> suns;                  // found in the map
  bool suns_extracted = false;  // what was baked is the map without them; the numbers above are with them
};

// An equirect map to be looked at. Values are radiance * scale, the scale a power of two.
struct PreparedSky {
  ContentHash key;
  Image texels;  // RGBA kFloat16
  double scale = 1;

  std::size_t byte_size() const { return texels.byte_size(); }
};

// Of PreparedEnvironment::map, by that of its environment.
inline ContentHash map_key_of(const ContentHash& environment) {
  return HashBuilder().add("map").add(environment).finish();
}

// One environment in the shape the GPU takes.
struct PreparedEnvironment {
  ContentHash key;
  PreparedSky sky;  // what lights, unblurred
  PreparedSky map;  // the environment as it is, where suns were taken out of `sky`; else empty
  OctahedralAtlas atlas;
  EnvironmentSummary summary;

  // What a camera sees of it.
  const PreparedSky& seen() const { return summary.suns_extracted ? map : sky; }
  std::size_t byte_size() const { return sky.byte_size() + map.byte_size() + atlas.texels.byte_size(); }
};

struct PreparedGround {
  double level_m = 0;  // world y
  Bounds bounds;       // of the scene, world; a unit cube where it draws nothing
  // Of the scene, its light and the plane; none where no shadow is asked for.
  std::optional<ContentHash> shadow_key;
  glm::dvec3 free_irradiance{0};  // of lights that cast no shadow, RGB
  // What else would light the plane without the scene, in world space. Null when the shadow was resident on the GPU a moment ago.
  std::shared_ptr<const std::vector<LightDirection>> light;
  // With `light`: all lights that have a place; what falls from them is worked out where it falls. Of each one that casts a
  // shadow `places` places from `first_place` on stand for all of it.
  std::vector<Light> lamps;
  int first_place = 0, places = 0;
  // With `light`: of every mesh what casts its shadow where it is opaque (scene/occluder.hpp); null of what is no
  // triangles.
  std::vector<std::shared_ptr<const std::vector<std::uint32_t>>> occluders;
};

struct PreparedScene {
  std::vector<PreparedMesh> meshes;
  std::vector<Material> materials;  // TextureSlot::image is an index into `textures`
  std::vector<PreparedTexture> textures;
  std::vector<Instance> instances;
  Bounds bounds;  // of every vertex, world; empty when nothing is drawn
  std::shared_ptr<const PreparedEnvironment> environment;
  std::shared_ptr<const PreparedSky> background;  // null where no environment is seen
  // The environment's light for its shadows, in world space, as many for each sub-frame; empty where it casts none.
  std::vector<LightDirection> sky_lights;
  LightSums sky_sums;         // of them
  std::vector<Light> lights;  // at most gpu::MOST_LIGHTS; the environment's intensity is in its suns
  double environment_intensity = 1, background_intensity = 1;  // multipliers of the maps' radiance
  std::optional<PreparedGround> ground;
};

}  // namespace furnace
