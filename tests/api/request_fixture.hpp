// What the api tests share: a resolver with two files, requests as text, and one row for every field of the
// schema.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/render_request.hpp"
#include "api/validate.hpp"

namespace furnace::api {

// Parses with the parts "model.gltf" (an empty glTF document), "sky.hdr", "a.png" and "b.png".
RenderSpec parse(std::string_view json, const RequestLimits& limits = {});
ContentHash hash_of(std::string_view json);
// The error of a request that must be refused; a test failure and an empty Error when it is accepted.
Error refusal(std::string_view json, const RequestLimits& limits = {});

const Schema& request_schema();
RequestLimits generous_limits();  // beyond every range of the schema

std::string json_text(const Value& value);
std::string read_text(const std::filesystem::path& path);

// One property of the schema: its path (array items and map values add nothing), a document with `@` for its
// value, and two values that describe two pictures.
struct FieldRow {
  std::string_view path;
  std::string_view document;
  std::string_view one;
  std::string_view other;
};
std::span<const FieldRow> field_rows();

std::string with_value(const FieldRow& row, std::string_view value);
std::string without_field(const FieldRow& row);

// A property that no other property lies below, with its schema ($ref followed, siblings kept in `declared`).
struct Leaf {
  std::string path;
  Value declared;
  Value resolved;
};
std::vector<Leaf> schema_leaves();

}  // namespace furnace::api
