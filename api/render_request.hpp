// JSON text -> RenderSpec, strictly: the schema is checked first, then all problems are told at once.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/scene/render_spec.hpp"

namespace furnace::api {

struct RequestLimits {
  int max_side_px = 4096;
  std::int64_t max_area_px = 16ll << 20;
  int max_samples = 64;
  std::int64_t max_layer_bytes = 512ll << 20;  // of all film layers of a picture
  int max_frames = 360;                        // of a sequence
  std::int64_t max_sequence_px = 128ll << 20;  // of all its frames together
  int max_json_depth = 64;
  std::int64_t max_json_bytes = 4ll << 20;  // of the request document itself
};

// "quality" is a number of samples by name. The first table to change when a level should look better or draw
// faster; the schema's description and the capabilities tell the same numbers.
struct QualityLevel {
  std::string_view name;
  int samples;
};
inline constexpr std::array kQualityLevels = {QualityLevel{"draft", 1}, QualityLevel{"standard", 1},
                                              QualityLevel{"high", 16}, QualityLevel{"reference", 64}};
inline constexpr std::string_view kDefaultQuality = "standard";

int samples_for_quality(std::string_view quality);  // one of kQualityLevels

struct FormatRow {
  std::string_view name;  // in "output"."format"
  OutputFormat format;
  std::string_view media_type;
};
inline constexpr std::array kFormats = {FormatRow{"png", OutputFormat::kPng, "image/png"},
                                        FormatRow{"exr", OutputFormat::kExr, "image/x-exr"},
                                        FormatRow{"jpeg", OutputFormat::kJpeg, "image/jpeg"},
                                        FormatRow{"webp", OutputFormat::kWebp, "image/webp"},
                                        FormatRow{"webm", OutputFormat::kWebm, "video/webm"}};
std::string_view name_of(OutputFormat format);
std::string_view media_type_of(OutputFormat format);
// Of the file that is asked for: of a sequence that of its container.
std::string_view media_type_of(const OutputSpec& output);

inline constexpr std::string_view kAnimatedPng = "image/apng", kZip = "application/zip";

// What {} draws, and what a "builtin:" model wears.
inline constexpr std::string_view kDefaultMesh = "shader-ball";
inline constexpr std::string_view kDefaultPreset = "gold";

// Errors: kInvalidRequest (not JSON, duplicate keys, too deep), kUnprocessable with `problems` (unknown keys,
// types, ranges, names), kTooLarge (limits), and what the resolver says. Every problem has its JSON pointer.
// `unstated_format` is the format when the document names none: what the client's Accept header prefers.
RenderSpec parse_render_request(std::string_view json, const AssetResolver& assets,
                                const RequestLimits& limits,
                                OutputFormat unstated_format = OutputFormat::kPng);

}  // namespace furnace::api
