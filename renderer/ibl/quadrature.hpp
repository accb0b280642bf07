// Gauss-Legendre nodes, for the tables that are integrated rather than sampled.
#pragma once

#include <vector>

namespace furnace {

struct QuadratureNode {
  double x = 0;
  double weight = 0;
};

// `count` nodes on [a, b]; exact for polynomials of degree 2 count - 1. Threads: any.
std::vector<QuadratureNode> gauss_legendre(int count, double a, double b);

}  // namespace furnace
