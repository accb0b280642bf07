// A render request as the flat keys of a URL: "width=640&model=file:chair.glb" -> the JSON document that says the same.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/error.hpp"
#include "api/document.hpp"

namespace furnace::api {

// How a key's text becomes a JSON value.
enum class QueryKind {
  kText,
  kNumber,   // as JSON writes it
  kNumbers,  // numbers with commas between: an array
  kFlag      // true or false
};

struct QueryKey {
  std::string_view name;
  std::string_view pointer;  // RFC 6901: its place in the document; "0" is the first item of an array
  QueryKind kind;
};

// The one table of flat keys, in the order in which OpenAPI tells them.
std::span<const QueryKey> query_keys();
const QueryKey* find_query_key(std::string_view name);

// What one pair of a query says, percent-decoded.
struct QueryPair {
  std::string name;
  std::string value;
};

// `document` with every pair laid over it at its key's place; what stood there is replaced, objects and the array on the way
// are made when they are missing. Errors: those of Document::parse; kUnprocessable with all problems: no such key, a
// value that is not of its key's kind, a place that cannot be reached. Their pointers are those of query_pointer.
std::string lay_over(std::string_view document, std::span<const QueryPair> pairs, const JsonLimits& limits);

// How problem documents point at a key of the query. No JSON pointer begins so.
std::string query_pointer(std::string_view name);

// Problems of the document that lay_over made, told where the client wrote the value: at a key of `pairs` when their
// pointer is its place or below.
void point_at_query(Error& error, std::span<const QueryPair> pairs);

}  // namespace furnace::api
