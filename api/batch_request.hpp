// Many renders asked for at once: one request and what differs from it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/scene/scene.hpp"
#include "api/render_request.hpp"

namespace furnace::api {

struct BatchItem {
  std::string name;      // of its file, without an ending; with it each once
  std::string document;  // a render request
  std::string changes;   // what differs, as a JSON object by pointers
  std::string srcset;    // name of the set of widths that it belongs to; "": none
  int width_px = 0;      // in that set
};

inline constexpr std::string_view kContactSheetFile = "contact-sheet.png";

// A picture of all pictures, each fitted into a cell.
struct ContactSheet {
  int columns = 0;  // 0: as many as rows
  int cell_px = 256;
};

struct Batch {
  std::vector<BatchItem> items;
  std::optional<ContactSheet> sheet;
};

// {"request": {...}, "items": [{"name": "front", "changes": {"/camera/orbit/azimuthDegrees": 0}}, ...],
//  "vary": [{"pointer": "/output/width", "values": [320, 640]}, ...]}: every item in every combination of values, the last of
// "vary" changing fastest. Ready kinds, each of which goes with the others: "turntable": {"frames": 24} makes a sequence of every
// picture, "srcset": {"widths": [320, 640], "formats": ["webp", "png"]} draws it in these widths and formats, at its own aspect
// ratio, "contactSheet": {"columns": 4} asks for a sheet. Errors: kInvalidRequest for what is no JSON; kUnprocessable with `problems`; kTooLarge for more than
// `max_items`, or documents larger than a request may be.
Batch parse_batch(std::string_view json, const RequestLimits& limits, int max_items);

// What became of an item.
struct BatchOutcome {
  BatchItem item;
  std::string file;     // empty: it failed
  std::string problem;  // problem document, of one that failed
  std::vector<Note> notes;
};
// index.json of the archive: `sheet_columns` of its contact sheet, 0 without one.
std::string batch_index_json(const std::vector<BatchOutcome>& outcomes, int sheet_columns);

}  // namespace furnace::api
