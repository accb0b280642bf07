#include "api/validate.hpp"

#include "api/problem.hpp"
#include "renderer/base/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <numeric>

namespace furnace::api {
namespace {

struct TypeWord {
  std::string_view name;  // in a schema
  std::string_view words;
  JsonType type;
};
constexpr TypeWord kTypeWords[] = {
    {"object", "an object", JsonType::kObject}, {"array", "an array", JsonType::kArray},
    {"string", "a string", JsonType::kText},    {"integer", "a whole number", JsonType::kInteger},
    {"number", "a number", JsonType::kNumber},  {"boolean", "true or false", JsonType::kBoolean},
    {"null", "null", JsonType::kNull},
};

const TypeWord& type_word(std::string_view name) {
  const auto* found = std::find_if(std::begin(kTypeWords), std::end(kTypeWords),
                                   [&](const TypeWord& word) { return word.name == name; });
  FURNACE_CHECK(found != std::end(kTypeWords), "type {}", name);
  return *found;
}

bool has_type(const Value& value, std::string_view name) {
  const JsonType wanted = type_word(name).type;
  return value.type() == wanted || (wanted == JsonType::kNumber && value.type() == JsonType::kInteger);
}

std::string lower_case(std::string_view word) {
  std::string lower(word);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

// Damerau, "A technique for computer detection and correction of spelling errors", 1964: insertions,
// deletions, substitutions and exchanges of neighbours.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last, last(b.size() + 1), current(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      current[j] = std::min({last[j] + 1, current[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        current[j] = std::min(current[j], before_last[j - 2] + 1);
    }
    before_last = last;
    std::swap(last, current);
  }
  return last[b.size()];
}

std::vector<std::string> keys_of(const Value& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.members()) keys.push_back(key);
  return keys;
}

std::string quantity(double count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

class Explainer {
 public:
  explicit Explainer(const Value& root) : root_(root) {}

  std::vector<Problem> take() { return std::move(problems_); }

  void check(const Value& schema, const Value& value) {
    if (full()) return;
    if (const Value reference = schema["$ref"]) check(resolve(reference), value);
    if (const Value type = schema["type"]; type && !has_type(value, type.text()))
      return add(value, fmt::format("must be {}, got {}", type_word(type.text()).words, value.excerpt()));
    if (const Value choices = schema["enum"]) check_enum(choices, value);
    if (const Value alternatives = schema["anyOf"]) check_any_of(alternatives, value);
    switch (value.type()) {
      case JsonType::kInteger:
      case JsonType::kNumber:
        check_range(schema, value);
        break;
      case JsonType::kText:
        check_text(schema, value);
        break;
      case JsonType::kArray:
        check_array(schema, value);
        break;
      case JsonType::kObject:
        check_object(schema, value);
        break;
      default:
        break;
    }
  }

 private:
  bool full() const { return problems_.size() >= kMaxProblems; }

  void add(const Value& value, std::string message) {
    if (!full()) problems_.push_back({value.pointer(), std::move(message)});
  }

  Value resolve(const Value& reference) const {
    std::string_view path = reference.text();
    FURNACE_CHECK(path.starts_with("#/"), "reference {}", path);
    path.remove_prefix(2);
    Value schema = root_;
    while (!path.empty()) {
      const std::size_t end = std::min(path.find('/'), path.size());
      schema = schema[path.substr(0, end)];
      path.remove_prefix(std::min(end + 1, path.size()));
    }
    FURNACE_CHECK(static_cast<bool>(schema), "reference {}", reference.text());
    return schema;
  }

  Value resolved(const Value& schema) const {
    const Value reference = schema["$ref"];
    return reference ? resolved(resolve(reference)) : schema;
  }

  std::vector<Problem> problems_of(const Value& schema, const Value& value) const {
    Explainer other(root_);
    other.check(schema, value);
    return other.take();
  }

  void check_enum(const Value& choices, const Value& value) {
    std::vector<std::string> names, quoted_names;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      if (choices.at(i) == value) return;
      if (choices.at(i).type() == JsonType::kText) names.emplace_back(choices.at(i).text());
      quoted_names.push_back(choices.at(i).excerpt());
    }
    const std::string hint = value.type() == JsonType::kText ? did_you_mean(value.text(), names) : "";
    constexpr std::size_t kMaxListed = 12;
    if (names.size() > kMaxListed)
      add(value, fmt::format("{} is none of the {} known names{}", value.excerpt(), names.size(), hint));
    else
      add(value,
          fmt::format("must be one of {}; got {}{}", fmt::join(quoted_names, ", "), value.excerpt(), hint));
  }

  // Our alternatives differ by type, so the one of the value's type is the one that was meant; objects differ by
  // the one name that their member "type" may have.
  void check_any_of(const Value& alternatives, const Value& value) {
    std::vector<std::string_view> words;
    std::vector<Value> fitting;
    for (std::size_t i = 0; i < alternatives.size(); ++i) {
      const Value alternative = resolved(alternatives.at(i));
      const std::string_view type = alternative["type"].text();
      if (has_type(value, type)) fitting.push_back(alternative);
      const std::string_view word = type_word(type).words;
      if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
    }
    if (fitting.empty())
      add(value, fmt::format("must be {}, got {}", fmt::join(words, " or "), value.excerpt()));
    else if (fitting.size() == 1)
      check(fitting[0], value);
    else
      check_kind(fitting, value);
  }

  // Without a type the first kind is meant.
  void check_kind(const std::vector<Value>& kinds, const Value& value) {
    const Value type = value["type"];
    if (!type) return check(kinds[0], value);
    std::vector<std::string> names, quoted_names;
    for (const Value& kind : kinds) {
      const Value name = kind["properties"]["type"]["enum"].at(0);
      if (name == type) return check(kind, value);
      names.emplace_back(name.text());
      quoted_names.push_back(name.excerpt());
    }
    add(type, fmt::format("must be one of {}; got {}{}", fmt::join(quoted_names, ", "), type.excerpt(),
                          type.type() == JsonType::kText ? did_you_mean(type.text(), names) : ""));
  }

  void check_range(const Value& schema, const Value& value) {
    const Value minimum = schema["minimum"], maximum = schema["maximum"];
    const bool below = minimum && value.number() < minimum.number();
    const bool above = maximum && value.number() > maximum.number();
    if (!below && !above) return;
    if (minimum && maximum)
      add(value, fmt::format("must be between {} and {}, got {}", minimum.excerpt(), maximum.excerpt(),
                             value.excerpt()));
    else
      add(value, fmt::format("must be at {} {}, got {}", below ? "least" : "most",
                             (below ? minimum : maximum).excerpt(), value.excerpt()));
  }

  void check_text(const Value& schema, const Value& value) {
    const auto is_first_byte = [](unsigned char c) { return (c & 0xC0) != 0x80; };
    const std::string_view text = value.text();
    check_count(schema, value, "minLength", "maxLength", "character",
                static_cast<double>(std::count_if(text.begin(), text.end(), is_first_byte)));
  }

  bool check_count(const Value& schema, const Value& value, std::string_view least_key,
                   std::string_view most_key, std::string_view noun, double count) {
    const Value least = schema[least_key], most = schema[most_key];
    if ((!least || count >= least.number()) && (!most || count <= most.number())) return true;
    std::string wanted;
    if (least && most && least.number() == most.number())
      wanted = quantity(least.number(), noun);
    else if (least && most)
      wanted = fmt::format("{} to {}", least.number(), quantity(most.number(), noun));
    else
      wanted =
          least ? "at least " + quantity(least.number(), noun) : "at most " + quantity(most.number(), noun);
    add(value, fmt::format("must have {}, got {}", wanted, count));
    return false;
  }

  void check_array(const Value& schema, const Value& value) {
    if (!check_count(schema, value, "minItems", "maxItems", "item", static_cast<double>(value.size())))
      return;
    if (const Value items = schema["items"])
      for (std::size_t i = 0; i < value.size() && !full(); ++i) check(items, value.at(i));
    if (schema["uniqueItems"]) check_unique(value);
  }

  void check_unique(const Value& value) {
    for (std::size_t i = 1; i < value.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (value.at(i) == value.at(j)) {
          add(value.at(i), fmt::format("{} stands here twice", value.at(i).excerpt()));
          break;
        }
  }

  void check_object(const Value& schema, const Value& value) {
    if (!check_count(schema, value, "minProperties", "maxProperties", "member",
                     static_cast<double>(value.size())))
      return;
    check_members(schema, value);
    check_required(schema, value);
    const Value excluded = schema["not"];
    if (const Value rules = excluded["anyOf"])
      for (std::size_t i = 0; i < rules.size(); ++i) check_exclusion(rules.at(i), value);
    if (excluded["required"]) check_exclusion(excluded, value);
  }

  void check_members(const Value& schema, const Value& value) {
    const Value properties = schema["properties"], additional = schema["additionalProperties"];
    for (const auto& [key, member] : value.members()) {
      if (full()) return;
      if (const Value property = properties[key]) {
        check(property, member);
      } else if (additional.type() == JsonType::kObject) {
        check(additional, member);
      } else if (additional.type() == JsonType::kBoolean && !additional.boolean()) {
        const std::vector<std::string> allowed = keys_of(properties);
        add(member, fmt::format("unknown key{} (allowed here: {})", did_you_mean(key, allowed),
                                fmt::join(allowed, ", ")));
      }
    }
  }

  void check_required(const Value& schema, const Value& value) {
    const Value required = schema["required"];
    for (std::size_t i = 0; i < required.size(); ++i)
      if (!value[required.at(i).text()])
        add(value, fmt::format("needs the key {}", required.at(i).excerpt()));
  }

  // One rule of "not": members that exclude each other; the last one named is the one to blame.
  void check_exclusion(const Value& rule, const Value& value) {
    if (!problems_of(rule, value).empty()) return;
    const Value required = rule["required"];
    add(value[required.at(required.size() - 1).text()], std::string(rule["description"].text()));
  }

  Value root_;
  std::vector<Problem> problems_;
};

}  // namespace

std::vector<Problem> explain(const Value& schema_root, const Value& value) {
  Explainer explainer(schema_root);
  explainer.check(schema_root, value);
  return explainer.take();
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t kMaxWord = 40;  // the distance costs the product of the lengths
  if (word.size() > kMaxWord) return "";
  const std::string wanted = lower_case(word);
  std::size_t best = std::max<std::size_t>(1, word.size() / 3) + 1;
  std::string_view nearest;
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(wanted, lower_case(candidate));
    if (distance < best) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest.empty() ? "" : fmt::format("; did you mean {}?", api::quoted(nearest));
}

}  // namespace furnace::api
