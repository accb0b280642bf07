#include "renderer/frame/layer_plan.hpp"

#include <algorithm>

namespace furnace {

FilmLayer source_of(FilmLayer layer) {
  switch (layer) {
    case FilmLayer::kDepth:
      return FilmLayer::kPosition;
    case FilmLayer::kObjectId:
    case FilmLayer::kMaterialId:
    case FilmLayer::kMotion:
      return FilmLayer::kPrimitiveId;
    case FilmLayer::kViewNormal:
      return FilmLayer::kNormal;
    case FilmLayer::kMetallic:
    case FilmLayer::kOcclusion:
    case FilmLayer::kCoverage:
      return FilmLayer::kRoughness;
    default:
      return layer;
  }
}

std::optional<std::size_t> LayerPlan::place_of(FilmLayer source) const {
  const auto found = std::find(sources.begin(), sources.end(), source);
  if (found == sources.end()) return std::nullopt;
  return std::size_t(found - sources.begin());
}

bool LayerPlan::wants(FilmLayer layer) const {
  return shown == layer || std::find(layers.begin(), layers.end(), layer) != layers.end();
}

bool LayerPlan::any(FilmLayerKind kind) const {
  return std::any_of(sources.begin(), sources.end(),
                     [&](FilmLayer source) { return row_of(source).kind == kind; });
}

bool LayerPlan::any_matte() const {
  return std::any_of(layers.begin(), layers.end(),
                     [](FilmLayer layer) { return row_of(layer).kind == FilmLayerKind::kMatte; });
}

LayerPlan plan_layers(const OutputSpec& output) {
  LayerPlan plan{output.layers, output.shown, {}};
  const auto draw = [&](FilmLayer layer) {
    const FilmLayer source = source_of(layer);
    if (row_of(layer).kind != FilmLayerKind::kMatte && !plan.place_of(source)) plan.sources.push_back(source);
  };
  for (const FilmLayer layer : plan.layers) draw(layer);
  if (plan.shown) draw(*plan.shown);
  if (plan.wants(FilmLayer::kMotion)) draw(FilmLayer::kPosition);
  return plan;
}

}  // namespace furnace
