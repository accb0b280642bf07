// One bake as the bytes of one OpenEXR file: the parts "sky", "atlas" and, where suns were taken out, "map" as half floats,
// every number and note as a text of the header, a checksum over all of it. Likewise a background of its own, the part
// "background".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/residency/prepared_scene.hpp"

namespace furnace {

inline constexpr int kBakeFileLayout = 4;  // raised when a text is added or changes its meaning
// A sky of 16384x8192 is one GiB of half floats.
inline constexpr std::int64_t kLargestBakeFileBytes = 1LL << 30;

struct StoredBake {
  PreparedEnvironment environment;  // its `key` is the one it is stored under
  std::vector<Note> notes;          // of the decoding that came before the bake
};

// Errors: kInternal. Threads: any.
std::string encode_bake(const ContentHash& key, const StoredBake& bake);

// Errors: kUnprocessable, kUnsupportedMedia, kTooLarge for anything but the whole bake of `key` in this layout and of this
// kBakeVersion. Threads: any.
StoredBake decode_bake(const ContentHash& key, std::string_view file);

// An environment that is looked at only, blurred or not.
struct StoredBackground {
  PreparedSky sky;          // its `key` is the one it is stored under
  std::vector<Note> notes;  // of the decoding
};

// Errors and threads: the same.
std::string encode_background(const ContentHash& key, const StoredBackground& background);
StoredBackground decode_background(const ContentHash& key, std::string_view file);

}  // namespace furnace
