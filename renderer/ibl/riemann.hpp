// Irradiance by sums over the hemisphere: slower than the bake and built on nothing of it, so that each judges the other.
#pragma once

#include <array>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/image/image.hpp"

namespace furnace {

// Solid angle (sr) of the spherical triangle of three unit vectors less than half a turn apart, >= 0.
double spherical_triangle_area(const std::array<double, 3>& a, const std::array<double, 3>& b,
                               const std::array<double, 3>& c);

// Solid angles (sr) of the quadrilaterals between equally spaced meridians and parallels of a hemisphere, one for each of
// the quads.height rings from the pole to the rim; the quads.width of a ring are equal. Their edges are great circles, so
// together they are 2 pi.
std::vector<double> hemisphere_quad_areas(Extent quads);

// Irradiance / pi on 2 rows x rows texels (RGB kFloat32, the equirect convention of baked_environment.hpp), in the unit of
// the map: sums over `quads` (azimuths x polar angles, >= 3 x 1; 256 x 128 keeps 2e-3) around each direction.
// Nothing is normalised: a constant map of 1 gives the sum of area cos / pi, which is 1 within 2e-5 at 256 x 128.
// `equirect`: RGB kFloat32, finite, >= 0. The result does not depend on the number of threads.
// Errors: kDeadlineExceeded between rows, kTooLarge as make_image. Threads: any.
Image riemann_irradiance(const Image& equirect, Extent quads, int rows, WorkerPool& pool,
                         const Deadline& deadline);

}  // namespace furnace
