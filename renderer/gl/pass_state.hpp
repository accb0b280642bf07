// All state a pass relies on, as one value: passes can be reordered and tested alone.
#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "renderer/gl/gl.hpp"
#include "renderer/image/image.hpp"

namespace furnace::gl {

// kTest: nearer or equal; kSelect: equal; kWrite: always.
enum class DepthUse { kOff, kTest, kTestAndWrite, kSelect, kWrite };
enum class Blend {
  kOff,
  kPremultiplied,  // source + (1 - source alpha) * destination
  kAdd,
  kOr,  // bits of an integer target
};

// Of a target, px; row 0 is the top.
struct PixelRect {
  GLint x = 0, y = 0;
  GLsizei width = 0, height = 0;

  bool empty() const { return width == 0 || height == 0; }
};

// The least that holds both.
PixelRect joined(const PixelRect& a, const PixelRect& b);

struct PassState {
  GLuint framebuffer = 0;
  Extent viewport;
  std::optional<PixelRect> scissor;  // of what is cleared, too
  DepthUse depth = DepthUse::kOff;
  Blend blend = Blend::kOff;
  std::optional<glm::vec4> clear_color;
  bool clear_depth = false;  // to 0: reversed depth
};

void begin_pass(Context&, const PassState& state);

}  // namespace furnace::gl
