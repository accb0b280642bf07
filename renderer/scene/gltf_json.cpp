#include "renderer/scene/gltf_json.hpp"

#include "renderer/scene/gltf_container.hpp"

#include <cmath>
#include <utility>

namespace furnace {

namespace {

// Deeper than any glTF by far; keeps `extras` from filling the heap with one chain.
constexpr int kMaxDepth = 96;
// A value costs up to about 100 bytes once parsed; a scene of 100 000 nodes has under two million.
constexpr std::int64_t kMaxValues = 4'000'000;
constexpr double kMaxInteger = 9007199254740992.0;  // 2^53: exact in every JSON implementation

// A quick look at the brackets and commas: the parser stops at the first syntax error, up to which this sees
// the same text.
void check_shape(std::string_view text) {
  int depth = 0;
  std::int64_t values = 1;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '[' || c == '{') {
      ++depth;
      ++values;
    }
    if (c == ']' || c == '}') --depth;
    if (c == ',') ++values;
    if (depth > kMaxDepth) fail(ErrorCode::kTooLarge, "the JSON is nested too deeply");
    if (values > kMaxValues) fail(ErrorCode::kTooLarge, "the JSON has too many values");
  }
}

std::string type_of(const Json& value) {
  return std::string("is ") + value.type_name();
}

[[noreturn]] void refuse_at(std::string pointer, std::string message) {
  fail(ErrorCode::kUnprocessable, std::move(message), std::move(pointer));
}

double number_of(const Json& value, const std::string& pointer) {
  if (!value.is_number()) refuse_at(pointer, "must be a number, " + type_of(value));
  const double number = value.get<double>();
  if (!std::isfinite(number)) refuse_at(pointer, "must be finite");
  return number;
}

std::uint64_t integer_of(const Json& value, const std::string& pointer) {
  const double number = number_of(value, pointer);
  if (number < 0 || number > kMaxInteger || number != std::floor(number)) {
    refuse_at(pointer, "must be a whole number >= 0");
  }
  return static_cast<std::uint64_t>(number);
}

int reference_of(const Json& value, const std::string& pointer, std::string_view what, int count) {
  const std::uint64_t index = integer_of(value, pointer);
  if (index >= static_cast<std::uint64_t>(count)) {
    refuse_at(pointer, std::string(what) + " " + std::to_string(index) + " does not exist, there are " +
                           std::to_string(count));
  }
  return static_cast<int>(index);
}

std::string escaped(std::string_view key) {
  std::string result;
  for (const char c : shortened(key)) {
    if (c == '~') {
      result += "~0";
    } else if (c == '/') {
      result += "~1";
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace

Json parse_json(std::string_view text) {
  check_shape(text);
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::parse_error& error) {
    fail(ErrorCode::kUnprocessable, "not JSON: error at byte " + std::to_string(error.byte), "",
         error.what());
  } catch (const Json::exception& error) {
    fail(ErrorCode::kUnprocessable, "not JSON: a number is out of range", "", error.what());
  }
}

JsonObject::JsonObject(const Json& value, std::string pointer)
    : value_(&value), pointer_(std::move(pointer)) {
  if (!value.is_object()) refuse_at(pointer_, "must be an object, " + type_of(value));
}

std::string pointer_below(std::string_view pointer, std::string_view key) {
  return std::string(pointer) + "/" + escaped(key);
}

std::string JsonObject::pointer_to(std::string_view key) const {
  return pointer_below(pointer_, key);
}

const Json* JsonObject::find(std::string_view key) const {
  const auto found = value_->find(key);
  return found == value_->end() ? nullptr : &*found;
}

void JsonObject::refuse(std::string_view key, const std::string& message) const {
  refuse_at(pointer_to(key), message);
}

const Json& JsonObject::required(std::string_view key) const {
  const Json* value = find(key);
  if (!value) refuse(key, "is required");
  return *value;
}

const Json* JsonObject::array(std::string_view key) const {
  const Json* value = find(key);
  if (value && !value->is_array()) refuse(key, "must be an array, " + type_of(*value));
  return value;
}

std::optional<JsonObject> JsonObject::object(std::string_view key) const {
  const Json* value = find(key);
  if (!value) return std::nullopt;
  return JsonObject(*value, pointer_to(key));
}

JsonObject JsonObject::required_object(std::string_view key) const {
  return JsonObject(required(key), pointer_to(key));
}

std::optional<JsonObject> JsonObject::extension(std::string_view name) const {
  const auto extensions = object("extensions");
  return extensions ? extensions->object(name) : std::nullopt;
}

std::string JsonObject::string(std::string_view key, std::string_view fallback) const {
  return has(key) ? required_string(key) : std::string(fallback);
}

std::string JsonObject::required_string(std::string_view key) const {
  const Json& value = required(key);
  if (!value.is_string()) refuse(key, "must be a string, " + type_of(value));
  return value.get<std::string>();
}

std::vector<std::string> JsonObject::strings(std::string_view key) const {
  std::vector<std::string> result;
  const Json* list = array(key);
  if (!list) return result;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Json& value = (*list)[i];
    if (!value.is_string()) {
      refuse_at(pointer_to(key) + "/" + std::to_string(i), "must be a string, " + type_of(value));
    }
    result.push_back(value.get<std::string>());
  }
  return result;
}

bool JsonObject::boolean(std::string_view key, bool fallback) const {
  const Json* value = find(key);
  if (!value) return fallback;
  if (!value->is_boolean()) refuse(key, "must be true or false, " + type_of(*value));
  return value->get<bool>();
}

double JsonObject::number(std::string_view key, double fallback) const {
  return has(key) ? required_number(key) : fallback;
}

double JsonObject::required_number(std::string_view key) const {
  return number_of(required(key), pointer_to(key));
}

std::vector<double> JsonObject::numbers(std::string_view key) const {
  std::vector<double> result;
  const Json* list = array(key);
  if (!list) return result;
  result.reserve(list->size());
  const std::string base = pointer_to(key) + "/";
  for (std::size_t i = 0; i < list->size(); ++i) {
    result.push_back(number_of((*list)[i], base + std::to_string(i)));
  }
  return result;
}

std::uint64_t JsonObject::integer(std::string_view key, std::uint64_t fallback) const {
  return has(key) ? required_integer(key) : fallback;
}

std::uint64_t JsonObject::required_integer(std::string_view key) const {
  return integer_of(required(key), pointer_to(key));
}

std::optional<int> JsonObject::reference(std::string_view key, std::string_view what, int count) const {
  if (!has(key)) return std::nullopt;
  return required_reference(key, what, count);
}

int JsonObject::required_reference(std::string_view key, std::string_view what, int count) const {
  return reference_of(required(key), pointer_to(key), what, count);
}

std::vector<int> JsonObject::references(std::string_view key, std::string_view what, int count) const {
  std::vector<int> result;
  const Json* list = array(key);
  if (!list) return result;
  result.reserve(list->size());
  const std::string base = pointer_to(key) + "/";
  for (std::size_t i = 0; i < list->size(); ++i) {
    result.push_back(reference_of((*list)[i], base + std::to_string(i), what, count));
  }
  return result;
}

std::vector<std::string> JsonObject::keys() const {
  std::vector<std::string> result;
  for (auto member = value_->begin(); member != value_->end(); ++member) result.push_back(member.key());
  return result;
}

int JsonObject::size_of(std::string_view key) const {
  const Json* list = array(key);
  return list ? static_cast<int>(list->size()) : 0;
}

}  // namespace furnace
