// A scene that moves while the shutter is open: at which moments it is looked at, and which sub-frame sees which of them.
// Cook, Porter, Carpenter 1984, "Distributed Ray Tracing": times are spread as places in the pixel and of the lens are.
#pragma once

#include <span>
#include <vector>

#include "renderer/scene/framing.hpp"
#include "renderer/scene/render_spec.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// Each moment is a scene of its own in memory; with so many an edge that moves by as many pixels still leaves no steps.
inline constexpr int kMostMoments = 64;

// Whether anything can: the scene's clips or the camera.
bool moves(const RenderSpec& spec);

// 0 where nothing moves or a single sub-frame sees one instant.
int moments_wanted(const RenderSpec& spec);

// Of each sub-frame the moment that it sees, [0, moments): all about equally often, in an order that keeps to no order of
// pixel, lens or light. 1 <= moments.
std::vector<int> moment_of_subframes(int subframes, int moments);

// Of each moment its time, s from the shutter's middle: where those of its sub-frames have their mean, if each of them had an
// equal part of the shutter for itself. moments <= subframes.
std::vector<double> moment_offsets_s(int subframes, int moments, double shutter_s);

// The same with all its clips so much later.
SceneSpec scene_at(SceneSpec scene, double offset_s);

// What the camera sees then.
View view_at(const View& view, const CameraMotion& motion, double offset_s);

// `scene` with all that is anywhere else at other moments as well, to frame them together: cameras are those of `scene`.
Scene swept_scene(Scene scene, std::span<const Scene* const> moments);

}  // namespace furnace
