#include "api/document.hpp"

#include "api/problem.hpp"
#include "renderer/base/check.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace furnace::api {
namespace {

using Json = nlohmann::json;

const Json& json_of(const void* node) {
  return *static_cast<const Json*>(node);
}

// The longest prefix of at most `max_bytes` that does not divide a UTF-8 sequence.
std::string_view shortened(std::string_view text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  std::size_t end = max_bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end);
}

std::string line_and_column(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t last_break = before.rfind('\n');
  const std::size_t column = before.size() - (last_break == before.npos ? 0 : last_break + 1);
  return fmt::format("line {}, column {}", line, std::max<std::size_t>(column, 1));
}

// Builds the values while nlohmann's lexer reads, so that duplicate keys and depth are seen before anything
// is stored.
class Builder final : public nlohmann::json_sax<Json> {
 public:
  Builder(std::string_view text, const JsonLimits& limits) : text_(text), limits_(limits) {}

  const std::vector<Problem>& problems() const { return problems_; }
  Json take() { return std::move(root_); }

  bool null() override { return put(nullptr) != nullptr; }
  bool boolean(bool value) override { return put(value) != nullptr; }
  bool number_integer(number_integer_t value) override { return put(value) != nullptr; }
  bool number_unsigned(number_unsigned_t value) override {
    // Above int64 the judge would see a negative number.
    constexpr auto kMax = static_cast<number_unsigned_t>(std::numeric_limits<std::int64_t>::max());
    return (value > kMax ? put(static_cast<double>(value)) : put(static_cast<std::int64_t>(value))) !=
           nullptr;
  }
  bool number_float(number_float_t value, const string_t&) override {
    constexpr double kExact = 9007199254740992;  // 2^53: up to here each integer is one double
    const bool integral = std::abs(value) < kExact && std::trunc(value) == value;
    return (integral ? put(static_cast<std::int64_t>(value)) : put(value)) != nullptr;
  }
  bool string(string_t& value) override { return has_no_null(value) && put(std::move(value)) != nullptr; }
  bool binary(binary_t&) override { return refuse("binary values are not JSON"); }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& key) override {
    if (key.size() > static_cast<std::size_t>(limits_.max_key_bytes))
      return refuse(
          fmt::format("a key has {} bytes, at most {} are read", key.size(), limits_.max_key_bytes));
    if (!has_no_null(key)) return false;
    Frame& frame = frames_.back();
    frame.key = std::move(key);
    if (frame.container->contains(*frame.key)) return refuse("is there twice; leave one of the two out");
    return true;
  }

  bool parse_error(std::size_t position, const std::string& last_token,
                   const nlohmann::detail::exception& exception) override {
    constexpr int kNumberOverflow = 406;  // nlohmann's out_of_range.406
    if (exception.id == kNumberOverflow)
      return refuse(fmt::format("{} is beyond the range of a double", shortened(last_token, 40)));
    const bool printable = std::all_of(last_token.begin(), last_token.end(),
                                       [](unsigned char c) { return c >= 0x20 && c < 0x7F; });
    std::string near;
    if (position > text_.size() || last_token.empty())
      near = ": it ends too early";
    else if (printable)
      near = fmt::format(", near {}", shortened(last_token, 40));
    return refuse(fmt::format("is not valid JSON at {}{}", line_and_column(text_, position), near));
  }

 private:
  struct Frame {
    Json* container;
    std::optional<std::string> key;  // of the member being read
  };

  Json* put(Json value) {
    if (frames_.empty()) return &(root_ = std::move(value));
    Frame& frame = frames_.back();
    if (!frame.container->is_object()) {
      frame.container->push_back(std::move(value));
      return &frame.container->back();
    }
    Json* placed = &((*frame.container)[*frame.key] = std::move(value));
    if (!placed->is_structured()) frame.key.reset();
    return placed;
  }

  bool open(Json container) {
    if (frames_.size() >= static_cast<std::size_t>(limits_.max_depth))
      return refuse(fmt::format("is nested more than {} levels deep", limits_.max_depth));
    Json* placed = put(std::move(container));
    frames_.push_back({placed, {}});
    return true;
  }

  bool close() {
    frames_.pop_back();
    if (!frames_.empty()) frames_.back().key.reset();
    return true;
  }

  // The judge counts characters up to the first U+0000.
  bool has_no_null(const std::string& text) {
    return text.find('\0') == text.npos || refuse("has the character U+0000, which no text may have");
  }

  bool refuse(std::string message) {
    problems_.push_back({pointer(), std::move(message)});
    return false;
  }

  std::string pointer() const {
    std::string pointer;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const Frame& frame = frames_[i];
      if (frame.key) pointer.append("/").append(pointer_token(*frame.key));
      if (!frame.container->is_array()) continue;
      const bool element_is_open = i + 1 < frames_.size();  // then it is already in the array
      pointer += fmt::format("/{}", frame.container->size() - (element_is_open ? 1 : 0));
    }
    return pointer;
  }

  std::string_view text_;
  JsonLimits limits_;
  Json root_;
  std::vector<Frame> frames_;
  std::vector<Problem> problems_;  // none or one: reading stops
};

}  // namespace

struct Document::State {
  Json root;
};

Document::Document(std::shared_ptr<const State> state) : state_(std::move(state)) {}

Document Document::parse(std::string_view text, const JsonLimits& limits) {
  if (static_cast<std::int64_t>(text.size()) > limits.max_bytes)
    fail_if_any({{"", fmt::format("has {} bytes, at most {} are read", text.size(), limits.max_bytes)}},
                ErrorCode::kTooLarge);
  // The lexer takes NUL for the end of the text and would overlook what follows.
  if (const std::size_t nul = text.find('\0'); nul != text.npos)
    fail_if_any({{"", "is not valid JSON at " + line_and_column(text, nul + 1) + ": a NUL byte"}},
                ErrorCode::kInvalidRequest);
  Builder builder(text, limits);
  const bool complete = Json::sax_parse(text.begin(), text.end(), &builder);
  fail_if_any(builder.problems(), ErrorCode::kInvalidRequest);
  FURNACE_CHECK(complete, "the lexer stopped without an error");
  return Document(std::make_shared<const State>(State{builder.take()}));
}

Value Document::root() const {
  return Value(&state_->root, "");
}

JsonType Value::type() const {
  if (!node_) return JsonType::kAbsent;
  switch (json_of(node_).type()) {
    case Json::value_t::boolean:
      return JsonType::kBoolean;
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
      return JsonType::kInteger;
    case Json::value_t::number_float:
      return JsonType::kNumber;
    case Json::value_t::string:
      return JsonType::kText;
    case Json::value_t::array:
      return JsonType::kArray;
    case Json::value_t::object:
      return JsonType::kObject;
    default:
      return JsonType::kNull;
  }
}

bool Value::boolean() const {
  return json_of(node_).get<bool>();
}
double Value::number() const {
  return json_of(node_).get<double>();
}
int Value::integer() const {
  return json_of(node_).get<int>();
}
std::string_view Value::text() const {
  return json_of(node_).get_ref<const std::string&>();
}

std::size_t Value::size() const {
  return node_ && json_of(node_).is_structured() ? json_of(node_).size() : 0;
}

Value Value::at(std::size_t index) const {
  const bool present = type() == JsonType::kArray && index < size();
  return {present ? &json_of(node_)[index] : nullptr, fmt::format("{}/{}", pointer_, index)};
}

Value Value::operator[](std::string_view key) const {
  const void* node = nullptr;
  if (type() == JsonType::kObject)
    if (const auto found = json_of(node_).find(key); found != json_of(node_).end()) node = &*found;
  return {node, pointer_ + "/" + pointer_token(key)};
}

std::vector<std::pair<std::string, Value>> Value::members() const {
  std::vector<std::pair<std::string, Value>> members;
  if (type() != JsonType::kObject) return members;
  for (const auto& [key, value] : json_of(node_).items())
    members.emplace_back(key, Value(&value, pointer_ + "/" + pointer_token(key)));
  return members;
}

std::string Value::excerpt() const {
  switch (type()) {
    case JsonType::kAbsent:
      return "nothing";
    case JsonType::kArray:
      return fmt::format("an array of {} item{}", size(), size() == 1 ? "" : "s");
    case JsonType::kObject:
      return "an object";
    case JsonType::kText:
      return api::quoted(text());
    default:
      return json_of(node_).dump();
  }
}

bool operator==(const Value& a, const Value& b) {
  if (!a || !b) return !a && !b;
  return json_of(a.native()) == json_of(b.native());
}

std::string quoted(std::string_view text, std::size_t max_bytes) {
  const std::string_view kept = shortened(text, max_bytes);
  std::string shown(kept);
  if (kept.size() < text.size()) shown += "…";
  return Json(std::move(shown)).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string pointer_token(std::string_view key) {
  std::string token;
  for (const char c : key) {
    if (c == '~')
      token += "~0";
    else if (c == '/')
      token += "~1";
    else
      token += c;
  }
  return token;
}

}  // namespace furnace::api
