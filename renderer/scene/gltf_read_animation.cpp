// Animations: what moves, by JSON pointers whichever way the file says it.
#include <utility>

#include "renderer/scene/gltf_read.hpp"

namespace furnace {

namespace {

GltfInterpolation read_interpolation(const JsonObject& json) {
  const std::string name = json.string("interpolation", "LINEAR");
  if (name == "STEP") return GltfInterpolation::kStep;
  if (name == "LINEAR") return GltfInterpolation::kLinear;
  if (name == "CUBICSPLINE") return GltfInterpolation::kCubicSpline;
  json.refuse("interpolation", "must be STEP, LINEAR or CUBICSPLINE");
}

// glTF 2.0, section 3.11: a channel without a node, or with a path of an extension that is not read, moves nothing.
std::string read_target(const JsonObject& json, const GltfCounts& counts) {
  const std::string path = json.required_string("path");
  const auto node = json.reference("node", "node", counts.nodes);
  if (path == "pointer") {
    const auto extension = json.extension("KHR_animation_pointer");
    return extension ? extension->required_string("pointer") : std::string();
  }
  const bool of_node = path == "translation" || path == "rotation" || path == "scale" || path == "weights";
  return node && of_node ? "/nodes/" + std::to_string(*node) + "/" + path : std::string();
}

}  // namespace

GltfAnimation read_animation(const JsonObject& json, const GltfCounts& counts) {
  GltfAnimation animation;
  animation.name = json.string("name");
  json.each("samplers", [&](const JsonObject& sampler) {
    animation.samplers.push_back({sampler.required_reference("input", "accessor", counts.accessors),
                                  sampler.required_reference("output", "accessor", counts.accessors),
                                  read_interpolation(sampler)});
  });
  const int samplers = static_cast<int>(animation.samplers.size());
  json.each("channels", [&](const JsonObject& channel) {
    const JsonObject target = channel.required_object("target");
    animation.channels.push_back({channel.required_reference("sampler", "sampler", samplers),
                                  read_target(target, counts), target.pointer()});
  });
  return animation;
}

}  // namespace furnace
