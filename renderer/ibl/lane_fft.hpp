// Eight Fourier transforms at a time, one per lane.
#pragma once

#include <vector>

#include "renderer/ibl/lanes.hpp"

namespace furnace {

struct ComplexLanes {
  Lanes re, im;
};

// X_k = sum over i of x_i e^(-2 pi i k / n), for any n (fast when its prime factors are small).
// Threads: transform is const, each caller with its own arrays. Owns: its twiddle factors.
class LaneFft {
 public:
  explicit LaneFft(int n);

  int size() const { return n_; }

  // In place; `work` holds n. For the inverse (unscaled) exchange `re` and `im` before and after.
  void transform(ComplexLanes* values, ComplexLanes* work) const;

 private:
  struct Stage {
    int radix = 0;
    int groups = 0;  // transforms of this length are split into `radix` of `groups` elements
    int stride = 0;
    std::vector<double> cos, sin;            // e^(-i angle) of group p, output j at [p * (radix - 1) + j - 1]
    std::vector<double> root_cos, root_sin;  // e^(-2 pi i j / radix), for radices without their own butterfly
  };

  int n_ = 0;
  std::vector<Stage> stages_;
};

}  // namespace furnace
