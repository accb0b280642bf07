// Runs a GLSL expression over many inputs, so that shader functions get real unit tests.
#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/gl/gl.hpp"

namespace furnace::test {

// `includes`: library files; `body`: statements that read `vec4 x` and write `vec4 result`. One result per input.
std::vector<glm::vec4> evaluate_glsl(gl::Context& context, const std::vector<std::string>& includes,
                                     const std::string& body, const std::vector<glm::vec4>& inputs);

}  // namespace furnace::test
