// Strict, typed reading of JSON: every accessor checks type and range and fails with the value's JSON
// pointer. Only gltf_*.cpp include this: it is where nlohmann/json enters the scene floor.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "renderer/base/error.hpp"

namespace furnace {

using Json = nlohmann::json;

// Depth and number of values are bounded before anything is built, so that a small file cannot take much
// memory. Errors: kUnprocessable for what is not JSON, kTooLarge for the bounds.
Json parse_json(std::string_view text);

// RFC 6901; a long key is cut off.
std::string pointer_below(std::string_view pointer, std::string_view key);

// Threads: one. Owns: its pointer; the value must outlive it.
class JsonObject {
 public:
  JsonObject(const Json& value, std::string pointer);

  const std::string& pointer() const { return pointer_; }
  std::string pointer_to(std::string_view key) const;
  const Json* find(std::string_view key) const;
  bool has(std::string_view key) const { return find(key) != nullptr; }
  [[noreturn]] void refuse(std::string_view key, const std::string& message) const;

  std::optional<JsonObject> object(std::string_view key) const;
  JsonObject required_object(std::string_view key) const;
  std::optional<JsonObject> extension(std::string_view name) const;

  std::string string(std::string_view key, std::string_view fallback = {}) const;
  std::string required_string(std::string_view key) const;
  std::vector<std::string> strings(std::string_view key) const;
  bool boolean(std::string_view key, bool fallback) const;

  double number(std::string_view key, double fallback) const;
  double required_number(std::string_view key) const;
  std::vector<double> numbers(std::string_view key) const;
  template <std::size_t N>
  std::optional<std::array<double, N>> vector(std::string_view key) const;

  // Whole numbers in [0, 2^53], whether written 1 or 1.0.
  std::uint64_t integer(std::string_view key, std::uint64_t fallback) const;
  std::uint64_t required_integer(std::string_view key) const;

  // An index into an array of `count` things called `what` ("accessor").
  std::optional<int> reference(std::string_view key, std::string_view what, int count) const;
  int required_reference(std::string_view key, std::string_view what, int count) const;
  std::vector<int> references(std::string_view key, std::string_view what, int count) const;

  std::vector<std::string> keys() const;
  // Length of an array member; 0 when absent.
  int size_of(std::string_view key) const;
  // read(JsonObject) for each element of an array of objects.
  template <class Read>
  void each(std::string_view key, Read&& read) const {
    const Json* list = array(key);
    if (!list) return;
    const std::string base = pointer_to(key) + "/";
    for (std::size_t i = 0; i < list->size(); ++i) read(JsonObject((*list)[i], base + std::to_string(i)));
  }

 private:
  const Json* array(std::string_view key) const;
  const Json& required(std::string_view key) const;

  const Json* value_;
  std::string pointer_;
};

template <std::size_t N>
std::optional<std::array<double, N>> JsonObject::vector(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  const std::vector<double> list = numbers(key);
  if (list.size() != N) {
    refuse(key, "must have " + std::to_string(N) + " numbers, has " + std::to_string(list.size()));
  }
  std::array<double, N> result{};
  std::copy(list.begin(), list.end(), result.begin());
  return result;
}

}  // namespace furnace
