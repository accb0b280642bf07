// What surface shaders are told when they draw a film layer in place of radiance.
#pragma once

#include "renderer/frame/passes.hpp"

namespace furnace {

// Of a draw with `features`: those that what the pass shows depends on, and those that say what it shows.
gl::FeatureSet shown_features(const PassContext& pass, gl::FeatureSet features);
// Tells a program of such features the rest.
void set_shown(const PassContext& pass, GLuint program);

}  // namespace furnace
