// The seven primitive modes of glTF 2.0 (section 3.7.2.1) as plain points, lines and triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace {

Topology topology_of(int mode);
bool is_triangle_mode(int mode);

// Points, lines or triangles that `indices` vertices make, degenerate ones included.
std::uint64_t element_count(int mode, std::uint64_t indices);
// Whether vertices at the end are too few for a whole line or triangle.
bool has_left_over(int mode, std::uint64_t indices);

// Strips, fans and loops become lists, windings kept; lines and triangles that name a vertex twice are
// dropped.
std::vector<std::uint32_t> expand_topology(int mode, std::vector<std::uint32_t> indices);

}  // namespace furnace
