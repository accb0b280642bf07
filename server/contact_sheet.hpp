// Many pictures in one, for who looks them over.
#pragma once

#include "renderer/image/image.hpp"

namespace furnace {

// `count` cells of `cell_px` a side, row by row, in the fewest rows. Threads: one. Owns: its pixels.
class ContactSheetPicture {
 public:
  // `columns` 0: as many as rows.
  ContactSheetPicture(int count, int columns, int cell_px);

  static Extent extent_of(int count, int columns, int cell_px);
  int columns() const { return columns_; }
  // Into the middle of a cell, which it fits into; of 8 bits with three or four channels.
  void put(int cell, const Image& picture);
  const Image& image() const { return image_; }  // RGBA, 8 bits; transparent where nothing was put

 private:
  const int columns_, cell_px_;
  Image image_;
};

}  // namespace furnace
