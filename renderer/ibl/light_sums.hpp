// What a number of directions sheds on a lobe that looks anywhere: the whole of which the scene hides a part.
#pragma once

#include "renderer/base/worker_pool.hpp"
#include "renderer/ibl/light_directions.hpp"

namespace furnace {

struct LightSums {
  double least_alpha = 0;  // of the first GGX lobe: a narrower one would fall between the directions
  // RGBA kFloat32, octahedral maps of (u, v) from corner texel to corner texel, one below the other: sums of irradiance (RGB) and
  // of solid angle (A), in the first times the cosine to the map's direction, in the others times ggx_lobe(), over its integral,
  // of alphas from `least_alpha` to 1 in equal ratios.
  Image maps;
};

// The kernel of the prefiltered GGX levels (prefiltering under n = v = r: Karis 2013, "Real Shading in Unreal Engine 4") but for a
// factor that makes it 1 in its middle; `cosine`: to where the lobe looks. The same lines stand in
// shaders/surface/environment_visibility.glsl.
double ggx_lobe(double cosine, double alpha);

// Of it over the sphere, `alpha` in (0, 1].
double ggx_lobe_integral_sr(double alpha);

// `lights` shine from the whole sphere, some; `levels`: GGX lobes. The same for any pool. Threads: any.
LightSums light_sums(const std::vector<LightDirection>& lights, int side_px, int levels, WorkerPool& pool);

}  // namespace furnace
