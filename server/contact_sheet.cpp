#include "server/contact_sheet.hpp"

#include <cmath>

#include "renderer/base/check.hpp"

namespace furnace {
namespace {

constexpr int kChannels = 4;

int columns_for(int count, int columns) {
  return columns > 0 ? columns : int(std::ceil(std::sqrt(double(count))));
}

}  // namespace

Extent ContactSheetPicture::extent_of(int count, int columns, int cell_px) {
  const int across = columns_for(count, columns);
  return {across * cell_px, (count + across - 1) / across * cell_px};
}

ContactSheetPicture::ContactSheetPicture(int count, int columns, int cell_px)
    : columns_(columns_for(count, columns)),
      cell_px_(cell_px),
      image_(
          make_image(extent_of(count, columns, cell_px), kChannels, SampleType::kUint8, ColorSpace::kSrgb)) {}

void ContactSheetPicture::put(int cell, const Image& picture) {
  const Extent size = picture.extent;
  FURNACE_CHECK(size.width <= cell_px_ && size.height <= cell_px_, "a picture of {} x {} in a cell of {}",
                size.width, size.height, cell_px_);
  const int left = cell % columns_ * cell_px_ + (cell_px_ - size.width) / 2;
  const int top = cell / columns_ * cell_px_ + (cell_px_ - size.height) / 2;
  const auto from = picture.samples<std::uint8_t>();
  const auto to = image_.samples<std::uint8_t>();
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const std::size_t source =
          (std::size_t(y) * std::size_t(size.width) + std::size_t(x)) * std::size_t(picture.channels);
      const std::size_t target =
          (std::size_t(top + y) * std::size_t(image_.extent.width) + std::size_t(left + x)) * kChannels;
      for (int c = 0; c < kChannels; ++c)
        to[target + std::size_t(c)] = c < picture.channels ? from[source + std::size_t(c)] : 255;
    }
  }
}

}  // namespace furnace
