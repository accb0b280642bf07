#include "renderer/scene/gltf_usage.hpp"

namespace furnace {

namespace {

// Marks what is reached, each thing once. Threads: one. Owns: the marks.
class Tracer {
 public:
  explicit Tracer(const GltfDocument& document) : document_(document) {
    usage_.nodes.resize(document.nodes.size());
    usage_.meshes.resize(document.meshes.size());
    usage_.materials.resize(document.materials.size());
    usage_.textures.resize(document.textures.size());
    usage_.images.resize(document.images.size());
    usage_.skins.resize(document.skins.size());
    usage_.cameras.resize(document.cameras.size());
    usage_.accessors.resize(document.accessors.size());
    usage_.buffer_views.resize(document.buffer_views.size());
  }

  GltfUsage trace(const GltfAbout& about) {
    if (document_.scenes.empty()) {
      for (std::size_t i = 0; i < document_.nodes.size(); ++i)
        if (document_.nodes[i].parent < 0) open_.push_back(static_cast<int>(i));
    }
    for (const GltfScene& scene : document_.scenes)
      open_.insert(open_.end(), scene.nodes.begin(), scene.nodes.end());
    while (!open_.empty()) {
      const int node = open_.back();
      open_.pop_back();
      if (mark(usage_.nodes, node)) use_node(document_.nodes[static_cast<std::size_t>(node)]);
    }
    for (const GltfAnimation& animation : document_.animations) {
      for (const GltfAnimationSampler& sampler : animation.samplers) {
        use_accessor(sampler.input);
        use_accessor(sampler.output);
      }
    }
    for (const int view : about.extension_views) mark(usage_.buffer_views, view);
    return std::move(usage_);
  }

 private:
  // Whether it was new.
  static bool mark(std::vector<bool>& marks, int index) {
    const auto at = static_cast<std::size_t>(index);
    const bool is_new = !marks[at];
    marks[at] = true;
    return is_new;
  }

  void use_node(const GltfNode& node) {
    open_.insert(open_.end(), node.children.begin(), node.children.end());
    if (node.mesh && mark(usage_.meshes, *node.mesh)) use_mesh(*node.mesh);
    if (node.camera) mark(usage_.cameras, *node.camera);
    if (!node.skin || !mark(usage_.skins, *node.skin)) return;
    const GltfSkin& skin = document_.skins[static_cast<std::size_t>(*node.skin)];
    open_.insert(open_.end(), skin.joints.begin(), skin.joints.end());
    if (skin.inverse_bind_matrices) use_accessor(*skin.inverse_bind_matrices);
  }

  void use_mesh(int index) {
    for (const GltfPrimitive& primitive : document_.meshes[static_cast<std::size_t>(index)].primitives) {
      use_attributes(primitive.attributes);
      for (const GltfAttributes& target : primitive.targets) use_attributes(target);
      if (primitive.indices) use_accessor(*primitive.indices);
      if (primitive.material) use_material(*primitive.material);
      for (const auto& [variant, material] : primitive.variant_materials) use_material(material);
    }
  }

  void use_attributes(const GltfAttributes& attributes) {
    for (const auto& [semantic, accessor] : attributes) use_accessor(accessor);
  }

  void use_accessor(int index) {
    if (!mark(usage_.accessors, index)) return;
    const GltfAccessor& accessor = document_.accessors[static_cast<std::size_t>(index)];
    if (accessor.buffer_view) mark(usage_.buffer_views, *accessor.buffer_view);
    if (!accessor.sparse) return;
    mark(usage_.buffer_views, accessor.sparse->indices_view);
    mark(usage_.buffer_views, accessor.sparse->values_view);
  }

  void use_material(int index) {
    if (!mark(usage_.materials, index)) return;
    for (const auto& ref : document_.materials[static_cast<std::size_t>(index)].textures) {
      if (!ref || !mark(usage_.textures, ref->texture)) continue;
      for (const int image : document_.textures[static_cast<std::size_t>(ref->texture)].images)
        use_image(image);
    }
  }

  void use_image(int index) {
    if (!mark(usage_.images, index)) return;
    if (const auto view = document_.images[static_cast<std::size_t>(index)].buffer_view)
      mark(usage_.buffer_views, *view);
  }

  const GltfDocument& document_;
  GltfUsage usage_;
  std::vector<int> open_;
};

}  // namespace

GltfUsage gltf_usage(const GltfDocument& document, const GltfAbout& about) {
  return Tracer(document).trace(about);
}

}  // namespace furnace
