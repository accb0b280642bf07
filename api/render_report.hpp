// How a picture came about, as JSON: the answer of /v1/reports.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace::api {

struct RenderReport {
  struct Stage {
    std::string_view name;  // as in Server-Timing
    double ms = 0;
    std::string_view cache;  // "hit", "disk"; empty: it was worked on
  };

  std::string request;      // hash of the canonical request, hex; as in the picture's own text
  std::string fingerprint;  // what makes pixels besides the request
  std::string etag;         // of the picture, without quotes
  std::string_view media_type;
  int width = 0, height = 0, samples = 0;
  int frames = 1;
  std::int64_t bytes = 0;  // of the file
  double exposure_ev = 0;  // stops by which radiance was multiplied
  std::vector<Stage> stages;
  std::vector<Note> notes;  // what was not drawn as asked; pointers lead into the model's document
};

std::string render_report_json(const RenderReport& report);

}  // namespace furnace::api
