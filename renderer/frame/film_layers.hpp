// The film layers of a picture, gathered tile by tile.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/frame/cryptomatte.hpp"
#include "renderer/frame/frame_plan.hpp"
#include "renderer/frame/motion_vectors.hpp"
#include "renderer/residency/prepared_scene.hpp"

namespace furnace {

// Threads: one. Owns: its images and the counts of one tile's mattes.
class FilmLayers {
 public:
  // In the middle of the shutter; `earlier`: as in MotionVectors, or null: nothing moves.
  struct Subject {
    const View& view;
    const PreparedScene& scene;
    const EarlierScene* earlier;
  };
  // `seen`: the scenes of the sub-frames' moments. All outlive it.
  FilmLayers(const FramePlan& plan, const Subject& subject, const std::vector<const PreparedScene*>& seen);

  // RGBA kFloat32 as a tile was drawn, for all that `source` serves.
  void store(FilmLayer source, const Image& drawn, const Tile& tile);
  // Of the positions and numbers of that tile, if motion is wanted.
  void store_motion(const Image& positions, const Image& numbers, const Tile& tile);

  // Mattes: of one tile after another, all sub-frames, then what they come to. `keys`: as MatteTile::add(), in the scene of
  // `moment` among those seen.
  void begin_mattes(const Tile& tile);
  void add_to_mattes(const std::vector<std::uint32_t>& keys, float weight, std::size_t moment);
  void store_mattes(const Tile& tile);

  // As they stand in a file.
  std::vector<ImageLayer> take_layers();
  std::vector<TextField> attributes() const;
  // What is shown in place of the picture: RGBA kFloat32, its numbers and what of the pixel they are of; premultiplied, but of
  // places. Empty where nothing is, or a radiance.
  const Image& shown() const { return shown_; }

 private:
  struct Matte {
    std::vector<std::string> names;             // of all draws
    std::vector<std::vector<float>> id_of_key;  // of each moment, as MatteTile::add()
    MatteTile tile{Extent{}};
  };
  // Of one pixel as it was drawn.
  glm::vec4 numbers_of(FilmLayer layer, const glm::vec4& drawn) const;
  Matte matte_of(FilmLayer layer, const std::vector<const PreparedScene*>& seen) const;
  void put_all(FilmLayer layer, std::size_t pixel, const glm::vec4& numbers);

  const FramePlan& plan_;
  const View& view_;
  std::optional<MotionVectors> motion_;
  std::vector<FilmLayer> kept_;     // without mattes
  std::vector<ImageLayer> images_;  // of kept_, then of mattes_, a level each
  std::vector<std::pair<FilmLayer, Matte>> mattes_;
  std::vector<float> object_of_key_, material_of_key_;  // by key of a draw
  Image shown_;
};

}  // namespace furnace
