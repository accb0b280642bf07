#include "api/image_query.hpp"

#include "api/problem.hpp"
#include "api/validate.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

namespace furnace::api {
namespace {

using Json = nlohmann::json;
using enum QueryKind;

constexpr std::array kKeys = {
    QueryKey{"model", "/scene/model", kText},
    QueryKey{"mesh", "/scene/nodes/0/mesh", kText},
    QueryKey{"material", "/scene/nodes/0/material", kText},
    QueryKey{"variant", "/scene/variant", kText},
    QueryKey{"upAxis", "/scene/upAxis", kText},
    QueryKey{"shadingModel", "/scene/shadingModel", kText},
    QueryKey{"animation", "/scene/animation/name", kText},
    QueryKey{"time", "/scene/animation/timeSeconds", kNumber},
    QueryKey{"loop", "/scene/animation/loop", kFlag},

    QueryKey{"environment", "/environment/map", kText},
    QueryKey{"rotation", "/environment/rotationDegrees", kNumber},
    QueryKey{"intensity", "/environment/intensity", kNumber},
    QueryKey{"illuminance", "/environment/illuminanceLux", kNumber},
    QueryKey{"sun", "/environment/sun", kText},
    QueryKey{"layout", "/environment/layout", kText},
    QueryKey{"visibility", "/environment/visibility", kText},
    QueryKey{"background", "/environment/background/type", kText},
    QueryKey{"backgroundMap", "/environment/background/map", kText},
    QueryKey{"backgroundLayout", "/environment/background/layout", kText},
    QueryKey{"backgroundBlur", "/environment/background/blurDegrees", kNumber},
    QueryKey{"backgroundColor", "/environment/background/color", kNumbers},
    QueryKey{"backgroundTop", "/environment/background/top", kNumbers},
    QueryKey{"backgroundBottom", "/environment/background/bottom", kNumbers},
    QueryKey{"ground", "/environment/ground/shadow", kFlag},
    QueryKey{"shadowStrength", "/environment/ground/shadowStrength", kNumber},

    QueryKey{"azimuth", "/camera/orbit/azimuthDegrees", kNumber},
    QueryKey{"elevation", "/camera/orbit/elevationDegrees", kNumber},
    QueryKey{"fit", "/camera/orbit/fit", kNumber},
    QueryKey{"orthographic", "/camera/orbit/orthographic", kFlag},
    QueryKey{"eye", "/camera/lookAt/eye", kNumbers},
    QueryKey{"target", "/camera/lookAt/target", kNumbers},
    QueryKey{"camera", "/camera/gltf", kText},
    QueryKey{"fov", "/camera/fovYDegrees", kNumber},
    QueryKey{"exposure", "/camera/exposureEv", kNumber},
    QueryKey{"ev100", "/camera/ev100", kNumber},
    QueryKey{"autoExposure", "/camera/autoExposure", kFlag},
    QueryKey{"fStop", "/camera/depthOfField/fStop", kNumber},
    QueryKey{"motionBlur", "/camera/motionBlur/shutterSeconds", kNumber},

    QueryKey{"width", "/output/width", kNumber},
    QueryKey{"height", "/output/height", kNumber},
    QueryKey{"format", "/output/format", kText},
    QueryKey{"quality", "/output/quality", kText},
    QueryKey{"samples", "/output/samples", kNumber},
    QueryKey{"compressionQuality", "/output/compressionQuality", kNumber},
    QueryKey{"lossless", "/output/lossless", kFlag},
    QueryKey{"dither", "/output/dither", kFlag},
    QueryKey{"toneMap", "/output/toneMap", kText},
    QueryKey{"whiteBalance", "/output/whiteBalanceKelvin", kNumber},
    QueryKey{"contrast", "/output/contrast", kNumber},
    QueryKey{"saturation", "/output/saturation", kNumber},
    QueryKey{"bloom", "/output/bloom/intensity", kNumber},
    QueryKey{"show", "/output/show", kText},
    QueryKey{"turntable", "/output/sequence/turntableDegrees", kNumber},
    QueryKey{"frames", "/output/sequence/frames", kNumber},
    QueryKey{"fps", "/output/sequence/framesPerSecond", kNumber},

    QueryKey{"strict", "/strict", kFlag},
};

constexpr std::size_t kMaxNumbers = 4;  // of a kNumbers value: the longest array that a key leads to

// Exactly the numbers of RFC 8259, so that a URL takes what a document takes.
std::optional<Json> number_of(std::string_view text) {
  const std::string_view digits = text.starts_with('-') ? text.substr(1) : text;
  const bool plain = !digits.empty() && digits.front() >= '0' && digits.front() <= '9';
  if (!plain || text.find_first_not_of("0123456789+-.eE") != text.npos) return std::nullopt;
  Json value = Json::parse(text, nullptr, false);
  if (!value.is_number() || !std::isfinite(value.get<double>())) return std::nullopt;
  return value;
}

std::optional<Json> numbers_of(std::string_view text) {
  Json values = Json::array();
  while (values.size() < kMaxNumbers) {
    const std::size_t comma = std::min(text.find(','), text.size());
    auto value = number_of(text.substr(0, comma));
    if (!value) return std::nullopt;
    values.push_back(*std::move(value));
    if (comma == text.size()) return values;
    text.remove_prefix(comma + 1);
  }
  return std::nullopt;
}

// A JSON text can hold it: it is UTF-8, and no reader stops at a NUL.
bool is_text(const std::string& text) {
  try {
    Json(text).dump();
  } catch (const Json::exception&) {
    return false;
  }
  return text.find('\0') == text.npos;
}

std::optional<Json> value_of(const QueryKey& key, const std::string& text) {
  switch (key.kind) {
    case kNumber:
      return number_of(text);
    case kNumbers:
      return numbers_of(text);
    case kFlag:
      if (text == "true" || text == "false") return Json(text == "true");
      return std::nullopt;
    case kText:
      break;
  }
  if (!is_text(text)) return std::nullopt;
  return Json(text);
}

std::string_view form_of(QueryKind kind) {
  switch (kind) {
    case kNumber:
      return "a number";
    case kNumbers:
      return "numbers with commas between";
    case kFlag:
      return "true or false";
    case kText:
      break;
  }
  return "UTF-8 text";
}

// The place that `pointer` names, made when it is missing; null when something else stands in the way.
Json* place_in(Json& root, std::string_view pointer) {
  Json* place = &root;
  while (!pointer.empty()) {
    const std::size_t end = std::min(pointer.find('/', 1), pointer.size());
    const std::string token(pointer.substr(1, end - 1));
    pointer.remove_prefix(end);
    if (token == "0") {
      if (place->is_null()) *place = Json::array();
      if (!place->is_array()) return nullptr;
      if (place->empty()) place->push_back(nullptr);
      place = &place->front();
    } else {
      if (place->is_null()) *place = Json::object();
      if (!place->is_object()) return nullptr;
      place = &(*place)[token];
    }
  }
  return place;
}

std::string strange_key(std::string_view name) {
  std::vector<std::string> known;
  for (const QueryKey& key : kKeys) known.emplace_back(key.name);
  return "there is no such key" + did_you_mean(name, known);
}

}  // namespace

std::span<const QueryKey> query_keys() {
  return kKeys;
}

const QueryKey* find_query_key(std::string_view name) {
  const auto* found =
      std::find_if(kKeys.begin(), kKeys.end(), [&](const QueryKey& key) { return key.name == name; });
  return found == kKeys.end() ? nullptr : found;
}

std::string query_pointer(std::string_view name) {
  return fmt::format("?{}", name);
}

std::string lay_over(std::string_view document, std::span<const QueryPair> pairs, const JsonLimits& limits) {
  Json root = *static_cast<const Json*>(Document::parse(document, limits).root().native());
  std::vector<Problem> problems;
  for (const QueryPair& pair : pairs) {
    if (problems.size() >= kMaxProblems) break;
    const auto refuse = [&](std::string message) {
      problems.push_back({query_pointer(pair.name), std::move(message)});
    };
    const QueryKey* key = find_query_key(pair.name);
    if (key == nullptr) {
      refuse(strange_key(pair.name));
    } else if (auto value = value_of(*key, pair.value); !value) {
      refuse(fmt::format("must be {}, got {}", form_of(key->kind), api::quoted(pair.value)));
    } else if (Json* place = place_in(root, key->pointer)) {
      *place = *std::move(value);
    } else {
      refuse(
          fmt::format("belongs at {}, where the document below has something else in its way", key->pointer));
    }
  }
  fail_if_any(std::move(problems));
  return root.dump();
}

void point_at_query(Error& error, std::span<const QueryPair> pairs) {
  const auto told_at = [&](const std::string& pointer) {
    for (const QueryPair& pair : pairs) {
      const QueryKey* key = find_query_key(pair.name);
      if (key == nullptr || !pointer.starts_with(key->pointer)) continue;
      if (pointer.size() == key->pointer.size() || pointer[key->pointer.size()] == '/')
        return query_pointer(pair.name);
    }
    return pointer;
  };
  error.pointer = told_at(error.pointer);
  if (error.problems.empty()) return;
  for (Problem& problem : error.problems) problem.pointer = told_at(problem.pointer);
  // The message names the first place; it is told anew.
  try {
    fail_if_any(error.problems, error.code);
  } catch (const Error& told) {
    error.message = told.message;
  }
}

}  // namespace furnace::api
