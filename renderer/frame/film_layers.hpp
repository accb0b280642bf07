// The film layers of a picture, gathered tile by tile.
#pragma once

#include <vector>

#include "renderer/frame/cryptomatte.hpp"
#include "renderer/frame/frame_plan.hpp"
#include "renderer/residency/prepared_scene.hpp"

namespace furnace {

// Threads: one. Owns: its images and the counts of one tile's mattes.
class FilmLayers {
 public:
  // The three outlive it.
  FilmLayers(const FramePlan& plan, const View& view, const PreparedScene& scene);

  // RGBA kFloat32 as a tile was drawn, for all that `source` serves.
  void store(FilmLayer source, const Image& drawn, const Tile& tile);

  // Mattes: of one tile after another, all sub-frames, then what they come to. `keys`: as MatteTile::add().
  void begin_mattes(const Tile& tile);
  void add_to_mattes(const std::vector<std::uint32_t>& keys, float weight);
  void store_mattes(const Tile& tile);

  // As they stand in a file.
  std::vector<ImageLayer> take_layers();
  std::vector<TextField> attributes() const;
  // What is shown in place of the picture: RGBA kFloat32, its numbers and what of the pixel they are of; premultiplied, but of
  // places. Empty where nothing is, or a radiance.
  const Image& shown() const { return shown_; }

 private:
  struct Matte {
    std::vector<std::string> names;  // of draws, in their order
    std::vector<float> id_of_key;    // as MatteTile::add()
    MatteTile tile{Extent{}};
  };
  // Of one pixel as it was drawn.
  glm::vec4 numbers_of(FilmLayer layer, const glm::vec4& drawn) const;
  Matte matte_of(FilmLayer layer) const;

  const FramePlan& plan_;
  const View& view_;
  const PreparedScene& scene_;
  std::vector<FilmLayer> kept_;     // without mattes
  std::vector<ImageLayer> images_;  // of kept_, then of mattes_, a level each
  std::vector<std::pair<FilmLayer, Matte>> mattes_;
  std::vector<float> object_of_key_, material_of_key_;  // by key of a draw
  Image shown_;
};

}  // namespace furnace
