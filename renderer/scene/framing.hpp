// A camera for a scene: explicit, from the file, or framed on the exact bounds.
#pragma once

#include "renderer/scene/lens.hpp"
#include "renderer/scene/render_spec.hpp"
#include "renderer/scene/scene.hpp"
#include "renderer/scene/tight_framing.hpp"

namespace furnace {

// What the frame needs of a camera.
struct View {
  glm::mat4 view_from_world{1};
  glm::mat4 clip_from_view{1};  // reversed depth, see transform.hpp
  glm::vec3 eye{0};             // m, world
  bool orthographic = false;
  Lens lens = {};
};

double aspect_of(Extent picture);

// Of the camera in the world: columns right, up, back; and of the planes that bound what it must see.
glm::dmat3 orbit_axes(const OrbitCamera& orbit);
Slopes orbit_slopes(const OrbitCamera& orbit, double aspect);

// Orbit: the nearest eye from which every vertex of the scene (not of its box or sphere) lies in the frame
// divided by `fit`, the projected model centred in the picture; an empty scene is framed as the unit cube.
// The eye keeps 1/1000 of the scene's size from the nearest vertex, whatever the angle of view. GltfCamera:
// yfov (or ymag) is kept when the picture is wider than the camera's own frame; a narrower picture keeps xfov
// (xmag) instead, so that the author's frame is always seen whole. The file's near and far planes hold; node
// scale does not count (glTF 2.0, section 3.10.2). Otherwise the near plane scales with the scene and the far
// plane lies at infinity. Errors: kUnprocessable with a pointer under "/camera" (no such glTF camera, eye =
// target, a vertex that is infinite or not a number, a lens that cannot be).
View make_view(const CameraSpec& camera, const Scene& scene, Extent picture);

// What is seen from a place of the lens (m right and up of its middle): the eye moves there, and the frustum is sheared so that
// the plane of focus stays where it is.
View through_lens(const View& view, glm::dvec2 place_m);

}  // namespace furnace
