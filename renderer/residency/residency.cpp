#include "renderer/residency/residency.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/ibl/dfg.hpp"
#include "renderer/ibl/ltc.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

gl::Texture make_neutral(gl::Context& context) {
  Image white = make_image({1, 1}, 4, SampleType::kUint8, ColorSpace::kNonColor);
  std::fill(white.pixels.begin(), white.pixels.end(), std::byte{255});
  return gl::upload_texture(context, white, false);
}

constexpr Extent kTable{kDfgTableSize, kDfgTableSize};

// Of the profile's share of its peak, RGBA alike: columns round the axis from 0 to 2 pi, rows from where the luminaire points to
// behind it, closer together near both, where beams are narrow: vertical = pi / 2 (1 - cos(pi row / last)).
std::vector<float> profile_texels(const LightProfile& profile) {
  std::vector<float> texels;
  constexpr double kLast = kDfgTableSize - 1;
  for (int row = 0; row < kDfgTableSize; ++row) {
    const double vertical = kPi / 2 * (1 - std::cos(kPi * row / kLast));
    for (int column = 0; column < kDfgTableSize; ++column) {
      const double share = profile.candela_towards(vertical, 2 * kPi * column / kLast) / profile.peak_candela;
      texels.insert(texels.end(), 4, float(share));
    }
  }
  return texels;
}

}  // namespace

bool ResidentKeys::contains(const ContentHash& key) const {
  const std::lock_guard lock(mutex_);
  return keys_.contains(key);
}
void ResidentKeys::insert(const ContentHash& key, std::int64_t bytes) {
  const std::lock_guard lock(mutex_);
  keys_.insert(key);
  bytes_ += bytes;
}
void ResidentKeys::erase(const ContentHash& key, std::int64_t bytes) {
  const std::lock_guard lock(mutex_);
  keys_.erase(key);
  bytes_ -= bytes;
}
std::int64_t ResidentKeys::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

Residency::Residency(gl::Context& context, std::int64_t budget_bytes, std::shared_ptr<ResidentKeys> keys)
    : context_(context),
      budget_bytes_(budget_bytes),
      keys_(std::move(keys)),
      meshes_(total_bytes_, *keys_),
      occluders_(total_bytes_, *keys_),
      textures_(total_bytes_, *keys_),
      skies_(total_bytes_, *keys_),
      lobe_tables_(total_bytes_, *keys_),
      environments_(total_bytes_, *keys_),
      ground_shadows_(total_bytes_, *keys_),
      neutral_(make_neutral(context)) {}

Residency::~Residency() {
  // A rebuilt context starts with nothing.
  meshes_.clear();
  occluders_.clear();
  textures_.clear();
  skies_.clear();
  lobe_tables_.clear();
  environments_.clear();
  ground_shadows_.clear();
}

void Residency::begin_frame() {
  ++frame_;
  uploaded_ = false;
  while (total_bytes_ > budget_bytes_) {
    const std::uint64_t oldest = std::min(
        {meshes_.oldest(frame_), occluders_.oldest(frame_), textures_.oldest(frame_), skies_.oldest(frame_),
         lobe_tables_.oldest(frame_), environments_.oldest(frame_), ground_shadows_.oldest(frame_)});
    if (oldest == frame_) break;
    meshes_.evict(oldest);
    occluders_.evict(oldest);
    textures_.evict(oldest);
    skies_.evict(oldest);
    lobe_tables_.evict(oldest);
    environments_.evict(oldest);
    ground_shadows_.evict(oldest);
  }
}

const GpuMesh* Residency::mesh(const PreparedMesh& mesh) {
  if (const GpuMesh* known = meshes_.find(mesh.key, frame_)) return known;
  if (mesh.packed == nullptr) return nullptr;
  uploaded_ = true;
  return meshes_.insert(mesh.key, frame_, upload_mesh(context_, *mesh.mesh, *mesh.packed));
}

const GpuOccluder* Residency::occluder(const PreparedMesh& mesh) {
  const ContentHash key = occluder_key_of(mesh.key);
  if (const GpuOccluder* known = occluders_.find(key, frame_)) return known;
  if (mesh.occluder == nullptr) return nullptr;
  uploaded_ = true;
  const std::vector<std::uint32_t>& indices = *mesh.occluder;
  GpuOccluder gpu;
  gpu.count = GLsizei(indices.size());
  gpu.bytes = indices.size() * sizeof(std::uint32_t);
  // Nothing is left of a mesh without an area.
  if (!indices.empty()) gpu.indices = gl::create_buffer(context_, indices.data(), gpu.bytes);
  return occluders_.insert(key, frame_, std::move(gpu));
}

const GpuTexture* Residency::texture(const PreparedTexture& texture) {
  if (const GpuTexture* known = textures_.find(texture.key, frame_)) return known;
  if (texture.levels == nullptr) return nullptr;
  uploaded_ = true;
  const Image& largest = texture.levels->front();
  GpuTexture gpu{gl::upload_levels(context_, *texture.levels), largest.extent, largest.byte_size() * 4 / 3,
                 texture.lowest_green};
  return textures_.insert(texture.key, frame_, std::move(gpu));
}

const GpuEnvironment* Residency::environment(const PreparedEnvironment& environment) {
  if (const GpuEnvironment* known = environments_.find(environment.key, frame_)) return known;
  uploaded_ = true;
  GpuEnvironment gpu{gl::upload_texture(context_, environment.atlas.texels, false),
                     environment.atlas.texels.byte_size()};
  return environments_.insert(environment.key, frame_, std::move(gpu));
}

const GpuTexture* Residency::sky(const PreparedSky& sky) {
  if (const GpuTexture* known = skies_.find(sky.key, frame_)) return known;
  uploaded_ = true;
  GpuTexture gpu{gl::upload_texture(context_, sky.texels, true), sky.texels.extent,
                 sky.texels.byte_size() * 4 / 3};
  return skies_.insert(sky.key, frame_, std::move(gpu));
}

const GpuTexture* Residency::lobe_tables(const std::vector<Light>& lights) {
  HashBuilder builder;
  builder.add("lobe tables");
  std::vector<const LightProfile*> profiles;
  for (const Light& light : lights) {
    if (light.profile == nullptr) continue;
    builder.add(light.profile->hash);
    profiles.push_back(light.profile.get());
  }
  const ContentHash key = builder.finish();
  if (const GpuTexture* known = lobe_tables_.find(key, frame_)) return known;
  uploaded_ = true;
  const int layers = int(gpu::FIRST_PROFILE) + int(profiles.size());
  GpuTexture gpu{
      gl::create_texture_array(context_, GL_RGBA32F, kTable, layers), kTable,
      std::size_t(kTable.width) * std::size_t(kTable.height) * 4 * sizeof(float) * std::size_t(layers)};
  const auto fill = [&](int layer, const void* texels) {
    glTextureSubImage3D(gpu.texture.id(), 0, 0, 0, layer, kTable.width, kTable.height, 1, GL_RGBA, GL_FLOAT,
                        texels);
  };
  static_assert(sizeof(DfgTexel) == 4 * sizeof(float) && sizeof(LtcTexel) == 4 * sizeof(float));
  fill(0, dfg_table().data());
  fill(1, ltc_table().data());
  for (std::size_t i = 0; i < profiles.size(); ++i)
    fill(int(gpu::FIRST_PROFILE) + int(i), profile_texels(*profiles[i]).data());
  return lobe_tables_.insert(key, frame_, std::move(gpu));
}

const GpuGroundShadow* Residency::keep_ground_shadow(const ContentHash& key, GpuGroundShadow shadow) {
  uploaded_ = true;
  return ground_shadows_.insert(key, frame_, std::move(shadow));
}

}  // namespace furnace
