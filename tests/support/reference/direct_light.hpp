// Judge of a whole picture: what a path tracer without bounces shows of a scene in an environment, in double precision and by
// stratified sums. Materials are plain numbers: base colour, metallic, roughness over 0.2.
#pragma once

#include <array>
#include <numbers>
#include <span>

#include "renderer/ibl/baked_environment.hpp"
#include "renderer/ibl/dfg.hpp"
#include "renderer/scene/framing.hpp"
#include "tests/support/reference/ray_caster.hpp"

namespace furnace::reference {

struct DirectionalLight {
  glm::dvec3 towards{0, 1, 0};  // unit
  glm::dvec3 irradiance{0};     // of a plane facing it
};

struct DirectLightSettings {
  int pixel_side = 3;   // rays through a pixel each way
  int light_side = 10;  // directions of each lobe from each of these, squared
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
  }

  glm::dvec3 fresnel(double VoH) const {
    const double m5 = std::pow(1 - VoH, 5);
    return gain[0] * (f0[0] + (1.0 - f0[0]) * m5) + gain[1] * (f0[1] + (1.0 - f0[1]) * m5);
  }

 private:
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

class DirectLight {
 public:
  DirectLight(const Scene& scene, const Image& equirect, std::vector<DirectionalLight> lights,
              const DirectLightSettings& settings = {})
      : scene_(scene), caster_(scene), equirect_(equirect), lights_(std::move(lights)), settings_(settings) {}

  // Radiance of a pixel before exposure; black where nothing of the scene is.
  glm::dvec3 pixel(const View& view, Extent picture, int x, int y) const {
    Random random(std::uint64_t(y) * 65536u + std::uint64_t(x));
    const glm::dmat4 world_from_clip =
        glm::inverse(glm::dmat4(view.clip_from_view) * glm::dmat4(view.view_from_world));
    glm::dvec3 sum(0);
    const int side = settings_.pixel_side;
    for (int k = 0; k < side * side; ++k) {
      const double px = x + (k % side + random.next()) / side, py = y + (k / side + random.next()) / side;
      const glm::dvec4 at =
          world_from_clip * glm::dvec4(2 * px / picture.width - 1, 1 - 2 * py / picture.height, 0.5, 1);
      const glm::dvec3 eye(view.eye), direction = glm::normalize(glm::dvec3(at) / at.w - eye);
      if (const auto hit = caster_.nearest(eye, direction)) sum += radiance(*hit, -direction, random);
    }
    return sum / double(side * side);
  }

 private:
  glm::dvec3 environment(const glm::dvec3& l) const {
    const auto rgb = sample_equirect(equirect_, l.x, l.y, l.z);
    return {rgb[0], rgb[1], rgb[2]};
  }
  bool sees(const Hit& hit, const glm::dvec3& l) const {
    return glm::dot(hit.face_normal, l) > 0 && caster_.is_free(hit.position + hit.face_normal * 1e-6, l);
  }

  glm::dvec3 radiance(const Hit& hit, const glm::dvec3& v, Random& random) const {
    const Material& material = scene_.materials[std::size_t(hit.material)];
    const glm::dvec3& n = hit.normal;
    const double NoV = std::clamp(glm::dot(n, v), 1e-4, 1.0);
    const double alpha = double(material.perceptual_roughness) * material.perceptual_roughness;
    const Lobes lobes(material, NoV);
    const glm::dvec3 x = glm::normalize(std::abs(n.y) < 0.9 ? glm::cross(n, glm::dvec3(0, 1, 0))
                                                            : glm::cross(n, glm::dvec3(1, 0, 0)));
    const glm::dmat3 world(x, glm::cross(n, x), n);
    const glm::dvec3 local_v = glm::transpose(world) * v;
    glm::dvec3 diffuse(0), specular(0);
    const int side = settings_.light_side;
    for (int k = 0; k < side * side; ++k) {
      const glm::dvec2 a((k % side + random.next()) / side, (k / side + random.next()) / side);
      const glm::dvec3 l = world * cosine_direction(a);
      if (sees(hit, l)) diffuse += environment(l);
      const glm::dvec2 b((k % side + random.next()) / side, (k / side + random.next()) / side);
      specular += reflected(hit, lobes, world, local_v, alpha, b);
    }
    glm::dvec3 sum = (lobes.diffuse * diffuse + specular) / double(side * side);
    for (const DirectionalLight& light : lights_) {
      const double NoL = glm::dot(n, light.towards);
      if (NoL <= 0 || !sees(hit, light.towards)) continue;
      const glm::dvec3 h = glm::normalize(light.towards + v);
      const double NoH = glm::dot(n, h), a2 = alpha * alpha, d = NoH * NoH * (a2 - 1) + 1;
      const double D = a2 / (std::numbers::pi * d * d);
      const double V =
          0.5 / (NoL * std::sqrt(NoV * NoV * (1 - a2) + a2) + NoV * std::sqrt(NoL * NoL * (1 - a2) + a2));
      sum +=
          light.irradiance * NoL * (lobes.diffuse / std::numbers::pi + D * V * lobes.fresnel(glm::dot(v, h)));
    }
    return sum;
  }

  static glm::dvec3 cosine_direction(const glm::dvec2& u) {
    const double radius = std::sqrt(u.x), angle = 2 * std::numbers::pi * u.y;
    return {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1 - u.x)};
  }

  // Heitz 2018, "Sampling the GGX Distribution of Visible Normals": the weight of a direction is F G2 / G1(v).
  glm::dvec3 reflected(const Hit& hit, const Lobes& lobes, const glm::dmat3& world, const glm::dvec3& v,
                       double alpha, const glm::dvec2& u) const {
    const glm::dvec3 stretched = glm::normalize(glm::dvec3(alpha * v.x, alpha * v.y, v.z));
    const double across = stretched.x * stretched.x + stretched.y * stretched.y;
    const glm::dvec3 t1 =
        across > 0 ? glm::dvec3(-stretched.y, stretched.x, 0) / std::sqrt(across) : glm::dvec3(1, 0, 0);
    const glm::dvec3 t2 = glm::cross(stretched, t1);
    const double radius = std::sqrt(u.x), angle = 2 * std::numbers::pi * u.y, s = 0.5 * (1 + stretched.z);
    const double p1 = radius * std::cos(angle);
    const double p2 = (1 - s) * std::sqrt(1 - p1 * p1) + s * radius * std::sin(angle);
    const glm::dvec3 m = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2)) * stretched;
    const glm::dvec3 h = glm::normalize(glm::dvec3(alpha * m.x, alpha * m.y, std::max(0.0, m.z)));
    const glm::dvec3 l = 2 * glm::dot(v, h) * h - v;
    if (l.z <= 0) return glm::dvec3(0);
    const glm::dvec3 towards = world * l;
    if (!sees(hit, towards)) return glm::dvec3(0);
    const auto lambda = [&](double cosine) {
      return 0.5 * (std::sqrt(1 + alpha * alpha * (1 / (cosine * cosine) - 1)) - 1);
    };
    const double lambda_v = lambda(std::max(v.z, 1e-4));
    return lobes.fresnel(glm::dot(v, h)) * ((1 + lambda_v) / (1 + lambda_v + lambda(l.z))) *
           environment(towards);
  }

  const Scene& scene_;
  RayCaster caster_;
  const Image& equirect_;
  std::vector<DirectionalLight> lights_;
  DirectLightSettings settings_;
};

}  // namespace furnace::reference
