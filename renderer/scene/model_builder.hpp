// A PlainModel made part by part, by the reader of each format; with the limits that hold for all of them.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "renderer/scene/model_format.hpp"
#include "renderer/scene/plain_model.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// kTooLarge: "the model has more than 5 parts".
[[noreturn]] void fail_too_many(std::int64_t most, std::string_view what);
// kUnprocessable: "is not a readable PLY file: " and why, cut off and made printable, as it may quote the file.
[[noreturn]] void fail_unreadable(ModelFormat format, std::string_view why);

// Errors: kTooLarge for a limit, kUnprocessable for a position that is not finite. Threads: one. Owns: the model.
class ModelBuilder {
 public:
  explicit ModelBuilder(const PlainModelLimits& limits) : limits_(limits) {}

  const PlainModelLimits& limits() const { return limits_; }
  TextRange add_text(std::string_view text);
  void add_material(const PlainMaterial& material) { model_.materials.push_back(material); }
  // What is drawn that has no material of its own: a grey plastic, named "default". Not yet added.
  PlainMaterial plain_material();
  // Welds it, gives it normals, appends it; nothing of a mesh without indices. `flat`: it is shaded by its triangles.
  void add_part(Mesh mesh, std::uint32_t material, bool flat);
  // Fails where there are no parts. Ends the builder's use.
  PlainModel take();

 private:
  template <class Value>
  void append(std::vector<Value>& to, const std::vector<Value>& values, std::size_t first);

  PlainModelLimits limits_;
  PlainModel model_;
  std::int64_t elements_ = 0;
};

}  // namespace furnace
