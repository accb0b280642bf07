// An environment out of focus, for a background that does not compete with what stands before it.
#pragma once

#include "renderer/base/deadline.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/image/image.hpp"

namespace furnace {

// `radiance` (RGB kFloat32 equirect 2:1, finite, >= 0, constant over each texel) convolved over the whole sphere with the
// von Mises-Fisher density of concentration 1 / sigma^2 (Fisher 1953, "Dispersion on a sphere"; Mardia and Jupp 2000,
// "Directional Statistics", 9.3.2), 0 <= sigma <= pi rad. RGB kFloat32 equirect, sampled at its texel centres: on a grid
// that bicubic reading follows within 1e-3, at most that of `radiance`.
// The result does not depend on the pool. Errors: kDeadlineExceeded, kTooLarge as make_image. Threads: any.
Image blurred_environment(const Image& radiance, double sigma_rad, WorkerPool& pool,
                          const Deadline& deadline);

}  // namespace furnace
