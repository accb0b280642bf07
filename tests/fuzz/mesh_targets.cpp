// Compressed meshes, models that are no glTF, luminaires.
#include <array>
#include <cmath>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "renderer/scene/light_profile.hpp"
#include "renderer/scene/model_import.hpp"
#include "tests/fuzz/checked_decoder.hpp"
#include "tests/fuzz/expectations.hpp"
#include "tests/fuzz/mutators.hpp"

namespace furnace::fuzz {
namespace {

// Input: number of attributes, three bytes each (id, component type, components), vertices, triangles; the mesh.
void run_draco(Input input) {
  constexpr std::array kComponents = {DracoComponent::kByte,        DracoComponent::kUnsignedByte,
                                      DracoComponent::kShort,       DracoComponent::kUnsignedShort,
                                      DracoComponent::kUnsignedInt, DracoComponent::kFloat};
  Taker taker(input);
  DracoRequest request;
  request.most_bytes = 4 << 20;
  for (std::uint32_t left = taker.number(1) % 8; left > 0; --left) {
    const std::uint32_t id = taker.number(1);
    const DracoComponent component = kComponents[taker.number(1) % kComponents.size()];
    request.attributes.push_back({id, component, 1 + int(taker.number(1) % 4)});
  }
  request.vertices = taker.number(2);
  request.most_triangles = taker.number(2);
  CheckedDecoder().draco(taker.rest(), request, Deadline());
}

// Input: mode, filter, bytes of an element, elements; the view.
void run_meshopt(Input input) {
  Taker taker(input);
  MeshoptLayout layout;
  layout.mode = MeshoptMode(taker.number(1) % 3);
  layout.filter = MeshoptFilter(taker.number(1) % 5);
  layout.stride = taker.number(2);
  layout.count = taker.number(2);
  if (meshopt_fault(layout) != nullptr) return;
  CheckedDecoder().meshopt(taker.rest(), layout, Deadline());
}

// Input: the document; behind a zero byte the text of its materials, whichever file it names.
template <ModelFormat kFormat>
void run_model(Input input) {
  ModelBundle bundle;
  bundle.format = kFormat;
  const TextPair texts = kFormat == ModelFormat::kObj ? split(input) : TextPair{text_of(input), {}};
  bundle.document = Blob(std::string(texts.first));
  const std::vector<std::string> names = model_siblings(bundle.document, kFormat, small_import_limits());
  FURNACE_CHECK(names.size() <= kMostSiblings, "{} siblings", names.size());
  for (const std::string& name : names) bundle.siblings[name] = Blob(std::string(texts.second));
  for (const std::string& name : texture_names(texts.second)) bundle.siblings[name] = Blob();
  bundle.seal();
  CheckedDecoder decoder;
  expect_whole(import_model(bundle, {}, small_import_limits(), decoder, Deadline()));
}

void run_ies(Input input) {
  const LightProfile profile = parse_ies(text_of(input), {.max_angles = 4096});
  FURNACE_CHECK(profile.vertical.size() >= 2 && !profile.horizontal.empty(), "{} by {} angles",
                profile.vertical.size(), profile.horizontal.size());
  FURNACE_CHECK(profile.candela.size() == profile.vertical.size() * profile.horizontal.size(), "{} values",
                profile.candela.size());
  FURNACE_CHECK(profile.peak_candela > 0 && std::isfinite(profile.flux_lumen) && profile.flux_lumen >= 0,
                "peak {}, flux {}", profile.peak_candela, profile.flux_lumen);
  for (double vertical = 0; vertical < 3.2; vertical += 0.4) {
    for (double horizontal = -7; horizontal < 7; horizontal += 0.9) {
      const double candela = profile.candela_towards(vertical, horizontal);
      FURNACE_CHECK(candela >= 0 && candela <= profile.peak_candela * (1 + 1e-9), "{} cd of {} at {}, {}",
                    candela, profile.peak_candela, vertical, horizontal);
    }
  }
}

constexpr std::size_t kMostMeshBytes = 4 << 10, kMostModelBytes = 8 << 10, kMostProfileBytes = 4 << 10;

constexpr std::array kTargets = {
    Target{"draco", run_draco, kMostMeshBytes, mutate_bytes},
    Target{"meshopt", run_meshopt, kMostMeshBytes, mutate_bytes},
    Target{"obj", run_model<ModelFormat::kObj>, kMostModelBytes, mutate_bytes},
    Target{"stl", run_model<ModelFormat::kStl>, kMostModelBytes, mutate_bytes},
    Target{"ply", run_model<ModelFormat::kPly>, kMostModelBytes, mutate_bytes},
    Target{"ies", run_ies, kMostProfileBytes, mutate_bytes},
};

}  // namespace

std::span<const Target> mesh_targets() {
  return kTargets;
}

}  // namespace furnace::fuzz
