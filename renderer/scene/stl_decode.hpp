// STL, binary or text -> one part of a PlainModel.
#pragma once

#include <cstddef>
#include <span>

#include "renderer/scene/model_builder.hpp"

namespace furnace {

// Facets stay flat, and their normals are those of their corners, whatever the file says. Bytes behind the facets that a
// binary file announces do not count; a facet of a text with more than three corners is a fan.
// Errors: kUnprocessable for a file that ends early, and one that is neither binary nor text; kTooLarge for a limit.
void add_stl(std::span<const std::byte> document, ModelBuilder& builder);

}  // namespace furnace
