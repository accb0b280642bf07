// Which drawings the film layers of a picture need.
#pragma once

#include <optional>
#include <vector>

#include "renderer/scene/render_spec.hpp"

namespace furnace {

// The film layer whose drawing serves `layer` too: depths come from positions, several factors from one drawing of three. Motion
// needs positions beside it.
FilmLayer source_of(FilmLayer layer);

struct LayerPlan {
  std::vector<FilmLayer> layers;   // kept beside the picture
  std::optional<FilmLayer> shown;  // stands in place of the picture
  std::vector<FilmLayer> sources;  // what is drawn for all of these, each once; mattes need no drawing

  // Of one of `sources` its place among them.
  std::optional<std::size_t> place_of(FilmLayer source) const;
  bool wants(FilmLayer layer) const;   // beside the picture or in its place
  bool any(FilmLayerKind kind) const;  // among `sources`
  bool any_matte() const;
  // Whether the picture itself must be shaded: it is kept, or its glow is.
  bool needs_picture() const { return !shown || place_of(FilmLayer::kGlow); }
  // Whether what is shown goes through the picture's own tone curve; else layer_view.hpp makes a picture of its numbers.
  bool shows_radiance() const { return shown && row_of(*shown).exposed; }
};

LayerPlan plan_layers(const OutputSpec& output);

}  // namespace furnace
