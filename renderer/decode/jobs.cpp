#include "renderer/decode/jobs.hpp"

#include <algorithm>
#include <bit>

#include "renderer/base/error.hpp"

namespace furnace::decode {
namespace {

std::int64_t largest_area_px(const DecodeLimits& limits) {
  return std::min(limits.max_area_px, std::int64_t(limits.max_side_px) * limits.max_side_px);
}

// Arrays begin at multiples of 64 bytes.
constexpr std::int64_t kArrayGapBytes = 64;

// Mip levels take a third more, and lines, which only get shorter, as much again.
std::int64_t largest_chain_px(const DecodeLimits& limits) {
  const std::int64_t area = largest_area_px(limits);
  return area + area / 3 + 2 * std::min<std::int64_t>(area, limits.max_side_px);
}

bool is_plain_text(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

bool is_count(std::int64_t said, std::size_t most) {
  return said >= 0 && std::uint64_t(said) <= most;
}

}  // namespace

bool is_whole(const Image& image, const DecodeLimits& limits) {
  const auto is_side = [&](int side) { return side >= 1 && side <= limits.max_side_px; };
  if (!is_side(image.extent.width) || !is_side(image.extent.height)) return false;
  if (image.extent.area() > limits.max_area_px || image.channels < 1 || image.channels > 4) return false;
  const std::size_t pixel_bytes = std::size_t(image.channels) * sample_bytes(image.type);
  return image.pixels.size() == std::size_t(image.extent.area()) * pixel_bytes;
}

std::int64_t TextureJob::largest_result_bytes() const {
  return largest_chain_px(limits) * 4 * std::int64_t(sample_bytes(SampleType::kUint16)) +
         std::int64_t(kMostLevels) * kArrayGapBytes;
}

bool TextureJob::accepts(const DecodedTexture& texture) const {
  if (texture.levels.empty()) return false;
  const Image& first = texture.levels[0];
  if (first.type != SampleType::kUint8 && first.type != SampleType::kUint16) return false;
  for (std::size_t i = 0; i < texture.levels.size(); ++i) {
    const Image& level = texture.levels[i];
    if (!is_whole(level, limits) || level.color_space != color_space) return false;
    if (i == 0) continue;
    const Extent above = texture.levels[i - 1].extent;
    const Extent half{std::max(above.width / 2, 1), std::max(above.height / 2, 1)};
    if (above == half || level.extent != half) return false;
    if (level.type != first.type || level.channels != first.channels) return false;
  }
  return std::ranges::all_of(texture.remarks, [](const TextureRemark& remark) {
    return is_plain_text(remark.code) && is_plain_text(remark.message);
  });
}

PlainModel ModelJob::run(Bytes file) const {
  if (document_bytes > file.size()) fail(ErrorCode::kInternal, "a model is shorter than was said");
  const Bytes materials = file.subspan(document_bytes);
  return decode_model(file.first(document_bytes),
                      {reinterpret_cast<const char*>(materials.data()), materials.size()}, format, limits);
}

std::int64_t ModelJob::largest_result_bytes() const {
  // Names have less than a KiB each: assimp's strings hold no more, and the reader of PLY takes none that is longer.
  constexpr std::int64_t kTextBytes = (2 + kPlainTextures) * 1024;
  constexpr auto kNamedBytes = std::int64_t(kTextBytes + sizeof(PlainMaterial) + sizeof(PlainPart));
  return limits.max_bytes + limits.max_materials * kNamedBytes;
}

std::int64_t EnvironmentJob::largest_result_bytes() const {
  return largest_area_px(limits) * 3 * std::int64_t(sizeof(float));
}

bool EnvironmentJob::accepts(const DecodedEnvironment& environment) const {
  const Image& map = environment.equirect;
  const RepairReport& repairs = environment.repairs;
  const bool is_asked_for = layout == EnvironmentLayout::kAuto || environment.layout == layout;
  if (environment.layout == EnvironmentLayout::kAuto || !is_asked_for) return false;
  if (map.channels != 3 || map.type != SampleType::kFloat32 || map.color_space != ColorSpace::kLinear)
    return false;
  if (!is_whole(map, limits) || map.extent.width != 2 * std::int64_t{map.extent.height}) return false;
  const std::span<const float> samples = map.samples<float>();
  const bool counts = is_count(repairs.nan_samples, samples.size()) &&
                      is_count(repairs.infinite_samples, samples.size()) &&
                      is_count(repairs.negative_samples, samples.size());
  // By bits and without a way out, so that the loop runs on vectors: infinities, NaN and what is negative come after all
  // finite numbers, but for -0.
  std::uint32_t unsound = 0;
  for (const float sample : samples) {
    const auto bits = std::bit_cast<std::uint32_t>(sample);
    unsound |= std::uint32_t(bits >= 0x7f800000u) & std::uint32_t(bits != 0x80000000u);
  }
  return counts && unsound == 0;
}

std::int64_t DracoJob::largest_result_bytes() const {
  return std::int64_t(draco_result_bytes(request)) +
         std::int64_t(request.attributes.size() + 1) * kArrayGapBytes;
}

bool DracoJob::accepts(const DracoMesh& mesh) const {
  if (mesh.indices.size() % 3 != 0 || mesh.indices.size() / 3 > request.most_triangles) return false;
  if (std::ranges::any_of(mesh.indices, [&](std::uint32_t index) { return index >= request.vertices; }))
    return false;
  return std::ranges::equal(mesh.attributes, request.attributes,
                            [&](const std::vector<std::byte>& values, const DracoAttribute& wanted) {
                              return values.size() == request.vertices * element_bytes(wanted);
                            });
}

}  // namespace furnace::decode
