// JSON text -> values, strictly: RFC 8259 and nothing more, bounded, and every value knows its JSON pointer.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace furnace::api {

struct JsonLimits {
  int max_depth = 64;  // nested arrays and objects
  std::int64_t max_bytes = 4ll << 20;
  int max_key_bytes = 1024;  // keys come back in pointers and messages
};

enum class JsonType { kAbsent, kNull, kBoolean, kInteger, kNumber, kText, kArray, kObject };

// One place of a Document, present or not. The typed getters are for values whose type is known (validated).
// Threads: any, while the Document lives. Owns: its pointer text.
class Value {
 public:
  explicit operator bool() const { return node_ != nullptr; }
  JsonType type() const;  // kInteger also for 3.0: JSON has one kind of number
  const std::string& pointer() const { return pointer_; }  // RFC 6901

  bool boolean() const;
  double number() const;
  int integer() const;
  std::string_view text() const;
  std::size_t size() const;  // of an array or object, else 0
  // An absent place knows its pointer, too, so reading goes on below it.
  Value at(std::size_t index) const;
  Value operator[](std::string_view key) const;
  std::vector<std::pair<std::string, Value>> members() const;  // of an object, sorted by key

  // For messages: the JSON text of a scalar, shortened, or "an array of 3 items", "an object".
  std::string excerpt() const;

  const void* native() const { return node_; }  // nlohmann::json, for api/*.cpp

 private:
  friend class Document;
  Value(const void* node, std::string pointer) : node_(node), pointer_(std::move(pointer)) {}

  const void* node_ = nullptr;
  std::string pointer_;
};

bool operator==(const Value& a, const Value& b);  // equal JSON, wherever they stand

// Threads: immutable. Owns: its values.
class Document {
 public:
  // Errors: kTooLarge for bytes; kInvalidRequest with a pointer for broken syntax or UTF-8, duplicate keys,
  // numbers beyond double, U+0000 in texts, too deep.
  static Document parse(std::string_view text, const JsonLimits& limits);

  Value root() const;

 private:
  struct State;
  explicit Document(std::shared_ptr<const State> state);
  std::shared_ptr<const State> state_;
};

// `text` as a JSON string, shortened to `max_bytes` at a character's end: how messages quote what a client
// wrote.
std::string quoted(std::string_view text, std::size_t max_bytes = 60);

// `key` as a reference token of a JSON pointer: "~" -> "~0", "/" -> "~1".
std::string pointer_token(std::string_view key);

}  // namespace furnace::api
