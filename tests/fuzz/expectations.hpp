// What holds of whatever comes out of an import.
#pragma once

#include "renderer/scene/gltf_import.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace::fuzz {

// So small that no input takes longer than a moment: what does take long is a finding.
ImportLimits small_import_limits();

// Aborts unless indices, lengths and numbers are as scene.hpp says.
void expect_whole(const Scene& scene);

}  // namespace furnace::fuzz
