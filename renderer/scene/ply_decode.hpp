// PLY -> parts of a PlainModel: faces, strips, edges, or the vertices of a cloud.
#pragma once

#include <cstddef>
#include <span>

#include "renderer/base/deadline.hpp"
#include "renderer/scene/model_builder.hpp"

namespace furnace {

// Elements vertex, face, tristrips and edge, with the names of properties that are in use, in any order; all others are
// skipped. Coordinates of textures may be a vertex's or a corner's, colours a vertex's or a face's; a splat's colour is the
// constant term of its harmonics. A triangle that names a vertex twice is left out.
// Errors: kUnprocessable that names row and line or byte; kTooLarge for a limit; kDeadlineExceeded. Work grows with the
// file's size, but for polygons that are no fan, see polygon.hpp.
void add_ply(std::span<const std::byte> document, ModelBuilder& builder, const Deadline& deadline);

}  // namespace furnace
