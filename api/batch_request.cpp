#include "api/batch_request.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "renderer/base/error.hpp"
#include "api/document.hpp"
#include "api/problem.hpp"

namespace furnace::api {

namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kMostNameBytes = 100;
constexpr std::size_t kMostIndexDigits = 9;  // more than any array of a request has
constexpr std::int64_t kMostDocuments = 64;  // times the largest request, all together

struct Item {
  std::string name;
  Json changes = Json::object();
};

// One value of a dimension.
struct Choice {
  Json changes = Json::object();
  std::string suffix;  // of the name
  int width_px = 0;    // of a set of widths; 0: none
};
using Dimension = std::vector<Choice>;

const Json& native(const Value& value) {
  return *static_cast<const Json*>(value.native());
}

bool is_file_name(std::string_view name) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  return !name.empty() && name.size() <= kMostNameBytes && name.front() != '.' &&
         name.find_first_not_of(kPlain) == name.npos;
}

// Reads what a batch says; every fault is told.
// Threads: one. Owns: the faults found.
class Reader {
 public:
  explicit Reader(int max_depth) : max_depth_(max_depth) {}

  std::vector<Item> items;
  std::vector<Dimension> dimensions;
  Json request = Json::object();
  std::optional<ContactSheet> sheet;

  void read(const Value& root) {
    if (!expect(root, JsonType::kObject, "an object")) fail_if_any(std::move(problems_));
    allow(root, {"request", "items", "vary", "turntable", "srcset", "contactSheet"});
    if (const Value base = root["request"]; base && expect(base, JsonType::kObject, "a render request"))
      request = native(base);
    if (const Value list = root["items"]; list && expect(list, JsonType::kArray, "an array"))
      for (std::size_t i = 0; i < list.size(); ++i) read_item(list.at(i), i);
    if (const Value list = root["vary"]; list && expect(list, JsonType::kArray, "an array"))
      for (std::size_t i = 0; i < list.size(); ++i) read_dimension(list.at(i));
    if (const Value turntable = root["turntable"]) read_turntable(turntable);
    if (const Value srcset = root["srcset"]) read_srcset(srcset);
    if (const Value wanted = root["contactSheet"]) read_sheet(wanted);
    if (!root["items"] && dimensions.empty() && problems_.empty())
      add(root, "needs items, vary, turntable or srcset; one picture is a render");
    if (root["items"] && items.empty() && problems_.empty()) add(root["items"], "has no item");
    fail_if_any(std::move(problems_));
    if (items.empty()) items.push_back({});
  }

 private:
  void add(const Value& place, std::string what) { problems_.push_back({place.pointer(), std::move(what)}); }

  bool expect(const Value& value, JsonType type, std::string_view what) {
    if (value.type() == type) return true;
    add(value, fmt::format("must be {}", what));
    return false;
  }

  void allow(const Value& object, std::initializer_list<std::string_view> known) {
    for (const auto& member : object.members())
      if (std::find(known.begin(), known.end(), member.first) == known.end())
        add(member.second, fmt::format("is not known; there are {}", fmt::join(known, ", ")));
  }

  // Within a range, or told.
  int number(const Value& value, int least, int most) {
    const bool is_number = (value.type() == JsonType::kNumber || value.type() == JsonType::kInteger) &&
                           value.number() == std::floor(value.number());
    if (is_number && value.number() >= least && value.number() <= most) return value.integer();
    add(value, fmt::format("must be a whole number from {} to {}", least, most));
    return least;
  }

  // Whatever a sequence may have goes into it; its own reader judges it.
  void read_turntable(const Value& value) {
    if (!expect(value, JsonType::kObject, "an object as output.sequence of a render")) return;
    Choice choice;
    Json sequence = {{"frames", 24}, {"turntableDegrees", 360}};
    sequence.update(native(value));
    choice.changes["/output/sequence"] = std::move(sequence);
    dimensions.push_back({std::move(choice)});
  }

  void read_srcset(const Value& value) {
    if (!expect(value, JsonType::kObject, "an object with widths and formats")) return;
    allow(value, {"widths", "formats"});
    Dimension by_width, by_format;
    std::set<std::string> seen;  // no format is named as a width is
    if (const Value widths = value["widths"]; expect(widths, JsonType::kArray, "an array of widths in px")) {
      for (std::size_t i = 0; i < widths.size(); ++i) {
        Choice choice;
        choice.width_px = number(widths.at(i), 1, 1 << 20);
        choice.suffix = fmt::format("{}w", choice.width_px);
        if (!seen.insert(choice.suffix).second) add(widths.at(i), "is there twice");
        by_width.push_back(std::move(choice));
      }
      if (by_width.empty()) add(widths, "has no width");
    }
    if (const Value formats = value["formats"]; formats && expect(formats, JsonType::kArray, "an array")) {
      for (std::size_t i = 0; i < formats.size(); ++i) {
        if (!expect(formats.at(i), JsonType::kText, "the name of a format")) continue;
        Choice choice;
        choice.changes["/output/format"] = native(formats.at(i));
        if (!seen.insert(std::string(formats.at(i).text())).second) add(formats.at(i), "is there twice");
        by_format.push_back(std::move(choice));
      }
      if (formats.size() == 0) add(formats, "has no format");
    }
    dimensions.push_back(std::move(by_width));
    if (!by_format.empty()) dimensions.push_back(std::move(by_format));
  }

  void read_sheet(const Value& value) {
    if (!expect(value, JsonType::kObject, "an object with columns and cellPx")) return;
    allow(value, {"columns", "cellPx"});
    sheet.emplace();
    if (const Value columns = value["columns"]) sheet->columns = number(columns, 1, 1000);
    if (const Value cell = value["cellPx"]) sheet->cell_px = number(cell, 16, 2048);
  }

  bool is_pointer(const Value& place, const std::string& text) {
    if (std::ranges::count(text, '/') > max_depth_) {
      add(place, fmt::format("leads more than {} levels deep", max_depth_));
      return false;
    }
    try {
      if (!text.empty() && !Json::json_pointer(text).empty()) return true;
    } catch (const Json::exception&) {
    }
    add(place, "must be a JSON pointer into the request, such as /output/width");
    return false;
  }

  void read_item(const Value& value, std::size_t index) {
    if (!expect(value, JsonType::kObject, "an object with name and changes")) return;
    Item item;
    item.name = fmt::format("item_{:04}", index + 1);
    for (const auto& [key, member] : value.members()) {
      if (key == "name") {
        if (!expect(member, JsonType::kText, "a text")) continue;
        item.name = std::string(member.text());
        if (!is_file_name(item.name))
          add(member, "must be a file's name of letters, digits, '.', '_' and '-'");
      } else if (key == "changes") {
        if (!expect(member, JsonType::kObject, "an object by JSON pointers")) continue;
        for (const auto& [pointer, change] : member.members()) is_pointer(change, pointer);
        item.changes = native(member);
      } else {
        add(member, "is not known; an item has name and changes");
      }
    }
    if (!names_.insert(item.name).second) add(value, "has the name of another item");
    items.push_back(std::move(item));
  }

  void read_dimension(const Value& value) {
    if (!expect(value, JsonType::kObject, "an object with pointer and values")) return;
    for (const auto& [key, member] : value.members())
      if (key != "pointer" && key != "values") add(member, "is not known; it has pointer and values");
    const Value pointer = value["pointer"], values = value["values"];
    if (!expect(pointer, JsonType::kText, "a JSON pointer") || !expect(values, JsonType::kArray, "an array"))
      return;
    const std::string text(pointer.text());
    if (!is_pointer(pointer, text)) return;
    if (values.size() == 0) return add(values, "has no value");
    Dimension dimension;
    for (std::size_t i = 0; i < values.size(); ++i) {
      Choice choice;
      choice.changes[text] = native(values.at(i));
      choice.suffix = fmt::format("{:03}", i + 1);
      dimension.push_back(std::move(choice));
    }
    dimensions.push_back(std::move(dimension));
  }

  const int max_depth_;
  std::vector<Problem> problems_;
  std::set<std::string> names_;
};

// Whether each index on the way is of an element, or of the next one: the library would make all those before it.
bool has_elements(const Json& document, Json::json_pointer pointer) {
  for (; !pointer.empty(); pointer.pop_back()) {
    const Json::json_pointer above = pointer.parent_pointer();
    const bool is_there = document.contains(above);
    if (is_there && !document.at(above).is_array()) continue;
    const std::string& token = pointer.back();
    const bool is_index = !token.empty() && token.find_first_not_of("0123456789") == token.npos;
    const std::size_t size = is_there ? document.at(above).size() : 0;
    if (is_index && (token.size() > kMostIndexDigits || std::stoul(token) > size)) return false;
  }
  return true;
}

// Makes what lies on the way.
void change(Json& document, const std::string& pointer, const Json& value) {
  const Json::json_pointer place(pointer);
  try {
    if (has_elements(document, place)) {
      document[place] = value;
      return;
    }
  } catch (const Json::exception&) {
  }
  fail(ErrorCode::kUnprocessable, fmt::format("the request has no place {}", pointer), {});
}

// The height that keeps a document's aspect ratio at another width; what is no size is left to the document's own reader.
Json height_at(const Json& document, int width_px) {
  const auto side = [&](const char* pointer) {
    const Json value = document.value(Json::json_pointer(pointer), Json(OutputSpec{}.width));
    return value.is_number() ? value.get<double>() : 0;
  };
  const double height_px = std::round(width_px * side("/output/height") / side("/output/width"));
  return height_px >= 1 && height_px <= 1 << 20 ? Json(int(height_px)) : Json(1);
}

BatchItem combine(const Json& request, const Item& item, const std::vector<Dimension>& dimensions,
                  std::size_t combination) {
  Json document = request, changes = item.changes;
  std::vector<const Choice*> choices(dimensions.size());
  for (std::size_t d = dimensions.size(); d-- > 0;) {
    choices[d] = &dimensions[d][combination % dimensions[d].size()];
    combination /= dimensions[d].size();
    changes.update(choices[d]->changes);
  }
  for (const auto& [pointer, value] : changes.items()) change(document, pointer, value);
  BatchItem out;
  out.name = item.name;
  for (const Choice* choice : choices) {
    if (choice->width_px > 0) {
      out.srcset = out.name;
      out.width_px = choice->width_px;
      const Json height = height_at(document, choice->width_px);
      for (const auto& [pointer, value] :
           {std::pair("/output/width", Json(choice->width_px)), {"/output/height", height}}) {
        change(document, pointer, value);
        changes[pointer] = value;
      }
    }
    if (!choice->suffix.empty()) out.name += (out.name.empty() ? "" : "_") + choice->suffix;
  }
  if (out.name.empty()) out.name = "turntable";
  out.document = document.dump(-1, ' ', false, Json::error_handler_t::replace);
  out.changes = changes.dump(-1, ' ', false, Json::error_handler_t::replace);
  return out;
}

}  // namespace

Batch parse_batch(std::string_view json, const RequestLimits& limits, int max_items) {
  const Document document = Document::parse(json, {limits.max_json_depth, limits.max_json_bytes});
  Reader reader(limits.max_json_depth);
  reader.read(document.root());
  const auto most = std::size_t(max_items);
  std::size_t combinations = 1;
  for (const Dimension& dimension : reader.dimensions)
    combinations = std::min(combinations * dimension.size(), most + 1);
  if (combinations * reader.items.size() > most)
    fail(ErrorCode::kTooLarge, fmt::format("A batch has at most {} renders.", max_items));

  Batch batch{{}, reader.sheet};
  std::int64_t bytes = 0;
  for (const Item& item : reader.items) {
    for (std::size_t combination = 0; combination < combinations; ++combination) {
      batch.items.push_back(combine(reader.request, item, reader.dimensions, combination));
      bytes += std::int64_t(batch.items.back().document.size());
      if (bytes > kMostDocuments * limits.max_json_bytes)
        fail(ErrorCode::kTooLarge, "The requests of this batch are too large together.");
    }
  }
  return batch;
}

namespace {

// As <img srcset> and <source srcset> have it, for each set and format.
OrderedJson srcsets(const std::vector<BatchOutcome>& outcomes) {
  OrderedJson sets = OrderedJson::array();
  for (const BatchOutcome& outcome : outcomes) {
    if (outcome.item.width_px == 0 || outcome.file.empty()) continue;
    const std::string format = outcome.file.substr(outcome.file.rfind('.') + 1);
    const std::string candidate = fmt::format("{} {}w", outcome.file, outcome.item.width_px);
    const auto known = std::find_if(sets.begin(), sets.end(), [&](const OrderedJson& set) {
      return set["name"] == outcome.item.srcset && set["format"] == format;
    });
    if (known == sets.end())
      sets.push_back({{"name", outcome.item.srcset}, {"format", format}, {"srcset", candidate}});
    else
      (*known)["srcset"] = (*known)["srcset"].get<std::string>() + ", " + candidate;
  }
  return sets;
}

}  // namespace

std::string batch_index_json(const std::vector<BatchOutcome>& outcomes, int sheet_columns) {
  OrderedJson list = OrderedJson::array();
  for (const BatchOutcome& outcome : outcomes) {
    OrderedJson item = {{"name", outcome.item.name},
                        {"changes", OrderedJson::parse(outcome.item.changes, nullptr, false)}};
    const int cell = int(list.size());
    if (sheet_columns > 0) item["cell"] = {{"row", cell / sheet_columns}, {"column", cell % sheet_columns}};
    if (!outcome.file.empty()) item["file"] = outcome.file;
    if (!outcome.problem.empty()) item["problem"] = OrderedJson::parse(outcome.problem, nullptr, false);
    OrderedJson notes = OrderedJson::array();
    for (const Note& note : outcome.notes)
      notes.push_back({{"code", note.code}, {"pointer", note.pointer}, {"message", note.message}});
    item["notes"] = std::move(notes);
    list.push_back(std::move(item));
  }
  OrderedJson index = {{"items", std::move(list)}};
  if (sheet_columns > 0) index["contactSheet"] = kContactSheetFile;
  if (OrderedJson sets = srcsets(outcomes); !sets.empty()) index["srcsets"] = std::move(sets);
  return index.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace furnace::api
