// Judge of a whole picture: what a path tracer without bounces shows of a scene in an environment, in double precision and by
// quasi-random sums. Materials are plain numbers: base colour, metallic, roughness over 0.2, clearcoat.
#pragma once

#include <array>
#include <numbers>
#include <span>

#include "renderer/ibl/baked_environment.hpp"
#include "renderer/ibl/dfg.hpp"
#include "renderer/image/color.hpp"
#include "renderer/scene/framing.hpp"
#include "tests/support/reference/convolution.hpp"
#include "tests/support/reference/ray_caster.hpp"

namespace furnace::reference {

struct DirectionalLight {
  glm::dvec3 towards{0, 1, 0};  // unit
  glm::dvec3 irradiance{0};     // of a plane facing it
};

struct DirectLightSettings {
  double sample_px =
      0.25;  // the filter is that of a sub-frame: four samples so far from the middle of each even place
  int rays = 256;      // through a pixel
  int directions = 4;  // of each way of choosing them, from each ray's end
};

// Permuted congruential generator: O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for
// Random Number Generation".
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 6364136223846793005ull + 1442695040888963407ull) {
    next();
  }
  double next() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ull + 1442695040888963407ull;
    const auto shifted = std::uint32_t(((old >> 18u) ^ old) >> 27u);
    const auto turn = std::uint32_t(old >> 59u);
    return double((shifted >> turn) | (shifted << ((-turn) & 31u))) / 4294967296.0;
  }

 private:
  std::uint64_t state_;
};

// As reflectance() and direct light of the shaders (lib/brdf.glsl, surface/lights.glsl), which cite where it comes from.
struct Lobes {
  glm::dvec3 diffuse{0};  // albedo
  std::array<glm::dvec3, 2> f0,
      gain;  // of the dielectric's and the metal's specular lobes: share and compensation
  double coat_alpha = 0, coat = 0;  // of the clearcoat, above them: width; share and compensation

  Lobes(const Material& material, double NoV) {
    const glm::dvec3 base(material.base_color);
    const double metallic = material.metallic;
    const glm::dvec2 dfg = table_at(NoV, material.perceptual_roughness);
    const double e = dfg.x + dfg.y;
    f0 = {glm::dvec3(0.04), base};
    for (std::size_t i = 0; i < 2; ++i)
      gain[i] = (1.0 + f0[i] * ((1 - e) / e)) * (i == 0 ? 1 - metallic : metallic);
    const glm::dvec3 dielectric = (f0[0] * dfg.x + dfg.y) * (1.0 + f0[0] * ((1 - e) / e));
    diffuse = (1 - metallic) * base * (1.0 - dielectric);

    coat_alpha = double(material.clearcoat_perceptual_roughness) * material.clearcoat_perceptual_roughness;
    const glm::dvec2 coat_dfg = table_at(NoV, material.clearcoat_perceptual_roughness);
    const double coat_e = coat_dfg.x + coat_dfg.y, compensation = 1 + kCoatF0 * ((1 - coat_e) / coat_e);
    coat = material.clearcoat * compensation;
    const double under = 1 - coat * (kCoatF0 * coat_dfg.x + coat_dfg.y);
    diffuse *= under;
    for (glm::dvec3& share : gain) share *= under;
  }

  glm::dvec3 fresnel(double VoH) const {
    const double m5 = std::pow(1 - VoH, 5);
    return gain[0] * (f0[0] + (1.0 - f0[0]) * m5) + gain[1] * (f0[1] + (1.0 - f0[1]) * m5);
  }
  double coat_fresnel(double VoH) const { return coat * (kCoatF0 + (1 - kCoatF0) * std::pow(1 - VoH, 5)); }

 private:
  static constexpr double kCoatF0 = 0.04;

  static glm::dvec2 table_at(double NoV, double roughness) {
    const double x = std::clamp(NoV * kDfgTableSize - 0.5, 0.0, kDfgTableSize - 1.001);
    const double y = std::clamp(roughness * kDfgTableSize - 0.5, 0.0, kDfgTableSize - 1.001);
    const auto i = std::size_t(x), j = std::size_t(y);
    const double u = x - double(i), v = y - double(j);
    const auto at = [&](std::size_t a, std::size_t b) {
      const DfgTexel& texel = dfg_table()[b * std::size_t(kDfgTableSize) + a];
      return glm::dvec2(texel.scale, texel.bias);
    };
    return (1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) +
           v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1));
  }
};

// Directions as dense as an equirect map's luminance, and a little everywhere. Pharr, Jakob and Humphreys 2016, "Physically
// Based Rendering", section 14.2.4.
class LightSampler {
 public:
  explicit LightSampler(const Image& equirect) : extent_(equirect.extent) {
    double mean = 0;
    std::vector<double> luminance, row_sr;
    for (int j = 0; j < extent_.height; ++j) {
      row_sr.push_back((std::cos(std::numbers::pi * j / extent_.height) -
                        std::cos(std::numbers::pi * (j + 1) / extent_.height)) *
                       2 * std::numbers::pi / extent_.width);
      for (int i = 0; i < extent_.width; ++i) {
        const Rgb value = texel_value(equirect, i, j);
        luminance.push_back(luminance_rec709(value[0], value[1], value[2]));
        mean += luminance.back() * row_sr.back() / (4 * std::numbers::pi);
      }
    }
    for (int j = 0; j < extent_.height; ++j) {
      double sum = 0;
      for (int i = 0; i < extent_.width; ++i) {
        density_.push_back(luminance[density_.size()] + 0.1 * mean);
        columns_.push_back(sum += density_.back());
      }
      rows_.push_back((rows_.empty() ? 0 : rows_.back()) + sum * row_sr[std::size_t(j)]);
    }
  }

  glm::dvec3 direction(const glm::dvec2& u) const {
    const auto [j, v] = find(rows_.begin(), rows_.end(), u.x);
    const auto row = columns_.begin() + std::ptrdiff_t(j) * extent_.width;
    const auto [i, w] = find(row, row + extent_.width, u.y);
    // Even in solid angle within the texel.
    const double cosine = std::cos(std::numbers::pi * double(j) / extent_.height) * (1 - v) +
                          std::cos(std::numbers::pi * double(j + 1) / extent_.height) * v;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const double phi = 2 * std::numbers::pi * ((double(i) + w) / extent_.width - 0.5);
    return {sine * std::cos(phi), cosine, sine * std::sin(phi)};
  }
  // Of direction(), per steradian.
  double density(const glm::dvec3& d) const {
    const double u = std::atan2(d.z, d.x) / (2 * std::numbers::pi) + 0.5;
    const double v = std::acos(std::clamp(d.y, -1.0, 1.0)) / std::numbers::pi;
    const auto i = std::min(std::size_t(u * extent_.width), std::size_t(extent_.width) - 1);
    const auto j = std::min(std::size_t(v * extent_.height), std::size_t(extent_.height) - 1);
    return density_[j * std::size_t(extent_.width) + i] / rows_.back();
  }

 private:
  using Sums = std::vector<double>::const_iterator;

  // Where a share of the sum is reached: an index, and how far through it.
  static std::pair<std::size_t, double> find(Sums first, Sums last, double share) {
    const double target = share * *(last - 1);
    const Sums at = std::upper_bound(first, last - 1, target);
    const double before = at == first ? 0 : *(at - 1);
    return {std::size_t(at - first), std::clamp((target - before) / (*at - before), 0.0, 1.0)};
  }

  Extent extent_;
  std::vector<double> density_, columns_, rows_;
};

class DirectLight {
 public:
  DirectLight(const Scene& scene, const Image& equirect, std::vector<DirectionalLight> lights,
              const DirectLightSettings& settings = {})
      : scene_(scene),
        caster_(scene),
        equirect_(equirect),
        light_(equirect),
        lights_(std::move(lights)),
        settings_(settings) {}

  // Radiance of a pixel before exposure; black where nothing of the scene is.
  glm::dvec3 pixel(const View& view, Extent picture, int x, int y) const {
    Random random(std::uint64_t(y) * 65536u + std::uint64_t(x));
    const glm::dvec2 place_shift(random.next(), random.next());
    std::array<glm::dvec2, 3> direction_shifts;
    for (glm::dvec2& shift : direction_shifts) shift = {random.next(), random.next()};
    const glm::dmat4 world_from_clip =
        glm::inverse(glm::dmat4(view.clip_from_view) * glm::dmat4(view.view_from_world));
    glm::dvec3 sum(0);
    for (int k = 0; k < settings_.rays; ++k) {
      const glm::dvec2 place = r2(k / 4, place_shift);
      const double px = x + place.x + (k & 1 ? -settings_.sample_px : settings_.sample_px);
      const double py = y + place.y + (k & 2 ? -settings_.sample_px : settings_.sample_px);
      const glm::dvec4 at =
          world_from_clip * glm::dvec4(2 * px / picture.width - 1, 1 - 2 * py / picture.height, 0.5, 1);
      const glm::dvec3 eye(view.eye), direction = glm::normalize(glm::dvec3(at) / at.w - eye);
      if (const auto hit = caster_.nearest(eye, direction))
        sum += radiance(*hit, -direction, k, direction_shifts);
    }
    return sum / double(settings_.rays);
  }

 private:
  glm::dvec3 environment(const glm::dvec3& l) const {
    const auto rgb = sample_equirect(equirect_, l.x, l.y, l.z);
    return {rgb[0], rgb[1], rgb[2]};
  }
  bool sees(const Hit& hit, const glm::dvec3& l) const {
    return glm::dot(hit.face_normal, l) > 0 && caster_.is_free(hit.position + hit.face_normal * 1e-6, l);
  }

  // What of a radiance from `l` a surface reflects to `v`, times the cosine; both in its frame, where z is the normal.
  static glm::dvec3 reflects(const Lobes& lobes, const glm::dvec3& v, const glm::dvec3& l, double alpha) {
    const glm::dvec3 h = glm::normalize(l + v);
    const double VoH = glm::dot(v, h);
    glm::dvec3 f = lobes.diffuse / std::numbers::pi + d_v(v, l, h, alpha) * lobes.fresnel(VoH);
    if (lobes.coat > 0) f += d_v(v, l, h, lobes.coat_alpha) * lobes.coat_fresnel(VoH);
    return f * l.z;
  }
  static double d_v(const glm::dvec3& v, const glm::dvec3& l, const glm::dvec3& h, double alpha) {
    const double a2 = alpha * alpha;
    return d_ggx(h.z, alpha) * 0.5 /
           (l.z * std::sqrt(v.z * v.z * (1 - a2) + a2) + v.z * std::sqrt(l.z * l.z * (1 - a2) + a2));
  }

  // By three ways of choosing directions, each of which weighs what the others do: Veach and Guibas 1995, "Optimally
  // Combining Sampling Techniques for Monte Carlo Rendering", the balance heuristic.
  glm::dvec3 radiance(const Hit& hit, const glm::dvec3& v_world, int ray,
                      const std::array<glm::dvec2, 3>& shifts) const {
    const Material& material = scene_.materials[std::size_t(hit.material)];
    const glm::dvec3& n = hit.normal;
    const double alpha = double(material.perceptual_roughness) * material.perceptual_roughness;
    const glm::dvec3 other = std::abs(n.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(n, other));
    const glm::dmat3 world(x, glm::cross(n, x), n);
    glm::dvec3 v = v_world * world;
    v.z = std::clamp(v.z, 1e-4, 1.0);
    const Lobes lobes(material, v.z);
    glm::dvec3 sum(0);
    for (int k = 0; k < 3 * settings_.directions; ++k) {
      const glm::dvec2 u = r2(ray * settings_.directions + k / 3, shifts[std::size_t(k) % 3]);
      const glm::dvec3 l = k % 3 == 0   ? cosine_direction(u)
                           : k % 3 == 1 ? mirrored_by_visible_normal(v, alpha, u)
                                        : light_.direction(u) * world;
      if (l.z <= 0) continue;
      const glm::dvec3 towards = world * l;
      const double density =
          l.z / std::numbers::pi + density_of_visible_normals(v, l, alpha) + light_.density(towards);
      if (sees(hit, towards)) sum += reflects(lobes, v, l, alpha) * environment(towards) / density;
    }
    sum /= double(settings_.directions);
    for (const DirectionalLight& light : lights_) {
      const glm::dvec3 l = light.towards * world;
      if (l.z > 0 && sees(hit, light.towards)) sum += light.irradiance * reflects(lobes, v, l, alpha);
    }
    return sum;
  }

  // Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": place i, shifted.
  static glm::dvec2 r2(int i, const glm::dvec2& shift) {
    constexpr double kPlastic = 1.32471795724474602596;
    return glm::fract(shift + double(i) * glm::dvec2(1 / kPlastic, 1 / (kPlastic * kPlastic)));
  }

  static glm::dvec3 cosine_direction(const glm::dvec2& u) {
    const double radius = std::sqrt(u.x), angle = 2 * std::numbers::pi * u.y;
    return {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1 - u.x)};
  }

  // Heitz 2018, "Sampling the GGX Distribution of Visible Normals".
  static glm::dvec3 mirrored_by_visible_normal(const glm::dvec3& v, double alpha, const glm::dvec2& u) {
    const glm::dvec3 stretched = glm::normalize(glm::dvec3(alpha * v.x, alpha * v.y, v.z));
    const double across = stretched.x * stretched.x + stretched.y * stretched.y;
    const glm::dvec3 t1 =
        across > 0 ? glm::dvec3(-stretched.y, stretched.x, 0) / std::sqrt(across) : glm::dvec3(1, 0, 0);
    const glm::dvec3 t2 = glm::cross(stretched, t1);
    const double radius = std::sqrt(u.x), angle = 2 * std::numbers::pi * u.y, s = 0.5 * (1 + stretched.z);
    const double p1 = radius * std::cos(angle);
    const double p2 = (1 - s) * std::sqrt(1 - p1 * p1) + s * radius * std::sin(angle);
    const glm::dvec3 m = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2)) * stretched;
    const glm::dvec3 h = glm::normalize(glm::dvec3(alpha * m.x, alpha * m.y, std::max(1e-9, m.z)));
    return 2 * glm::dot(v, h) * h - v;
  }
  static double density_of_visible_normals(const glm::dvec3& v, const glm::dvec3& l, double alpha) {
    const double lambda_v = 0.5 * (std::sqrt(1 + alpha * alpha * (1 / (v.z * v.z) - 1)) - 1);
    return d_ggx(glm::normalize(l + v).z, alpha) / ((1 + lambda_v) * 4 * v.z);
  }

  const Scene& scene_;
  RayCaster caster_;
  const Image& equirect_;
  LightSampler light_;
  std::vector<DirectionalLight> lights_;
  DirectLightSettings settings_;
};

}  // namespace furnace::reference
