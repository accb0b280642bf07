// A finished render as one file: what a cache on disk keeps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace::api {

struct StoredRender {
  std::string bytes;       // of the picture's file
  std::string media_type;  // of it
  double exposure_ev = 0;  // stops by which radiance was multiplied
  int frames = 1;
  std::vector<Note> notes;
  std::string report;  // as render_report_json wrote it
};

// Raised when older files cannot be read.
inline constexpr int kStoredRenderLayout = 1;

std::string encode_stored_render(const StoredRender& render);
// Errors: kUnprocessable for what is damaged, cut off or was not written by encode_stored_render.
StoredRender decode_stored_render(const std::string& file);

}  // namespace furnace::api
