#include "renderer/bake_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <map>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "renderer/image/exr_parts.hpp"
#include "renderer/base/error.hpp"

namespace furnace {
namespace {

constexpr std::string_view kChecksum = "furnace.checksum";
constexpr DecodeLimits kLimits{32768, kLargestBakeFileBytes / 8};
constexpr std::int64_t kMostListed = 256;  // levels, notes: a bake has a few

using Texts = std::map<std::string, std::string, std::less<>>;

[[noreturn]] void fail_foreign(std::string_view what) {
  fail(ErrorCode::kUnprocessable, fmt::format("the stored bake cannot be used: {}", what));
}

// Shortest digits that read back as the same number.
template <class Number>
std::string text_of(const std::vector<Number>& numbers) {
  return fmt::format("{}", fmt::join(numbers, " "));
}

template <class Number>
std::vector<Number> numbers_of(const Texts& texts, std::string_view name) {
  const auto text = texts.find(name);
  if (text == texts.end()) fail_foreign(fmt::format("it has no \"{}\"", name));
  std::vector<Number> numbers;
  const char* at = text->second.data();
  for (const char* const end = at + text->second.size(); at != end;) {
    Number number{};
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc() || (next != end && *next != ' ')) fail_foreign(fmt::format("its \"{}\"", name));
    numbers.push_back(number);
    at = next == end ? end : next + 1;
  }
  return numbers;
}

template <class Number>
std::vector<Number> numbers_of(const Texts& texts, std::string_view name, std::size_t count) {
  const auto numbers = numbers_of<Number>(texts, name);
  if (numbers.size() != count) fail_foreign(fmt::format("its \"{}\"", name));
  return numbers;
}

template <class Number>
Number number_of(const Texts& texts, std::string_view name) {
  return numbers_of<Number>(texts, name, 1).front();
}

std::vector<int> numbers_of(const std::vector<AtlasTile>& tiles) {
  std::vector<int> numbers;
  for (const AtlasTile& tile : tiles) numbers.insert(numbers.end(), {tile.x, tile.y, tile.inner});
  return numbers;
}

// With its border of one texel inside of the atlas.
std::vector<AtlasTile> tiles_of(const Texts& texts, std::string_view name, const Extent& atlas) {
  const auto numbers = numbers_of<int>(texts, name);
  std::vector<AtlasTile> tiles;
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
    const AtlasTile tile{numbers[i], numbers[i + 1], numbers[i + 2]};
    const auto fits = [&](int begin, int side) {
      return begin >= 1 && tile.inner >= 1 && std::int64_t(begin) + tile.inner + 1 <= side;
    };
    if (!fits(tile.x, atlas.width) || !fits(tile.y, atlas.height)) fail_foreign("its tiles");
    tiles.push_back(tile);
  }
  return tiles;
}

// Nine numbers a sun.
std::vector<double> numbers_of(const std::vector<Sun>& suns) {
  std::vector<double> numbers;
  for (const Sun& sun : suns) {
    numbers.insert(numbers.end(), sun.direction.begin(), sun.direction.end());
    numbers.insert(numbers.end(), sun.irradiance.begin(), sun.irradiance.end());
    numbers.insert(numbers.end(), {sun.angular_radius_rad, sun.solid_angle_sr, sun.peak});
  }
  return numbers;
}

std::vector<Sun> suns_of(const Texts& texts, std::string_view name) {
  const auto n = numbers_of<double>(texts, name);
  if (n.size() % 9 != 0) fail_foreign(fmt::format("its \"{}\"", name));
  std::vector<Sun> suns;
  for (std::size_t i = 0; i < n.size(); i += 9) {
    suns.push_back(
        {{n[i], n[i + 1], n[i + 2]}, {n[i + 3], n[i + 4], n[i + 5]}, n[i + 6], n[i + 7], n[i + 8]});
  }
  return suns;
}

double scale_of(const Texts& texts, std::string_view name) {
  const double scale = number_of<double>(texts, name);
  if (!std::isfinite(scale) || scale <= 0) fail_foreign(fmt::format("its \"{}\"", name));
  return scale;
}

// What tells whether a file is the one that is looked for.
Texts identity_of(const ContentHash& key) {
  return {{"furnace.layout", fmt::format("{}", kBakeFileLayout)},
          {"furnace.bakeVersion", fmt::format("{}", kBakeVersion)},
          {"furnace.key", key.hex()}};
}

std::string text_in(const Texts& texts, const std::string& name) {
  const auto found = texts.find(name);
  return found != texts.end() ? found->second : std::string();
}

void check_identity(const Texts& texts, const ContentHash& key) {
  if (number_of<int>(texts, "furnace.layout") != kBakeFileLayout) fail_foreign("another layout");
  if (number_of<int>(texts, "furnace.bakeVersion") != kBakeVersion) fail_foreign("another bake's version");
  if (text_in(texts, "furnace.key") != key.hex()) fail_foreign("another bake's key");
}

void add_notes(const std::vector<Note>& notes, Texts& texts) {
  texts["furnace.notes"] = fmt::format("{}", notes.size());
  for (std::size_t i = 0; i < notes.size(); ++i) {
    texts[fmt::format("furnace.note{}.code", i)] = notes[i].code;
    texts[fmt::format("furnace.note{}.pointer", i)] = notes[i].pointer;
    texts[fmt::format("furnace.note{}.message", i)] = notes[i].message;
  }
}

std::vector<Note> notes_in(const Texts& texts) {
  const auto count = number_of<std::int64_t>(texts, "furnace.notes");
  if (count < 0 || count > kMostListed) fail_foreign("its counts");
  std::vector<Note> notes;
  for (std::int64_t i = 0; i < count; ++i) {
    notes.push_back({text_in(texts, fmt::format("furnace.note{}.code", i)),
                     text_in(texts, fmt::format("furnace.note{}.pointer", i)),
                     text_in(texts, fmt::format("furnace.note{}.message", i))});
  }
  return notes;
}

// Writing and reading of every field; pictures apart.
Texts texts_of(const ContentHash& key, const StoredBake& bake) {
  const PreparedEnvironment& environment = bake.environment;
  const OctahedralAtlas& atlas = environment.atlas;
  const EnvironmentSummary& summary = environment.summary;
  const RepairReport& repairs = summary.repairs;
  Texts texts = identity_of(key);
  texts.merge(Texts{
      {"furnace.skyScale", fmt::format("{}", environment.sky.scale)},
      {"furnace.mapScale", fmt::format("{}", environment.map.scale)},
      {"furnace.atlasScale", fmt::format("{}", atlas.scale)},
      {"furnace.levelRoughness", text_of(atlas.level_roughness)},
      {"furnace.levelTiles", text_of(numbers_of(atlas.level_tiles))},
      {"furnace.irradianceTile", text_of(numbers_of({atlas.irradiance_tile}))},
      {"furnace.summary.size", text_of<int>({summary.size.width, summary.size.height})},
      {"furnace.summary.layout", fmt::format("{}", int(summary.layout))},
      {"furnace.summary.repairs",
       text_of<std::int64_t>({repairs.nan_samples, repairs.infinite_samples, repairs.negative_samples})},
      {"furnace.summary.mean", text_of<double>({summary.mean.begin(), summary.mean.end()})},
      {"furnace.summary.peak", fmt::format("{}", summary.peak)},
      {"furnace.summary.horizontalIlluminanceLux", fmt::format("{}", summary.horizontal_illuminance_lux)},
      {"furnace.summary.bakeMs", fmt::format("{}", summary.bake_ms)},
      {"furnace.summary.suns", text_of(numbers_of(summary.suns))},
      {"furnace.summary.sunsExtracted", fmt::format("{}", int(summary.suns_extracted))},
  });
  add_notes(bake.notes, texts);
  return texts;
}

EnvironmentSummary summary_of(const Texts& texts) {
  const auto size = numbers_of<int>(texts, "furnace.summary.size", 2);
  const auto repairs = numbers_of<std::int64_t>(texts, "furnace.summary.repairs", 3);
  const auto mean = numbers_of<double>(texts, "furnace.summary.mean", 3);
  EnvironmentSummary summary;
  summary.size = {size[0], size[1]};
  const int layout = number_of<int>(texts, "furnace.summary.layout");
  if (layout < 0 || layout > int(kLastEnvironmentLayout)) fail_foreign("its layout");
  summary.layout = EnvironmentLayout(layout);
  summary.repairs = {repairs[0], repairs[1], repairs[2]};
  summary.mean = {mean[0], mean[1], mean[2]};
  summary.peak = number_of<double>(texts, "furnace.summary.peak");
  summary.horizontal_illuminance_lux = number_of<double>(texts, "furnace.summary.horizontalIlluminanceLux");
  summary.bake_ms = number_of<double>(texts, "furnace.summary.bakeMs");
  summary.suns = suns_of(texts, "furnace.summary.suns");
  summary.suns_extracted = number_of<int>(texts, "furnace.summary.sunsExtracted") != 0;
  return summary;
}

void read_texts(const Texts& texts, const ContentHash& key, StoredBake& bake) {
  PreparedEnvironment& environment = bake.environment;
  OctahedralAtlas& atlas = environment.atlas;
  check_identity(texts, key);
  environment.key = key;
  environment.sky.key = key;
  environment.map.key = map_key_of(key);
  environment.sky.scale = scale_of(texts, "furnace.skyScale");
  environment.map.scale = scale_of(texts, "furnace.mapScale");
  atlas.scale = scale_of(texts, "furnace.atlasScale");
  atlas.level_roughness = numbers_of<double>(texts, "furnace.levelRoughness");
  atlas.level_tiles = tiles_of(texts, "furnace.levelTiles", atlas.texels.extent);
  environment.summary = summary_of(texts);
  const auto irradiance = tiles_of(texts, "furnace.irradianceTile", atlas.texels.extent);
  if (irradiance.size() != 1 || atlas.level_tiles.size() != atlas.level_roughness.size() ||
      std::int64_t(atlas.level_tiles.size()) > kMostListed) {
    fail_foreign("its counts");
  }
  atlas.irradiance_tile = irradiance.front();
  bake.notes = notes_in(texts);
}

std::string checksum_of(const Texts& texts, std::initializer_list<const Image*> images) {
  HashBuilder sum;
  for (const auto& [name, text] : texts) {
    if (name != kChecksum) sum.add(name).add(text);
  }
  for (const Image* image : images) {
    sum.add(std::int64_t(image->extent.width)).add(std::int64_t(image->extent.height));
    sum.add(std::span<const std::byte>(image->pixels));
  }
  return sum.finish().hex();
}

std::string checksum_of(const Texts& texts, const PreparedEnvironment& environment) {
  return checksum_of(texts, {&environment.sky.texels, &environment.map.texels, &environment.atlas.texels});
}

void check_checksum(const Texts& texts, const std::string& checksum) {
  if (text_in(texts, std::string(kChecksum)) != checksum) fail_foreign("its checksum");
}

std::string encode(const std::vector<NamedImage>& parts, Texts texts, const std::string& checksum) {
  texts.emplace(kChecksum, checksum);
  std::vector<TextField> attributes;
  for (auto& [name, text] : texts) attributes.push_back({name, text});
  return encode_exr_parts(parts, attributes);
}

}  // namespace

std::string encode_bake(const ContentHash& key, const StoredBake& bake) {
  const PreparedEnvironment& environment = bake.environment;
  const Texts texts = texts_of(key, bake);
  std::vector<NamedImage> parts = {{"sky", &environment.sky.texels}, {"atlas", &environment.atlas.texels}};
  if (environment.summary.suns_extracted) parts.push_back({"map", &environment.map.texels});
  return encode(parts, texts, checksum_of(texts, environment));
}

StoredBake decode_bake(const ContentHash& key, std::string_view file) {
  ExrParts parts = decode_exr_parts(std::as_bytes(std::span(file)), kLimits);
  StoredBake bake;
  PreparedEnvironment& environment = bake.environment;
  std::size_t known = 0;
  const auto take = [&](const char* name, Image& texels) {
    const auto found = parts.images.find(name);
    if (found == parts.images.end()) return;
    texels = std::move(found->second);
    ++known;
  };
  take("sky", environment.sky.texels);
  take("atlas", environment.atlas.texels);
  take("map", environment.map.texels);
  const auto absent = [](const Image& image) { return image.pixels.empty(); };
  if (known != parts.images.size() || absent(environment.sky.texels) || absent(environment.atlas.texels))
    fail_foreign("its parts are not sky, atlas and map");
  read_texts(parts.attributes, key, bake);
  if (absent(environment.map.texels) == environment.summary.suns_extracted) fail_foreign("its map");
  check_checksum(parts.attributes, checksum_of(parts.attributes, environment));
  return bake;
}

std::string encode_background(const ContentHash& key, const StoredBackground& background) {
  const PreparedSky& sky = background.sky;
  Texts texts = identity_of(key);
  texts["furnace.skyScale"] = fmt::format("{}", sky.scale);
  add_notes(background.notes, texts);
  return encode({{"background", &sky.texels}}, texts, checksum_of(texts, {&sky.texels}));
}

StoredBackground decode_background(const ContentHash& key, std::string_view file) {
  ExrParts parts = decode_exr_parts(std::as_bytes(std::span(file)), kLimits);
  const auto found = parts.images.find("background");
  if (parts.images.size() != 1 || found == parts.images.end()) fail_foreign("its part is not background");
  check_identity(parts.attributes, key);
  StoredBackground background;
  background.sky = {key, std::move(found->second), scale_of(parts.attributes, "furnace.skyScale")};
  background.notes = notes_in(parts.attributes);
  check_checksum(parts.attributes, checksum_of(parts.attributes, {&background.sky.texels}));
  return background;
}

}  // namespace furnace
