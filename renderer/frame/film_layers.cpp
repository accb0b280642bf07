#include "renderer/frame/film_layers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

namespace furnace {
namespace {

bool is_matte(FilmLayer layer) {
  return row_of(layer).kind == FilmLayerKind::kMatte;
}

// What must not be rounded is kept as it was drawn.
SampleType stored_type(FilmLayer layer, const FramePlan& plan) {
  const FilmLayerKind kind = row_of(layer).kind;
  const bool exact = kind == FilmLayerKind::kPlace || kind == FilmLayerKind::kMatte;
  return exact || plan.film_type != SampleType::kFloat16 ? SampleType::kFloat32 : SampleType::kFloat16;
}

void put(Image& image, std::size_t pixel, const glm::vec4& numbers) {
  const auto channels = std::size_t(image.channels);
  for (std::size_t c = 0; c < channels; ++c) {
    const float number = numbers[int(c)];
    if (image.type == SampleType::kFloat16)
      image.samples<std::uint16_t>()[pixel * channels + c] = half_from_float(number);
    else
      image.samples<float>()[pixel * channels + c] = number;
  }
}

std::string name_of(const std::vector<Material>& materials, int material) {
  const std::string& name = materials[std::size_t(material)].name;
  return name.empty() ? fmt::format("/materials/{}", material) : name;
}

// The numbers of names, counted from 1 as they first appear; the draw's key is its index + 1.
std::vector<float> numbers_of_names(const std::vector<std::string>& names) {
  std::map<std::string_view, float> known;
  std::vector<float> numbers{0};
  for (const std::string& name : names)
    numbers.push_back(known.try_emplace(name, float(known.size() + 1)).first->second);
  return numbers;
}

std::vector<std::string> draw_names(const PreparedScene& scene, bool of_materials) {
  std::vector<std::string> names;
  for (const Instance& instance : scene.instances)
    names.push_back(of_materials ? name_of(scene.materials, instance.material) : instance.node_name);
  return names;
}

}  // namespace

FilmLayers::FilmLayers(const FramePlan& plan, const Subject& subject,
                       const std::vector<const PreparedScene*>& seen)
    : plan_(plan), view_(subject.view) {
  const LayerPlan& wanted = plan.layers;
  if (wanted.sources.empty() && !wanted.any_matte()) return;
  if (subject.earlier != nullptr)
    motion_.emplace(plan.picture, subject.view, subject.scene, *subject.earlier);
  object_of_key_ = numbers_of_names(draw_names(subject.scene, false));
  material_of_key_ = numbers_of_names(draw_names(subject.scene, true));
  const auto add_image = [&](FilmLayer layer, const std::string& name) {
    const std::string channels(row_of(layer).channels);
    images_.push_back(
        {name, channels,
         make_image(plan.picture, int(channels.size()), stored_type(layer, plan), ColorSpace::kNonColor)});
  };
  for (const FilmLayer layer : wanted.layers) {
    if (is_matte(layer)) continue;
    kept_.push_back(layer);
    add_image(layer, std::string(row_of(layer).name));
  }
  for (const FilmLayer layer : wanted.layers) {
    if (!is_matte(layer)) continue;
    mattes_.push_back({layer, matte_of(layer, seen)});
    for (int level = 0; level < kMatteLevels; ++level)
      add_image(layer, fmt::format("{}{:02}", row_of(layer).name, level));
  }
  if (wanted.shown && !wanted.shows_radiance())
    shown_ = make_image(plan.picture, 4, SampleType::kFloat32, ColorSpace::kNonColor);
}

FilmLayers::Matte FilmLayers::matte_of(FilmLayer layer, const std::vector<const PreparedScene*>& seen) const {
  Matte matte;
  std::map<std::string, float> id_of_name;
  for (const PreparedScene* scene : seen) {
    std::vector<float>& ids = matte.id_of_key.emplace_back(1, 0.f);
    for (const std::string& name : draw_names(*scene, layer == FilmLayer::kCryptoMaterial)) {
      const auto [known, fresh] = id_of_name.try_emplace(name, 0.f);
      if (fresh) {
        known->second = matte_id(name);
        matte.names.push_back(name);
      }
      ids.push_back(known->second);
    }
  }
  return matte;
}

glm::vec4 FilmLayers::numbers_of(FilmLayer layer, const glm::vec4& drawn) const {
  const auto number_of_key = [&](const std::vector<float>& numbers) {
    return glm::vec4(numbers[std::size_t(drawn.x)], 0, 0, drawn.a);
  };
  switch (layer) {
    case FilmLayer::kDepth: {
      if (drawn.a == 0) return {std::numeric_limits<float>::infinity(), 0, 0, 0};
      const glm::dvec3 from_eye = glm::dvec3(drawn) - glm::dvec3(view_.eye);
      const glm::dvec3 backwards(glm::transpose(glm::mat3(view_.view_from_world))[2]);
      return {float(-glm::dot(from_eye, backwards)), 0, 0, drawn.a};
    }
    case FilmLayer::kObjectId:
      return number_of_key(object_of_key_);
    case FilmLayer::kMaterialId:
      return number_of_key(material_of_key_);
    case FilmLayer::kPrimitiveId:
      return {drawn.y, 0, 0, drawn.a};
    case FilmLayer::kViewNormal:
      return {glm::mat3(view_.view_from_world) * glm::vec3(drawn), drawn.a};
    case FilmLayer::kMetallic:
      return {drawn.y, 0, 0, drawn.a};
    case FilmLayer::kOcclusion:
      return {drawn.z, 0, 0, drawn.a};
    case FilmLayer::kCoverage:
      return {drawn.a, 0, 0, drawn.a};
    default: {
      const float exposure = row_of(layer).exposed ? float(plan_.exposure) : 1;
      return {glm::vec3(drawn) * exposure, drawn.a};
    }
  }
}

void FilmLayers::store(FilmLayer source, const Image& drawn, const Tile& tile) {
  const auto samples = drawn.samples<float>();
  const auto store_one = [&](FilmLayer layer, Image& image) {
    for (int y = 0; y < tile.size.height; ++y) {
      const std::size_t from = std::size_t(y) * std::size_t(drawn.extent.width);
      const std::size_t to = std::size_t(tile.y + y) * std::size_t(plan_.picture.width) + std::size_t(tile.x);
      for (std::size_t x = 0; x < std::size_t(tile.size.width); ++x) {
        const float* pixel = &samples[4 * (from + x)];
        put(image, to + x, numbers_of(layer, {pixel[0], pixel[1], pixel[2], pixel[3]}));
      }
    }
  };
  const auto is_served = [&](FilmLayer layer) {
    return source_of(layer) == source && layer != FilmLayer::kMotion;
  };
  for (std::size_t i = 0; i < kept_.size(); ++i)
    if (is_served(kept_[i])) store_one(kept_[i], images_[i].image);
  if (!shown_.pixels.empty() && is_served(*plan_.layers.shown)) store_one(*plan_.layers.shown, shown_);
}

void FilmLayers::store_motion(const Image& positions, const Image& numbers, const Tile& tile) {
  const auto places = positions.samples<float>(), keys = numbers.samples<float>();
  for (int y = 0; y < tile.size.height; ++y) {
    const std::size_t from = std::size_t(y) * std::size_t(positions.extent.width);
    const std::size_t to = std::size_t(tile.y + y) * std::size_t(plan_.picture.width) + std::size_t(tile.x);
    for (std::size_t x = 0; x < std::size_t(tile.size.width); ++x) {
      const float *place = &places[4 * (from + x)], *key = &keys[4 * (from + x)];
      glm::vec2 moved(0);
      if (motion_ && place[3] != 0)
        moved = motion_->at(std::uint32_t(key[0]), std::uint32_t(key[1]), {place[0], place[1], place[2]});
      put_all(FilmLayer::kMotion, to + x, {moved, 0, place[3]});
    }
  }
}

// Wherever the layer is wanted.
void FilmLayers::put_all(FilmLayer layer, std::size_t pixel, const glm::vec4& numbers) {
  for (std::size_t i = 0; i < kept_.size(); ++i)
    if (kept_[i] == layer) put(images_[i].image, pixel, numbers);
  if (!shown_.pixels.empty() && plan_.layers.shown == layer) put(shown_, pixel, numbers);
}

void FilmLayers::begin_mattes(const Tile& tile) {
  for (auto& [layer, matte] : mattes_) matte.tile = MatteTile(tile.size);
}

void FilmLayers::add_to_mattes(const std::vector<std::uint32_t>& keys, float weight, std::size_t moment) {
  for (auto& [layer, matte] : mattes_) matte.tile.add(keys, matte.id_of_key[moment], weight);
}

void FilmLayers::store_mattes(const Tile& tile) {
  std::size_t image = kept_.size();
  for (auto& [layer, matte] : mattes_) {
    for (int y = 0; y < tile.size.height; ++y) {
      for (int x = 0; x < tile.size.width; ++x) {
        const auto ranks = matte.tile.ranks(x, y);
        const std::size_t pixel =
            std::size_t(tile.y + y) * std::size_t(plan_.picture.width) + std::size_t(tile.x + x);
        for (std::size_t level = 0; level < kMatteLevels; ++level) {
          const MatteTile::Rank &first = ranks[2 * level], &second = ranks[2 * level + 1];
          put(images_[image + level].image, pixel, {first.id, first.cover, second.id, second.cover});
        }
      }
    }
    image += kMatteLevels;
  }
}

std::vector<ImageLayer> FilmLayers::take_layers() {
  return std::move(images_);
}

std::vector<TextField> FilmLayers::attributes() const {
  std::vector<TextField> all;
  for (const auto& [layer, matte] : mattes_) {
    const std::vector<TextField> fields = matte_attributes(row_of(layer).name, matte.names);
    all.insert(all.end(), fields.begin(), fields.end());
  }
  return all;
}

}  // namespace furnace
