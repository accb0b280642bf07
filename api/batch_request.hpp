// Many renders asked for at once: one request and what differs from it.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/scene/scene.hpp"
#include "api/render_request.hpp"

namespace furnace::api {

struct BatchItem {
  std::string name;      // of its file, without an ending; each once
  std::string document;  // a render request
  std::string changes;   // what differs, as a JSON object by pointers
};

// {"request": {...}, "items": [{"name": "front", "changes": {"/camera/orbit/azimuthDegrees": 0}}, ...],
//  "vary": [{"pointer": "/output/width", "values": [320, 640]}, ...]}: every item in every combination of values, the last of
// "vary" changing fastest. Errors: kInvalidRequest for what is no JSON; kUnprocessable with `problems`; kTooLarge for more than
// `max_items`, or documents larger than a request may be.
std::vector<BatchItem> parse_batch(std::string_view json, const RequestLimits& limits, int max_items);

// What became of an item.
struct BatchOutcome {
  std::string name, changes;
  std::string file;     // empty: it failed
  std::string problem;  // problem document, of one that failed
  std::vector<Note> notes;
};
// index.json of the archive.
std::string batch_index_json(const std::vector<BatchOutcome>& outcomes);

}  // namespace furnace::api
