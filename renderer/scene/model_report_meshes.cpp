// Meshes and animations: what is declared, and what the numbers themselves say as far as that may be read.
#include <array>
#include <cmath>
#include <limits>

#include "renderer/base/error.hpp"
#include "renderer/scene/gltf_primitive.hpp"
#include "renderer/scene/model_report_parts.hpp"

namespace furnace {

namespace {

std::string_view component_name(ComponentType type) {
  switch (type) {
    case ComponentType::kByte:
      return "byte";
    case ComponentType::kUnsignedByte:
      return "unsigned byte";
    case ComponentType::kShort:
      return "short";
    case ComponentType::kUnsignedShort:
      return "unsigned short";
    case ComponentType::kUnsignedInt:
      return "unsigned int";
    case ComponentType::kFloat:
      break;
  }
  return "float";
}

std::string_view element_name(ElementType type) {
  constexpr std::array<std::string_view, 7> kNames{"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
  return kNames[static_cast<std::size_t>(type)];
}

std::string_view interpolation_name(GltfInterpolation interpolation) {
  constexpr std::array<std::string_view, 3> kNames{"STEP", "LINEAR", "CUBICSPLINE"};
  return kNames[static_cast<std::size_t>(interpolation)];
}

const GltfAccessor& accessor_of(const GltfDocument& document, int index) {
  return document.accessors[static_cast<std::size_t>(index)];
}

Topology topology_of_mode(int mode) {
  return mode == 0 ? Topology::kPoints : mode < 4 ? Topology::kLines : Topology::kTriangles;
}

// None where there is none, or one that no vertex could have.
std::optional<Bounds> declared_bounds(const GltfRange& range) {
  if (range.min.size() != 3 || range.max.size() != 3) return std::nullopt;
  Bounds bounds;
  for (int c = 0; c < 3; ++c) {
    constexpr double kMost = std::numeric_limits<float>::max();
    const double low = range.min[static_cast<std::size_t>(c)], high = range.max[static_cast<std::size_t>(c)];
    if (!(std::abs(low) <= kMost && std::abs(high) <= kMost)) return std::nullopt;
    bounds.min[c] = static_cast<float>(low);
    bounds.max[c] = static_cast<float>(high);
  }
  return bounds;
}

// Reads vertices until it has read as many as a whole model may have: primitives that share them are read each.
// Threads: one. Owns: what is left to read.
class MeshReporter {
 public:
  MeshReporter(const ReportSource& source, ReportBudget& budget)
      : source_(source), budget_(budget), nodes_of_mesh_(source.document.meshes.size()) {
    for (const GltfNode& node : source.document.nodes)
      if (node.mesh) ++nodes_of_mesh_[static_cast<std::size_t>(*node.mesh)];
  }

  ModelReport::MeshInfo report(std::size_t index) {
    const GltfMesh& mesh = source_.document.meshes[index];
    ModelReport::MeshInfo info;
    info.name = budget_.text(mesh.name);
    info.nodes = nodes_of_mesh_[index];
    info.primitives = budget_.list<ModelReport::Primitive>(mesh.primitives.size(), [&](std::size_t i) {
      return primitive({static_cast<int>(index), static_cast<int>(i)});
    });
    return info;
  }

 private:
  ModelReport::Primitive primitive(const GltfPrimitiveRef& ref) {
    check_deadline(source_.deadline, "inspect");
    const GltfDocument& document = source_.document;
    const GltfPrimitive& primitive = primitive_of(document, ref);
    ModelReport::Primitive info;
    info.mode = primitive.mode;
    info.topology = topology_of_mode(primitive.mode);
    info.morph_targets = std::int64_t(primitive.targets.size());
    info.material = primitive.material;
    if (primitive.indices)
      info.index_component = component_name(accessor_of(document, *primitive.indices).component);
    auto next = primitive.attributes.begin();
    info.attributes = budget_.list<ModelReport::Attribute>(primitive.attributes.size(), [&](std::size_t) {
      const auto& [semantic, index] = *next++;
      const GltfAccessor& accessor = accessor_of(document, index);
      return ModelReport::Attribute{budget_.text(semantic), element_name(accessor.type),
                                    component_name(accessor.component), accessor.normalized};
    });
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return info;
    info.vertices = std::int64_t(accessor_of(document, position->second).count);
    info.elements = std::int64_t(primitive_size(document, ref).elements);
    info.declared = declared_bounds(source_.about.ranges[static_cast<std::size_t>(position->second)]);
    info.bounds = bounds_of(ref);
    return info;
  }

  std::optional<Bounds> bounds_of(const GltfPrimitiveRef& ref) {
    const GltfPrimitiveSize size = primitive_size(source_.document, ref);
    const ImportLimits& limits = source_.limits;
    if (size.elements == 0 || size.bytes > std::uint64_t(limits.max_mesh_bytes)) return std::nullopt;
    if (size.vertices > std::uint64_t(limits.max_vertices - vertices_read_) ||
        size.elements > std::uint64_t(limits.max_triangles - elements_read_))
      return std::nullopt;
    vertices_read_ += std::int64_t(size.vertices);
    elements_read_ += std::int64_t(size.elements);
    Bounds bounds;
    try {
      GltfNotes unheard;
      const GltfVertices vertices =
          read_primitive_vertices(source_.document, source_.data, ref, false, unheard);
      for (const std::uint32_t index : vertices.mesh.indices) bounds.add(vertices.mesh.positions[index]);
    } catch (const Error& error) {
      // What is drawn was read before: this is a mesh that nothing shows.
      if (error.code == ErrorCode::kDeadlineExceeded) throw;
      return std::nullopt;
    }
    return bounds.empty() ? std::nullopt : std::optional(bounds);
  }

  const ReportSource& source_;
  ReportBudget& budget_;
  std::vector<std::int64_t> nodes_of_mesh_;
  std::int64_t vertices_read_ = 0, elements_read_ = 0;
};

}  // namespace

void report_meshes(const ReportSource& source, ReportBudget& budget, ModelReport& report) {
  const GltfDocument& document = source.document;
  MeshReporter reporter(source, budget);
  report.meshes = budget.list<ModelReport::MeshInfo>(document.meshes.size(),
                                                     [&](std::size_t i) { return reporter.report(i); });
  for (const GltfMesh& mesh : document.meshes) {
    for (const GltfPrimitive& primitive : mesh.primitives) {
      const auto position = primitive.attributes.find("POSITION");
      if (position != primitive.attributes.end())
        report.vertices += std::int64_t(accessor_of(document, position->second).count);
    }
  }
}

void report_animations(const ReportSource& source, const Scene& scene, ReportBudget& budget,
                       ModelReport& report) {
  const std::vector<GltfAnimation>& all = source.document.animations;
  report.animations = budget.list<ModelReport::AnimationInfo>(all.size(), [&](std::size_t i) {
    const GltfAnimation& animation = all[i];
    ModelReport::AnimationInfo info;
    info.name = budget.text(animation.name);
    info.duration_s = scene.animations[i].duration_s;
    info.channels = budget.list<ModelReport::ChannelInfo>(animation.channels.size(), [&](std::size_t k) {
      const GltfAnimationChannel& channel = animation.channels[k];
      const GltfAnimationSampler& sampler = animation.samplers[static_cast<std::size_t>(channel.sampler)];
      return ModelReport::ChannelInfo{budget.text(channel.target), interpolation_name(sampler.interpolation),
                                      std::int64_t(accessor_of(source.document, sampler.input).count)};
    });
    return info;
  });
}

}  // namespace furnace
