#include "renderer/frame/cryptomatte.hpp"

#include <algorithm>
#include <bit>
#include <set>

#include <fmt/format.h>

#include "renderer/base/check.hpp"

namespace furnace {
namespace {

// A JSON string; bytes beyond ASCII stand as they are.
std::string json_quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

}  // namespace

std::uint32_t murmur3_32(std::string_view key, std::uint32_t seed) {
  const auto scrambled = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
  std::uint32_t h = seed;
  std::size_t at = 0;
  for (; at + 4 <= key.size(); at += 4) {
    std::uint32_t k = 0;
    for (std::size_t i = 0; i < 4; ++i)
      k |= std::uint32_t{static_cast<unsigned char>(key[at + i])} << (8 * i);
    h = std::rotl(h ^ scrambled(k), 13) * 5 + 0xe6546b64u;
  }
  std::uint32_t rest = 0;
  for (std::size_t i = at; i < key.size(); ++i)
    rest |= std::uint32_t{static_cast<unsigned char>(key[i])} << (8 * (i - at));
  h ^= scrambled(rest) ^ std::uint32_t(key.size());
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  return h ^ h >> 16;
}

float matte_id(std::string_view name) {
  std::uint32_t hash = murmur3_32(name);
  const std::uint32_t exponent = hash >> 23 & 255;
  if (exponent == 0 || exponent == 255) hash ^= 1u << 23;
  return std::bit_cast<float>(hash);
}

std::vector<TextField> matte_attributes(std::string_view layer, std::span<const std::string> names) {
  std::string manifest;
  std::set<std::string_view> listed;
  for (const std::string& name : names) {
    if (!listed.insert(name).second) continue;
    manifest += fmt::format("{}{}:\"{:08x}\"", manifest.empty() ? "" : ",", json_quoted(name),
                            std::bit_cast<std::uint32_t>(matte_id(name)));
  }
  const std::string prefix =
      fmt::format("cryptomatte/{}/", fmt::format("{:08x}", murmur3_32(layer)).substr(0, 7));
  return {{prefix + "name", std::string(layer)},
          {prefix + "hash", "MurmurHash3_32"},
          {prefix + "conversion", "uint32_to_float32"},
          {prefix + "manifest", "{" + manifest + "}"}};
}

MatteTile::MatteTile(Extent size) : size_(size), pixels_(std::size_t(size.area())) {}

void MatteTile::add(std::span<const std::uint32_t> keys, std::span<const float> id_of_key, float weight) {
  FURNACE_CHECK(keys.size() == 4 * pixels_.size(), "{} samples for {} pixels", keys.size(), pixels_.size());
  const float sample_weight = weight / 4;
  const auto width = std::size_t(size_.width);
  for (std::size_t sample = 0; sample < keys.size(); ++sample) {
    const std::uint32_t key = keys[sample];
    if (key == 0) continue;
    FURNACE_CHECK(key < id_of_key.size(), "draw {} of {}", key, id_of_key.size());
    const float id = id_of_key[key];
    const std::size_t y = sample / (2 * width), x = sample % (2 * width);
    for (Rank& rank : pixels_[y / 2 * width + x / 2]) {
      if (rank.id != id && rank.id != 0) continue;
      rank.id = id;
      rank.cover += sample_weight;
      break;
    }
  }
}

std::array<MatteTile::Rank, MatteTile::kRanks> MatteTile::ranks(int x, int y) const {
  auto sorted = pixels_[std::size_t(y) * std::size_t(size_.width) + std::size_t(x)];
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Rank& a, const Rank& b) { return a.cover > b.cover; });
  std::array<Rank, kRanks> largest{};
  // A pixel filter's negative weights may leave less than nothing.
  for (std::size_t i = 0; i < kRanks; ++i)
    if (sorted[i].cover > 0) largest[i] = sorted[i];
  return largest;
}

}  // namespace furnace
