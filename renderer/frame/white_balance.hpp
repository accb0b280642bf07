// White balance: a light's colour becomes white.
#pragma once

#include <glm/glm.hpp>

namespace furnace {

// CIE 1931 (x, y) of the light of `kelvin` in [1667, 25000], moved by `tint` / 3000 in CIE 1960 (u, v) at a right angle to the
// locus: positive towards green, so that pictures turn to magenta.
glm::dvec2 white_chromaticity(double kelvin, double tint);

// CIE XYZ under a white at `from` (x, y) -> XYZ that looks alike under a white at `to`.
glm::dmat3 adaptation(glm::dvec2 from, glm::dvec2 to);

// Linear Rec.709: what the light of `kelvin` and `tint` shows as white comes out as white, of the same luminance.
// The identity, but for rounding, at 6504 K, which is D65.
glm::dmat3 white_balance(double kelvin, double tint);

}  // namespace furnace
