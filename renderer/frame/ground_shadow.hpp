// What the scene keeps from the ground: the environment's light, from many directions, each with its own hard shadow.
#pragma once

#include "renderer/base/deadline.hpp"
#include "renderer/gl/program.hpp"
#include "renderer/residency/draw_list.hpp"

namespace furnace {

// The part of the ground that is worth a map: under the scene and where nearly all of its shadow falls, with room to fade
// out. A sun near the horizon is followed so far only. `ground.light` is not null. Pure. Threads: any.
GroundRectangle ground_rectangle(const PreparedGround& ground);

// Exact for the directions given. Opaque, masked and blended triangles cast; lines and points do not.
// Errors: kDeadlineExceeded; kGpuUnavailable when memory is out. Threads: the context's.
GpuGroundShadow draw_ground_shadow(gl::Context& context, gl::ProgramCache& programs, Residency& residency,
                                   const GpuScene& scene, const PreparedGround& ground,
                                   const gl::VertexArray& empty_vertex_array, const Deadline& deadline);

}  // namespace furnace
