#include "renderer/scene/gltf_model.hpp"

#include "renderer/base/error.hpp"
#include "renderer/scene/gltf_pose.hpp"

namespace furnace {

namespace {

// What can be checked without the bytes of any buffer, for drawn and undrawn things alike.
void check_document(const GltfDocument& document) {
  for (int mesh = 0; mesh < static_cast<int>(document.meshes.size()); ++mesh) {
    const auto primitives =
        static_cast<int>(document.meshes[static_cast<std::size_t>(mesh)].primitives.size());
    for (int primitive = 0; primitive < primitives; ++primitive) check_primitive(document, {mesh, primitive});
  }
  for (int skin = 0; skin < static_cast<int>(document.skins.size()); ++skin) check_skin(document, skin);
  for (std::size_t i = 0; i < document.nodes.size(); ++i) {
    const GltfNode& node = document.nodes[i];
    if (!node.mesh || node.weights.empty()) continue;
    const GltfMesh& mesh = document.meshes[static_cast<std::size_t>(*node.mesh)];
    const std::size_t targets = mesh.primitives.empty() ? 0 : mesh.primitives.front().targets.size();
    if (node.weights.size() == targets) continue;
    fail(ErrorCode::kUnprocessable, "must have one number per morph target, " + std::to_string(targets),
         "/nodes/" + std::to_string(i) + "/weights");
  }
}

}  // namespace

GltfDocument read_checked_gltf(const GltfJson& json, const ImportLimits& limits) {
  GltfDocument document = read_gltf_document(json, limits);
  check_document(document);
  return document;
}

GltfModel::State::State(Decoder& decoder, const ModelBundle& bundle, const ImportLimits& limits,
                        const Deadline& deadline, Times times)
    : bundle(bundle),
      limits(limits),
      deadline(deadline),
      times(times),
      json(parse_gltf(bundle.document, limits)),
      document(read_checked_gltf(json, limits)),
      undeclared(undeclared_extensions(json.root)),
      data(document, bundle, limits, decoder, deadline) {}

GltfVertices GltfModel::State::vertices_of(const GltfPrimitiveRef& ref, bool with_influences,
                                           GltfNotes& notes) {
  const bool deforms = with_influences || !primitive_of(document, ref).targets.empty();
  if (times == Times::kOne || !deforms)
    return read_primitive_vertices(document, data, ref, with_influences, notes);
  const auto [entry, fresh] = vertices.try_emplace({ref, with_influences});
  if (fresh) entry->second = read_primitive_vertices(document, data, ref, with_influences, notes);
  return entry->second;
}

GltfModel::GltfModel(Decoder& decoder, const ModelBundle& bundle, const ImportLimits& limits,
                     const Deadline& deadline, Times times)
    : state_(std::make_unique<State>(decoder, bundle, limits, deadline, times)) {}

GltfModel::~GltfModel() = default;

}  // namespace furnace
