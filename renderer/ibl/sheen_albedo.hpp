// Directional albedo of the lobe of fibres, by quadrature; depends on no environment.
#pragma once

namespace furnace {

// Rougher than this a lobe is taken; below, it is a line at the horizon (KHR_materials_sheen's renderers do likewise).
inline constexpr double kLeastSheenRoughness = 0.1;

// Of a white fibre seen under `cos_v` in (0, 1]: the integral of D V (n.l) over l with D and V of Estevez and Kulla 2017,
// "Production Friendly Microfacet Sheen BRDF"; at most 1. Absolute error <= 1e-4. Threads: any; deterministic.
double sheen_albedo(double cos_v, double perceptual_roughness);

}  // namespace furnace
