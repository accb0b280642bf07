// Photometric files of luminaires: how bright they are towards each side.
#pragma once

#include <string_view>
#include <vector>

#include "renderer/base/content_hash.hpp"

namespace furnace {

// Angles as of type C photometry, rad: vertical from the luminaire's axis (0, where it points; pi behind it), horizontal about
// it (0 along its x axis, turning towards y). Threads: immutable once read.
struct LightProfile {
  ContentHash hash;                // of the file
  std::vector<double> vertical;    // ascending, 2 or more
  std::vector<double> horizontal;  // ascending; one: the same all round
  std::vector<double> candela;     // [horizontal][vertical]
  double peak_candela = 0;         // > 0
  double flux_lumen = 0;           // over all sides

  // Linear between the file's angles; 0 beyond its vertical ones.
  double candela_towards(double vertical_rad, double horizontal_rad) const;
};

struct ProfileLimits {
  int max_angles = 100000;  // vertical times horizontal
};

// ANSI/IES LM-63 (1986 to 2019), type C and B photometry, TILT=NONE or INCLUDE (which is of no effect: no light is turned from the
// position it was measured in). Errors: kUnprocessable, saying which line is wrong.
LightProfile parse_ies(std::string_view text, const ProfileLimits& limits = {});

}  // namespace furnace
