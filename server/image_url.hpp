// GET /v1/render: the whole request in a URL, for <img>.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "api/image_query.hpp"
#include "server/dispatcher.hpp"
#include "server/presets.hpp"

namespace furnace {

struct Doors;

struct ImageUrlConfig {
  std::int64_t max_age_s = 3600;  // how long a browser or a proxy may show an answer without asking again
  bool presets_only = false;      // else any document
};

// What a URL asks for, as a document of POST /v1/renders.
struct ImageDocument {
  std::string text;
  std::vector<api::QueryPair> flat;  // what was laid over it
  std::string name;                  // for a file: the preset's, else "render"
};

// `query` is as sent, without "?".
// Keys: "r" is a document in base64url, "preset" one of `presets`; every other is one of api::query_keys, laid over them.
// "kid", "exp" and "sig" are passed over: they were looked at before. Errors: kInvalidRequest, kUnprocessable and
// kNotFound (a preset), which point at keys of the query.
ImageDocument document_of_query(std::string_view query, const Presets& presets, const ImageUrlConfig& config,
                                const api::JsonLimits& limits);

// GET /v1/render and GET /v1/presets.
std::vector<Route> image_url_routes(const Doors& doors);

}  // namespace furnace
