// What is in a model, as values: for people and programs that want to know before they draw. Lists are in the
// document's order.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/base/deadline.hpp"
#include "renderer/scene/gltf_import.hpp"
#include "renderer/scene/light.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

struct ReportLimits {
  std::int64_t max_items = 1000;          // of one list
  std::int64_t max_items_total = 20'000;  // of all lists together
  std::size_t max_text_bytes = 1000;      // of a name, a copyright, a URI
};

// The first of a list, and how many more the document has.
template <class T>
struct ReportList {
  std::vector<T> items;
  std::int64_t more = 0;

  std::int64_t size() const { return std::int64_t(items.size()) + more; }
};

struct ModelReport {
  struct Asset {
    std::string container;  // "glb", "gltf", "obj", "stl" or "ply"
    std::string version, generator, copyright;
  };

  struct SceneInfo {
    std::string name;
    std::int64_t nodes = 0;  // all below its roots
  };

  struct Attribute {
    std::string semantic;
    std::string_view type, component;  // "VEC3", "float"
    bool normalized = false;
  };

  struct Primitive {
    int mode = 4;  // glTF's
    Topology topology = Topology::kTriangles;
    std::int64_t vertices = 0;  // as stored
    std::int64_t elements = 0;  // points, lines or triangles that the mode makes of them
    ReportList<Attribute> attributes;
    std::optional<std::string_view> index_component;
    std::int64_t morph_targets = 0;
    std::optional<int> material;
    std::optional<Bounds> declared;  // the accessor's min and max
    std::optional<Bounds>
        bounds;  // of the vertices as stored, without morph targets and skin; none: not read
  };

  struct MeshInfo {
    std::string name;
    std::int64_t nodes = 0;  // that show it, in any scene
    ReportList<Primitive> primitives;
  };

  struct TextureUseInfo {
    std::string_view use;
    int texture = 0;
    std::optional<int> image;
    int uv_set = 0;
    bool transformed = false;  // KHR_texture_transform
  };

  struct MaterialInfo {
    std::string name;
    AlphaMode alpha_mode = AlphaMode::kOpaque;
    bool double_sided = false;
    ReportList<std::string> extensions;
    ReportList<TextureUseInfo> textures;
  };

  struct TextureInfo {
    std::string name;
    std::optional<int> image;
    SamplerDesc sampler;
  };

  struct ImageInfo {
    std::string name;
    std::string uri;  // as written; "data:" alone for a data: URI
    std::optional<int> buffer_view;
    std::string media_type;               // as declared
    std::string_view format;              // by its first bytes; empty: none that is known
    bool missing = false;                 // its file is not there
    std::uint32_t width = 0, height = 0;  // px; 0: not known
    int channels = 0, bits = 0;           // as decoded; 0: not known
    std::int64_t encoded_bytes = 0;
    std::int64_t decoded_bytes = 0;  // 0: not known
    std::int64_t gpu_bytes = 0;  // with mip maps, once as colour and once as numbers where both are wanted
  };

  struct ChannelInfo {
    std::string target;  // JSON pointer into the document; empty: nothing that is known
    std::string_view interpolation;
    std::int64_t keyframes = 0;
  };

  struct AnimationInfo {
    std::string name;
    double duration_s = 0;  // the last keyframe's time
    ReportList<ChannelInfo> channels;
  };

  struct SkinInfo {
    std::string name;
    std::int64_t joints = 0;
  };

  struct LightInfo {
    std::string name;
    std::optional<LightKind> kind;  // none: not one that is known
  };

  struct Extensions {
    ReportList<std::string> used, required, unsupported;
  };

  // Of the scene and variant that were asked for, as a render draws them.
  struct Drawn {
    std::optional<int> scene;  // none: all root nodes
    std::optional<std::string> variant;
    std::int64_t nodes = 0;
    std::int64_t instances = 0;  // of primitives
    std::int64_t meshes = 0;     // as imported: a primitive under a skin is one for each node
    std::int64_t materials = 0, images = 0;
    std::int64_t vertices = 0, triangles = 0, lines = 0, points = 0;  // every instance counted
    Bounds bounds;                                                    // world, exact
  };

  struct Bytes {
    std::int64_t document = 0, json = 0;
    std::int64_t buffers = 0;  // as declared
    std::int64_t images_encoded = 0, images_decoded = 0, images_gpu = 0;
    std::int64_t meshes = 0;  // in memory, of what is drawn
  };

  // Indices of what neither a scene nor an animation leads to. What unsupported extensions refer to is not followed,
  // but for buffer views.
  struct Unused {
    ReportList<int> nodes, meshes, materials, textures, images, skins, cameras, accessors, buffer_views;
  };

  ContentHash hash;  // of the document and all that it refers to
  Asset asset;
  std::optional<int> default_scene;
  ReportList<SceneInfo> scenes;
  std::int64_t nodes = 0;
  std::int64_t vertices = 0;  // as stored, of all primitives
  ReportList<MeshInfo> meshes;
  ReportList<MaterialInfo> materials;
  ReportList<TextureInfo> textures;
  ReportList<ImageInfo> images;
  ReportList<AnimationInfo> animations;
  ReportList<SkinInfo> skins;
  ReportList<CameraNode> cameras;  // world_from_view is not said: a node places it
  ReportList<LightInfo> lights;
  ReportList<std::string> variants;
  Extensions extensions;
  ReportList<std::string> missing_files;
  Drawn drawn;
  Bytes bytes;
  Unused unused;
  std::vector<Note> notes;  // what a render would tell, and what only a report finds
};

// Of a model of any format. Of one that is no glTF the parts that it was imported as are its meshes, each once drawn, and the
// images that its materials use are its textures. Errors: as inspect_gltf, or import_model; kUnprocessable for a scene or a
// variant of what has none.
ModelReport inspect_model(Decoder& decoder, const ModelBundle& bundle, const ImportOptions& options,
                          const ImportLimits& limits, const Deadline& deadline,
                          const ReportLimits& report_limits = {});

// Reads the model as a render does, except that no image is decoded: of these the headers are read. Errors: those of
// import_gltf, so what cannot be drawn has no report; kUnprocessable for a variant that the model does not have.
// Threads: any.
ModelReport inspect_gltf(Decoder& decoder, const ModelBundle& bundle, const ImportOptions& options,
                         const ImportLimits& limits, const Deadline& deadline,
                         const ReportLimits& report_limits = {});

}  // namespace furnace
