// Which properties of a document an animation may move: those of the glTF 2.0 Asset Object Model (Khronos, 2025) that a
// picture shows.
#pragma once

#include <limits>
#include <optional>
#include <string_view>

namespace furnace {

enum class PropertyKind {
  kNumbers,
  kRotation,  // unit quaternion x y z w
  kWeights,   // as many numbers as there are morph targets
  kFlag,      // 0 is false
};

struct AnimatedProperty {
  PropertyKind kind = PropertyKind::kNumbers;
  int components = 1;
  // Where splines may overshoot: values are brought back into this.
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
};

// `pointer`: a JSON pointer into a document. None for a property that does not exist or that nothing may move.
std::optional<AnimatedProperty> find_animated_property(std::string_view pointer);

}  // namespace furnace
