// A Painter that needs no GL: one colour, notes and delays as a test wants them.
#pragma once

#include <atomic>
#include <functional>
#include <vector>

#include "renderer/image/image.hpp"
#include "server/render_service.hpp"

namespace furnace::testing {

// Threads: any. Owns: what it was told.
class FakePainter {
 public:
  std::vector<Note> notes;
  std::function<void(const Deadline&)> before_drawing;  // may wait or throw
  std::atomic<int> drawn = 0;

  Painter painter(std::string fingerprint = "fake/1") {
    return {[this](const RenderSpec& spec, const Deadline& deadline, const TellStage& tell) {
              if (tell) tell("bake", 0.5);
              return draw(spec, deadline);
            },
            [](const RenderSpec&, const Deadline&) {
              return SceneOutline{{{glm::vec3(-1), glm::vec3(1)}, {{0, 0}, {1, 0}}, {{0, 0}, {1, 0}}}, 1};
            },
            std::move(fingerprint)};
  }

 private:
  Film draw(const RenderSpec& spec, const Deadline& deadline) {
    if (before_drawing) before_drawing(deadline);
    check_deadline(deadline, "draw");
    ++drawn;
    const Extent extent{spec.output.width, spec.output.height};
    const bool exr = spec.output.format == OutputFormat::kExr;
    Film film;
    film.image = exr ? make_image(extent, 3, spec.output.exr_type, ColorSpace::kLinear)
                     : make_image(extent, 3, SampleType::kUint8, ColorSpace::kSrgb);
    film.notes = notes;
    film.times.draw_ms = 1;
    film.exposure_ev = 0.25;
    return film;
  }
};

}  // namespace furnace::testing
