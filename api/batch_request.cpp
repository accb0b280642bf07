#include "api/batch_request.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include <fmt/format.h>
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

struct Dimension {
  std::string pointer;
  Json values;
};

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

  void read(const Value& root) {
    if (!expect(root, JsonType::kObject, "an object")) fail_if_any(std::move(problems_));
    for (const auto& [key, value] : root.members())
      if (key != "request" && key != "items" && key != "vary")
        add(value, "is not known; a batch has request, items and vary");
    if (const Value base = root["request"]; base && expect(base, JsonType::kObject, "a render request"))
      request = native(base);
    if (const Value list = root["items"]; list && expect(list, JsonType::kArray, "an array"))
      for (std::size_t i = 0; i < list.size(); ++i) read_item(list.at(i), i);
    if (const Value list = root["vary"]; list && expect(list, JsonType::kArray, "an array"))
      for (std::size_t i = 0; i < list.size(); ++i) read_dimension(list.at(i));
    if (!root["items"] && !root["vary"]) add(root, "needs items or vary; one picture is a render");
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
    dimensions.push_back({text, native(values)});
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

BatchItem combine(const Json& request, const Item& item, const std::vector<Dimension>& dimensions,
                  std::size_t combination) {
  Json document = request, changes = item.changes;
  std::vector<std::size_t> indices(dimensions.size());
  for (std::size_t d = dimensions.size(); d-- > 0;) {
    const std::size_t count = dimensions[d].values.size();
    indices[d] = combination % count;
    combination /= count;
    changes[dimensions[d].pointer] = dimensions[d].values[indices[d]];
  }
  for (const auto& [pointer, value] : changes.items()) change(document, pointer, value);
  std::string name = item.name;
  for (const std::size_t index : indices) name += fmt::format("{}{:03}", name.empty() ? "" : "_", index + 1);
  return {std::move(name), document.dump(-1, ' ', false, Json::error_handler_t::replace),
          changes.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

}  // namespace

std::vector<BatchItem> parse_batch(std::string_view json, const RequestLimits& limits, int max_items) {
  const Document document = Document::parse(json, {limits.max_json_depth, limits.max_json_bytes});
  Reader reader(limits.max_json_depth);
  reader.read(document.root());
  const auto most = std::size_t(max_items);
  std::size_t combinations = 1;
  for (const Dimension& dimension : reader.dimensions)
    combinations = std::min(combinations * dimension.values.size(), most + 1);
  if (combinations * reader.items.size() > most)
    fail(ErrorCode::kTooLarge, fmt::format("A batch has at most {} renders.", max_items));

  std::vector<BatchItem> items;
  std::int64_t bytes = 0;
  for (const Item& item : reader.items) {
    for (std::size_t combination = 0; combination < combinations; ++combination) {
      items.push_back(combine(reader.request, item, reader.dimensions, combination));
      bytes += std::int64_t(items.back().document.size());
      if (bytes > kMostDocuments * limits.max_json_bytes)
        fail(ErrorCode::kTooLarge, "The requests of this batch are too large together.");
    }
  }
  return items;
}

std::string batch_index_json(const std::vector<BatchOutcome>& outcomes) {
  OrderedJson list = OrderedJson::array();
  for (const BatchOutcome& outcome : outcomes) {
    OrderedJson item = {{"name", outcome.name},
                        {"changes", OrderedJson::parse(outcome.changes, nullptr, false)}};
    if (!outcome.file.empty()) item["file"] = outcome.file;
    if (!outcome.problem.empty()) item["problem"] = OrderedJson::parse(outcome.problem, nullptr, false);
    OrderedJson notes = OrderedJson::array();
    for (const Note& note : outcome.notes)
      notes.push_back({{"code", note.code}, {"pointer", note.pointer}, {"message", note.message}});
    item["notes"] = std::move(notes);
    list.push_back(std::move(item));
  }
  return OrderedJson{{"items", std::move(list)}}.dump(2, ' ', false, OrderedJson::error_handler_t::replace) +
         "\n";
}

}  // namespace furnace::api
