// Who draws: a Renderer in the product; tests that need no GL bring their own.
#pragma once

#include <functional>
#include <string>

#include "renderer/renderer.hpp"

namespace furnace {

struct Painter {
  std::function<Film(const RenderSpec&, const Deadline&, const TellStage&)> render;
  std::function<SceneOutline(const RenderSpec&, const Deadline&)> outline;
  std::string fingerprint;  // what makes pixels besides the request
};

inline Painter painter_of(Renderer& renderer) {
  return {[&renderer](const RenderSpec& spec, const Deadline& deadline, const TellStage& tell) {
            return renderer.render(spec, deadline, tell);
          },
          [&renderer](const RenderSpec& spec, const Deadline& deadline) {
            return renderer.outline(spec, deadline);
          },
          renderer.fingerprint().text()};
}

}  // namespace furnace
