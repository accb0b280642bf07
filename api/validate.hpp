// A document against a schema: valijson judges, explain() says what is wrong in words a client can act on.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "api/document.hpp"
#include "renderer/base/error.hpp"

namespace furnace::api {

// Threads: immutable. Owns: the parsed schema.
class Schema {
 public:
  explicit Schema(std::string_view text);  // kInternal when the text is not a schema: it is our own

  const Document& document() const;
  // Empty exactly when the document is valid.
  std::vector<Problem> problems(const Document& document) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

// The violations of the schema by `value`, at most kMaxProblems, members sorted by key. Reads the keywords our schemas
// use: $ref into the same schema, type, enum, minimum, maximum, minLength, maxLength, minItems, maxItems,
// items, properties, required, maxProperties, additionalProperties, anyOf (the alternative of the value's
// type, for objects also of its member "type", is explained) and not (its description is the message).
std::vector<Problem> explain(const Value& schema_root, const Value& value);

// The nearest of `known` when it is near enough to be a slip of the pen, as `; did you mean "width"?`, else
// "".
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

}  // namespace furnace::api
