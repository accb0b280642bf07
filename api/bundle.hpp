// A request with all that it refers to: what a repro bundle holds.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "api/render_request.hpp"
#include "renderer/assets/asset_resolver.hpp"

namespace furnace::api {

struct SelfContained {
  std::string document;               // refers to nothing but parts, built-ins and data: URIs
  std::map<std::string, Blob> parts;  // by the names that it gives them
};

// `document` is one that was parsed to `output` with `reads` for its references. The file's format, which Accept may have
// chosen, is stated.
SelfContained self_contained(std::string_view document, const std::vector<ReadReference>& reads,
                             const OutputSpec& output);

// bundle.json: what drew the picture, so that a replay can tell whether its own is the same.
struct BundleAbout {
  std::string fingerprint;
  bool is_exact = false;  // gl::Determinism::kExact
  std::string etag;
  std::string picture;  // the file's name in the bundle
  std::string sha256;   // of the picture, hexadecimal
};
std::string bundle_json(const BundleAbout& about);
// Errors: kUnprocessable for what bundle_json does not write.
BundleAbout parse_bundle_json(std::string_view json);

}  // namespace furnace::api
