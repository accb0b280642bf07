#include "server/image_url.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "api/document.hpp"
#include "api/problem.hpp"
#include "server/request_body.hpp"
#include "server/routes.hpp"
#include "server/url_query.hpp"

namespace furnace {
namespace {

constexpr std::string_view kDocument = "r", kPreset = "preset", kDefaultName = "render";
constexpr std::array<std::string_view, 3> kSignatureKeys = {"kid", "exp", "sig"};

[[noreturn]] void refuse_key(ErrorCode code, std::string_view key, std::string message) {
  const std::string pointer = api::query_pointer(key);
  fail(code, fmt::format("{}: {}", pointer, message), pointer);
}

// A URL in which a key stands twice would mean what its reader's library makes of it.
void refuse_repetition(std::span<const api::QueryPair> pairs) {
  std::set<std::string_view> seen;
  for (const api::QueryPair& pair : pairs)
    if (!seen.insert(pair.name).second) refuse_key(ErrorCode::kInvalidRequest, pair.name, "is there twice");
}

const std::string* value_of(std::span<const api::QueryPair> pairs, std::string_view name) {
  const auto found = std::ranges::find(pairs, name, &api::QueryPair::name);
  return found == pairs.end() ? nullptr : &found->value;
}

const api::Preset& preset_of(const std::string& name, const Presets& presets) {
  if (const api::Preset* preset = presets.find(name)) return *preset;
  refuse_key(ErrorCode::kNotFound, kPreset, "there is no such preset; /v1/presets lists them");
}

void check_open(const api::Preset* preset, std::span<const api::QueryPair> flat) {
  if (preset == nullptr)
    refuse_key(ErrorCode::kUnprocessable, kPreset, "is needed: this server draws presets only");
  std::vector<Problem> problems;
  for (const api::QueryPair& pair : flat)
    if (std::ranges::find(preset->open, pair.name) == preset->open.end())
      problems.push_back(
          {api::query_pointer(pair.name), "is not open in this preset; /v1/presets lists what is"});
  api::fail_if_any(std::move(problems));
}

std::string decoded_document(const std::string& text, const api::JsonLimits& limits) {
  auto document = base64url_decoded(text);
  if (!document) refuse_key(ErrorCode::kInvalidRequest, kDocument, "is not base64url (RFC 4648 section 5)");
  api::Document::parse(*document, limits);
  return *std::move(document);
}

void replace(Reply& reply, std::string_view name, std::string value) {
  std::erase_if(reply.headers, [&](const auto& header) { return header.first == name; });
  if (!value.empty()) reply.with(std::string(name), std::move(value));
}

std::string_view ending_of(std::string_view media_type) {
  for (const api::FormatRow& row : api::kFormats)
    if (row.media_type == media_type) return row.name;
  return media_type == api::kZip ? "zip" : "png";
}

Reply get_image(const Doors& doors, const Request& request) {
  const api::RequestLimits& limits = doors.capabilities.request;
  const api::JsonLimits json{limits.max_json_depth, limits.max_json_bytes};
  const ImageDocument asked = document_of_query(request.query, *doors.presets, doors.image_urls, json);
  // A stated format is an answer to whoever asks, so that every cache on the way may keep it for all.
  const bool is_stated = bool(api::Document::parse(asked.text, json).root()["output"]["format"]);
  Request equal = request;
  equal.headers.erase("Prefer");  // a job is made by POST
  if (is_stated) equal.headers.erase("Accept");
  Reply reply;
  try {
    reply = answer_document(doors, equal, {asked.text, {}});
  } catch (Error& error) {
    api::point_at_query(error, asked.flat);
    throw;
  }
  replace(reply, "Cache-Control",
          fmt::format("public, max-age={0}, stale-while-revalidate={0}", doors.image_urls.max_age_s));
  if (is_stated) replace(reply, "Vary", {});
  if (reply.status == 200)
    reply.with("Content-Disposition",
               fmt::format("inline; filename=\"{}.{}\"", asked.name, ending_of(reply.media_type)));
  return reply.with("Cross-Origin-Resource-Policy", "cross-origin");
}

}  // namespace

ImageDocument document_of_query(std::string_view query, const Presets& presets, const ImageUrlConfig& config,
                                const api::JsonLimits& limits) {
  auto pairs = parse_query(query);
  if (!pairs)
    fail(ErrorCode::kInvalidRequest, "The query is malformed: % stands before two hexadecimal digits.");
  std::erase_if(*pairs, [](const api::QueryPair& pair) {
    return std::ranges::find(kSignatureKeys, pair.name) != kSignatureKeys.end();
  });
  refuse_repetition(*pairs);
  const std::string* document = value_of(*pairs, kDocument);
  const std::string* name = value_of(*pairs, kPreset);
  if (document != nullptr && name != nullptr)
    refuse_key(ErrorCode::kInvalidRequest, kDocument, "and preset exclude each other");
  const api::Preset* preset = name != nullptr ? &preset_of(*name, presets) : nullptr;
  ImageDocument out;
  out.name = name != nullptr ? *name : kDefaultName;
  std::string base = "{}";
  if (preset != nullptr) base = preset->document;
  if (document != nullptr && !config.presets_only) base = decoded_document(*document, limits);
  std::ranges::copy_if(*pairs, std::back_inserter(out.flat), [&](const api::QueryPair& pair) {
    return pair.name != kPreset && (pair.name != kDocument || config.presets_only);
  });
  if (config.presets_only) check_open(preset, out.flat);
  out.text = api::lay_over(base, out.flat, limits);
  return out;
}

std::vector<Route> image_url_routes(const Doors& doors) {
  return {
      {"GET", "/v1/render", [doors](const Request& request) { return get_image(doors, request); },
       scope::kImageUrl, true},
      {"GET", "/v1/presets",
       [doors](const Request&) {
         return Reply{200, "application/json", doors.presets->names_json(), {}}.with("Cache-Control",
                                                                                     "no-cache");
       },
       scope::kRender},
  };
}

}  // namespace furnace
