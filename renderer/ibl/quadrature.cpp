#include "renderer/ibl/quadrature.hpp"

#include <cmath>
#include <numbers>

namespace furnace {

// Newton's method on P_n from Tricomi's estimate of its roots; weight 2 / ((1 - x^2) P_n'(x)^2)
// (Abramowitz and Stegun 1964, "Handbook of Mathematical Functions", 25.4.29).
std::vector<QuadratureNode> gauss_legendre(int count, double a, double b) {
  std::vector<QuadratureNode> nodes(count);
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    double derivative = 0;
    for (int step = 0; step < 8; ++step) {
      double p = 1, before = 0;
      for (int l = 1; l <= count; ++l) {
        const double next = ((2 * l - 1) * x * p - (l - 1) * before) / l;
        before = p;
        p = next;
      }
      derivative = count * (x * p - before) / (x * x - 1);
      const double change = p / derivative;
      x -= change;
      if (std::abs(change) < 1e-15) break;
    }
    const double weight = 2 / ((1 - x * x) * derivative * derivative);
    nodes[count - 1 - i] = {0.5 * (a + b) + 0.5 * (b - a) * x, 0.5 * (b - a) * weight};
  }
  return nodes;
}

}  // namespace furnace
