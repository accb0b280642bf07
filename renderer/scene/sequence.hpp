// A sequence as single pictures: each frame a request of its own, and what must not jump from one to the next held still.
#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/render_spec.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// What a frame needs to be seen.
struct FrameOutline {
  Bounds bounds;  // m, world; of an empty scene the unit cube
  std::vector<glm::dvec2> x_z,
      y_z;  // m, corners of the vertices' convex hulls, in the axes of an orbit camera
};

// Errors: kUnprocessable at /camera for a vertex that is infinite or not a number.
FrameOutline outline_of(const Scene& scene, const CameraSpec& camera);

// Of the clips that `scene` plays, s; 0 without any that `animations`, those of its model, list.
double longest_clip_s(const SceneSpec& scene, std::span<const SceneAnimation> animations);

// At least 2. `sequence.frames`, else as many as a clip of that length has.
int frame_count(const Sequence& sequence, double longest_clip_s);

// The frames as requests without a sequence. `spec` passes sequence_fault.
std::vector<RenderSpec> frames_of(const RenderSpec& spec, int count);

// Whether a frame alone would choose its camera's place, its ground's level or its focus otherwise than its neighbours.
bool needs_outlines(const RenderSpec& spec);

// Gives the frames of `spec` one distance and height of an orbiting eye, which sees every frame whole and goes round the middle
// of all that is ever seen, one level of the ground and one point of focus. `outlines`: one of each frame.
void hold_still(const RenderSpec& spec, std::span<const FrameOutline> outlines,
                std::vector<RenderSpec>& frames);

}  // namespace furnace
