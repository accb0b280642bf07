// A sun of at least a share s of the flux F within a solid angle W has a mean radiance of at least s F / W. Texels above
// that are few; suns are grown around the brightest of their clusters.
#include "renderer/ibl/suns.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "renderer/base/check.hpp"

namespace furnace {

namespace {

using Rgb = std::array<double, 3>;

constexpr double kPi = std::numbers::pi;
// Clusters above s F / W hold F at most, so that of those with a share of 0.1 there are ten; the others may be noise.
constexpr std::size_t kMostClusters = 16;
// Width of the ring that stands for a sun's surroundings, of its radius (so that finer maps give the same suns), and in
// texels: one that the sun's blurred edge may touch and one beyond.
constexpr double kRingWidth = 0.25;
constexpr int kFewestRingTexels = 2;
constexpr int kRowsAtOnce = 64;  // between two looks at the clock

double luminance(const Rgb& value) {  // ITU-R BT.709-6 2015, "Parameter values for the HDTV standards"
  return 0.2126 * value[0] + 0.7152 * value[1] + 0.0722 * value[2];
}

Rgb normalised(const Rgb& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

using Replaced = std::unordered_map<std::size_t, std::array<float, 3>>;

// The texels of a map as neighbours on the sphere, some of them replaced. Texels are numbered row by row.
class Sphere {
 public:
  explicit Sphere(const Image& map)
      : width_(map.extent.width), height_(map.extent.height), texels_(map.samples<float>().data()) {
    for (int j = 0; j < height_; ++j)
      areas_.push_back(4 * kPi / width_ * std::sin(kPi / (2 * height_)) *
                       std::sin(kPi * (j + 0.5) / height_));
  }

  std::size_t size() const { return std::size_t(width_) * height_; }
  double row_rad() const { return kPi / height_; }
  double area(std::size_t k) const { return areas_[k / width_]; }  // sr
  Rgb value(std::size_t k) const {
    const float* p = texels_ + 3 * k;
    if (!replaced_.empty()) {
      if (const auto found = replaced_.find(k); found != replaced_.end()) p = found->second.data();
    }
    return {p[0], p[1], p[2]};
  }
  void replace(std::size_t k, const std::array<float, 3>& value) { replaced_[k] = value; }
  const Replaced& replaced() const { return replaced_; }

  // The map's flux, and what tells the rows that hold a bright texel from the others.
  struct Flux {
    double sum = 0;
    std::vector<double> brightest;  // luminance, by row
  };
  Flux flux(const Deadline& deadline) const {
    Flux flux;
    for (int j = 0; j < height_; ++j) {
      if (j % kRowsAtOnce == 0) check_deadline(deadline, "environment: suns");
      const float* row = texels_ + 3 * std::size_t(j) * width_;
      double sum = 0, brightest = 0;
      for (int i = 0; i < width_; ++i) {
        const double value = luminance({row[3 * i], row[3 * i + 1], row[3 * i + 2]});
        sum += value;
        brightest = std::max(brightest, value);
      }
      flux.sum += sum * areas_[j];
      flux.brightest.push_back(brightest);
    }
    return flux;
  }
  int width() const { return width_; }
  double luminance_of(std::size_t k) const { return luminance(value(k)); }
  Rgb direction(std::size_t k) const {
    const double theta = kPi * (k / width_ + 0.5) / height_;
    const double phi = 2 * kPi * ((k % width_ + 0.5) / width_ - 0.5);
    return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
  }
  // Mean square distance (rad^2) of a texel's points from its centre.
  double spread(std::size_t k) const {
    const double high = kPi / height_, wide = 2 * kPi / width_ * std::sin(kPi * (k / width_ + 0.5) / height_);
    return (high * high + wide * wide) / 12;
  }

  // The eight around it, periodic in u; over a pole lie the texels half a turn away.
  template <class Visit>
  void neighbours(std::size_t k, Visit&& visit) const {
    const int i = static_cast<int>(k % width_), j = static_cast<int>(k / width_);
    for (int dj = -1; dj <= 1; ++dj) {
      const bool over = j + dj < 0 || j + dj >= height_;
      const int row = over ? j : j + dj;
      for (int di = -1; di <= 1; ++di) {
        if (di == 0 && dj == 0) continue;
        visit(std::size_t(row) * width_ + (i + di + width_ + (over ? width_ / 2 : 0)) % width_);
      }
    }
  }

 private:
  int width_ = 0;
  int height_ = 0;
  const float* texels_ = nullptr;
  Replaced replaced_;
  std::vector<double> areas_;
};

// Texels in the order in which they are reached from the first ones.
// Threads: one. Owns: a mark for each texel, all clear between calls.
class Clusters {
 public:
  explicit Clusters(const Sphere& sphere) : sphere_(sphere), marks_(sphere.size()) {}

  // Connected texels of at least `level` around `seed`; nothing when they take more than `largest_sr`.
  std::optional<std::vector<std::size_t>> grow(std::size_t seed, double level, double largest_sr) {
    std::vector<std::size_t> found = {seed};
    marks_[seed] = true;
    double area = 0;
    bool fits = true;
    for (std::size_t next = 0; fits && next < found.size(); ++next) {
      area += sphere_.area(found[next]);
      fits = area <= largest_sr;
      sphere_.neighbours(found[next], [&](std::size_t k) {
        if (marks_[k] || sphere_.luminance_of(k) < level) return;
        marks_[k] = true;
        found.push_back(k);
      });
    }
    clear(found);
    if (!fits) return std::nullopt;
    return found;
  }

  // What lies around a cluster.
  std::vector<std::size_t> ring(const std::vector<std::size_t>& cluster) {
    std::vector<std::size_t> reached = cluster;
    double area = 0;
    for (std::size_t k : cluster) marks_[k] = true, area += sphere_.area(k);
    const double radius_texels = std::sqrt(area / kPi) / sphere_.row_rad();
    const int steps = std::max(kFewestRingTexels, static_cast<int>(std::lround(kRingWidth * radius_texels)));
    std::size_t first = 0;
    for (int step = 0; step < steps; ++step) {
      const std::size_t last = reached.size();
      for (std::size_t next = first; next < last; ++next) {
        sphere_.neighbours(reached[next], [&](std::size_t k) {
          if (marks_[k]) return;
          marks_[k] = true;
          reached.push_back(k);
        });
      }
      first = last;
    }
    clear(reached);
    return {reached.begin() + cluster.size(), reached.end()};
  }

  // All clusters of at least `level`, those of the largest flux first.
  struct Core {
    std::vector<std::size_t> texels;
    double flux = 0;
  };
  std::vector<Core> cores(double level, const std::vector<double>& brightest) {
    std::vector<Core> cores;
    std::vector<bool> seen(sphere_.size());
    const std::size_t width = sphere_.width();
    for (std::size_t seed = 0; seed < sphere_.size(); ++seed) {
      if (seed % width == 0 && brightest[seed / width] < level) {
        seed += width - 1;
        continue;
      }
      if (seen[seed] || sphere_.luminance_of(seed) < level) continue;
      Core core{*grow(seed, level, 4 * kPi + 1), 0};
      for (std::size_t k : core.texels) {
        seen[k] = true;
        core.flux += sphere_.luminance_of(k) * sphere_.area(k);
      }
      cores.push_back(std::move(core));
    }
    std::stable_sort(cores.begin(), cores.end(),
                     [](const Core& a, const Core& b) { return a.flux > b.flux; });
    if (cores.size() > kMostClusters) cores.resize(kMostClusters);
    return cores;
  }

 private:
  void clear(const std::vector<std::size_t>& marked) {
    for (std::size_t k : marked) marks_[k] = false;
  }

  const Sphere& sphere_;
  std::vector<bool> marks_;
};

// Shepard 1968, "A two-dimensional interpolation function for irregularly-spaced data": the ring's texels weighted by
// 1 / distance^2, and by their areas, which shrink towards a pole. Never above the map, so that a sun takes no light away.
std::vector<std::array<float, 3>> surroundings(const Sphere& sphere, const std::vector<std::size_t>& cluster,
                                               const std::vector<std::size_t>& ring) {
  std::vector<Rgb> directions;
  for (std::size_t k : ring) directions.push_back(sphere.direction(k));
  std::vector<std::array<float, 3>> fill;
  for (std::size_t k : cluster) {
    const Rgb d = sphere.direction(k), own = sphere.value(k);
    Rgb sum{};
    double weights = 0;
    for (std::size_t r = 0; r < ring.size(); ++r) {
      const Rgb& e = directions[r];
      const double x = d[0] - e[0], y = d[1] - e[1], z = d[2] - e[2];
      const double weight = sphere.area(ring[r]) / (x * x + y * y + z * z);
      const Rgb value = sphere.value(ring[r]);
      for (int c = 0; c < 3; ++c) sum[c] += weight * value[c];
      weights += weight;
    }
    auto& out = fill.emplace_back();
    for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(std::min(own[c], sum[c] / weights));
  }
  return fill;
}

double mean_luminance(const Sphere& sphere, const std::vector<std::size_t>& texels) {
  double sum = 0, area = 0;
  for (std::size_t k : texels) sum += sphere.luminance_of(k) * sphere.area(k), area += sphere.area(k);
  return area > 0 ? sum / area : 0;
}

struct Candidate {
  std::vector<std::size_t> texels;
  std::vector<std::array<float, 3>> fill;  // what replaces them
  Sun sun;
};

Candidate measure(const Sphere& sphere, std::vector<std::size_t> texels,
                  const std::vector<std::size_t>& ring) {
  Candidate candidate{std::move(texels), {}, {}};
  candidate.fill = surroundings(sphere, candidate.texels, ring);
  Sun& sun = candidate.sun;
  Rgb centroid{};
  const auto flux_of = [&](std::size_t n) {
    const std::size_t k = candidate.texels[n];
    Rgb flux = sphere.value(k);
    for (int c = 0; c < 3; ++c) flux[c] = (flux[c] - candidate.fill[n][c]) * sphere.area(k);
    return flux;
  };
  for (std::size_t n = 0; n < candidate.texels.size(); ++n) {
    const std::size_t k = candidate.texels[n];
    const Rgb flux = flux_of(n), d = sphere.direction(k), value = sphere.value(k);
    for (int c = 0; c < 3; ++c) {
      sun.irradiance[c] += flux[c];
      sun.peak = std::max(sun.peak, value[c]);
      centroid[c] += luminance(flux) * d[c];
    }
    sun.solid_angle_sr += sphere.area(k);
  }
  const double total = luminance(sun.irradiance);
  if (total <= 0) return candidate;
  sun.direction = normalised(centroid);
  double moment = 0;  // rad^2, of the squared chord: sin^2 instead of an angle's cancellation
  for (std::size_t n = 0; n < candidate.texels.size(); ++n) {
    const Rgb d = sphere.direction(candidate.texels[n]);
    const double x = d[0] - sun.direction[0], y = d[1] - sun.direction[1], z = d[2] - sun.direction[2];
    moment += luminance(flux_of(n)) * (x * x + y * y + z * z + sphere.spread(candidate.texels[n]));
  }
  sun.angular_radius_rad = std::sqrt(2 * moment / total);  // of an even disc the moment is radius^2 / 2
  return candidate;
}

// The faintest edge at which the cluster around `seed` is a sun.
std::optional<Candidate> find_sun(const Sphere& sphere, Clusters& clusters, std::size_t seed, double map_flux,
                                  const SunSettings& settings) {
  const double peak = sphere.luminance_of(seed);
  const double largest_sr = 4 * kPi * std::pow(std::sin(settings.largest_radius_rad / 2), 2);
  for (double edge = settings.faintest_edge; edge < 1; edge *= 2) {
    auto texels = clusters.grow(seed, edge * peak, largest_sr);
    if (!texels) continue;
    const std::vector<std::size_t> ring = clusters.ring(*texels);
    if (ring.empty()) continue;  // a map of a few texels
    double area = 0, brightest = 0;
    for (std::size_t k : *texels) {
      area += sphere.area(k);
      brightest = std::max(brightest, sphere.luminance_of(k));
    }
    const double inside = mean_luminance(sphere, *texels);
    if (inside * area < settings.smallest_share * map_flux) return std::nullopt;  // nor will less of it
    if (brightest > peak) continue;  // the glare of something else
    if (inside < settings.smallest_contrast * mean_luminance(sphere, ring)) continue;
    Candidate candidate = measure(sphere, std::move(*texels), ring);
    // A tube light is small in area, but not round.
    if (luminance(candidate.sun.irradiance) >= settings.smallest_share * map_flux &&
        candidate.sun.angular_radius_rad <= settings.largest_radius_rad)
      return candidate;
  }
  return std::nullopt;
}

// Replaces in `sphere` what it finds.
std::vector<Sun> take_suns(Sphere& sphere, const Deadline& deadline, const SunSettings& settings) {
  std::vector<Sun> suns;
  const Sphere::Flux flux = sphere.flux(deadline);
  if (flux.sum <= 0) return suns;
  Clusters clusters(sphere);
  const double largest_sr = 4 * kPi * std::pow(std::sin(settings.largest_radius_rad / 2), 2);
  const double level = settings.smallest_share * flux.sum / largest_sr;
  for (const Clusters::Core& core : clusters.cores(level, flux.brightest)) {
    check_deadline(deadline, "environment: suns");
    if (static_cast<int>(suns.size()) == settings.most) break;
    // A sun that was taken out before may have reached into this cluster: its brightest texel is sought now.
    const std::size_t seed = *std::max_element(
        core.texels.begin(), core.texels.end(),
        [&](std::size_t a, std::size_t b) { return sphere.luminance_of(a) < sphere.luminance_of(b); });
    const std::optional<Candidate> found = find_sun(sphere, clusters, seed, flux.sum, settings);
    if (!found) continue;
    for (std::size_t n = 0; n < found->texels.size(); ++n) sphere.replace(found->texels[n], found->fill[n]);
    suns.push_back(found->sun);
  }
  std::stable_sort(suns.begin(), suns.end(), [](const Sun& a, const Sun& b) {
    return luminance(a.irradiance) > luminance(b.irradiance);
  });
  return suns;
}

Sphere sphere_of(const Image& equirect) {
  FURNACE_CHECK(equirect.channels == 3 && equirect.type == SampleType::kFloat32 &&
                    equirect.extent.width == 2 * equirect.extent.height,
                "not an RGB kFloat32 equirect: {} x {}", equirect.extent.width, equirect.extent.height);
  return Sphere(equirect);
}

}  // namespace

std::vector<Sun> find_suns(const Image& equirect, const Deadline& deadline, const SunSettings& settings) {
  Sphere sphere = sphere_of(equirect);
  return take_suns(sphere, deadline, settings);
}

SunExtraction extract_suns(const Image& equirect, const Deadline& deadline, const SunSettings& settings) {
  Sphere sphere = sphere_of(equirect);
  SunExtraction result{take_suns(sphere, deadline, settings), equirect};
  for (const auto& [k, value] : sphere.replaced())
    std::copy(value.begin(), value.end(), result.residual.samples<float>().data() + 3 * k);
  return result;
}

}  // namespace furnace
