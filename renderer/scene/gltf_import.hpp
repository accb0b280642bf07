// glTF 2.0 (.glb, .gltf) -> Scene. Every index, range and type of the document is checked before use; every
// error says where, by a JSON pointer into the model's document.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "renderer/base/blob.hpp"
#include "renderer/base/deadline.hpp"
#include "renderer/scene/model_format.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

class Decoder;

// A model with everything it refers to, already in memory: importing does no I/O.
struct ModelBundle {
  Blob document;                         // the file's bytes
  std::map<std::string, Blob> siblings;  // by URI as written in a glTF, percent-decoded; by sibling_name else
  ModelFormat format = ModelFormat::kGltf;
  ContentHash hash;  // of the document and all siblings

  void seal();  // computes `hash`
};

struct ImportLimits {
  std::int64_t max_triangles = 20'000'000;  // points, lines and triangles drawn, every instance counted
  std::int64_t max_vertices = 30'000'000;
  int max_nodes = 100'000;
  int max_node_depth = 4096;
  std::int64_t max_json_bytes = 64ll << 20;
  std::int64_t max_buffer_bytes = 1ll << 30;      // all buffers together
  std::int64_t max_instances = 1'000'000;         // of all nodes (EXT_mesh_gpu_instancing)
  std::int64_t max_keyframe_numbers = 1ll << 27;  // read to list and play animations, again for each sampler
  std::int64_t max_mesh_bytes = 2ll << 30;        // all meshes as imported
};

// When an animation is looked at. Before its first keyframe and after its last it stands still, unless it loops.
struct AnimationTime {
  double seconds = 0;
  bool loop = false;  // the time is taken modulo the animation's length
};

struct AnimationClip {
  std::variant<int, std::string> which = 0;  // index in the document, or name
  AnimationTime time;
};

struct ImportOptions {
  int scene = -1;  // index of the glTF scene; -1: the document's default, else the first, else all root nodes
  std::optional<std::string>
      variant;  // name; none, or one that Scene::variants does not list: the default materials
  // Played one after the other: a later one has the last word on what both move. Those that Scene::animations does not
  // list move nothing.
  std::vector<AnimationClip> animations = {};
};

// The external URIs (not data: ones) of buffers and images, percent-decoded, each once, in document order.
// Errors: kUnprocessable for what is not glTF 2.0, and by pointer for URIs with a scheme, absolute paths, "..".
std::vector<std::string> gltf_external_uris(const Blob& document, const ImportLimits& limits);

// Imports one scene of the document in the pose of its animations, or at rest: node transforms, skins (every set of
// joints) and morph targets are applied on the CPU in double precision; skinned meshes come out in
// world space. What is compressed is left to `decoder`.
// Errors: kUnprocessable with a pointer; kTooLarge for a limit; an extension in extensionsRequired that
// supported_gltf_extensions() does not list is refused, one in extensionsUsed only becomes a Note.
// A missing or unreadable image becomes a Note and the slot stays empty; a missing buffer is an error.
Scene import_gltf(Decoder& decoder, const ModelBundle& bundle, const ImportOptions& options,
                  const ImportLimits& limits, const Deadline& deadline);

// A document that is imported at several times: it is parsed and decompressed once, and what does not deform from one time
// to another is one mesh in all of them.
// Threads: one. Owns: the parsed document and a share of every mesh; all that it was made from outlives it.
class GltfModel {
 public:
  enum class Times { kOne, kSeveral };  // kSeveral keeps vertices before they are deformed

  // Errors: as import_gltf.
  GltfModel(Decoder& decoder, const ModelBundle& bundle, const ImportLimits& limits, const Deadline& deadline,
            Times times);
  ~GltfModel();

  // As import_gltf; only the first scene has the notes on its meshes.
  Scene import(const ImportOptions& options);

  struct State;

 private:
  std::unique_ptr<State> state_;
};

std::vector<std::string_view> supported_gltf_extensions();

}  // namespace furnace
