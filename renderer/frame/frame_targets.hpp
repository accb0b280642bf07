// The render targets of a frame's tiles, kept from frame to frame while their shape stays.
#pragma once

#include <optional>
#include <vector>

#include "renderer/base/content_hash.hpp"
#include "renderer/frame/frame_plan.hpp"
#include "renderer/gl/texture.hpp"

namespace furnace {

// What sees the scene: 2x2 samples a pixel.
struct VisibilityTarget {
  gl::Texture texels;  // RG32UI, see shaders/lib/visibility.glsl
  gl::Texture depth;
  gl::Framebuffer framebuffer;
};

// Where it is shaded: once a pixel and surface.
struct ShadingTarget {
  gl::Texture shares;     // R16UI, see shaders/lib/visibility.glsl
  gl::Texture selection;  // depth: the draw that is shaded here
  gl::Texture color;      // RGBA32F, premultiplied: one sub-frame
  gl::Framebuffer share, select, shade;
};

// Blended surfaces, lines and points, premultiplied: 2x2 samples a pixel, over the depth of what is visible.
struct VeilTarget {
  gl::Texture color;   // RGBA16F, exposed: 1 is white, so that half floats serve every light
  gl::Texture pixels;  // RGBA32UI, of one sub-frame: see shaders/lib/veil.glsl
  gl::Framebuffer framebuffer, gather;
};

// What lights see: a map each view.
struct ShadowTarget {
  int side_px = 0, views = 0;
  gl::Texture maps;  // depth, an array; compared when it is sampled
  gl::Framebuffer framebuffer;
};

struct ColorTarget {
  gl::Texture color;
  gl::Framebuffer framebuffer;
};

// What stands behind transmissive surfaces: the whole picture, premultiplied, mipmapped.
struct BackdropTarget {
  Extent size;
  gl::Texture color;  // RGBA32F
};

// Threads: the context's. Owns: its textures and framebuffers.
struct FrameTargets {
  Extent size;
  SampleType film_type = SampleType::kUint8;

  VisibilityTarget visibility;
  ShadingTarget shading;
  std::optional<ContentHash> seen;  // visibility_key() of what visibility and shares hold, where it is known
  std::optional<VeilTarget> veil;   // only for scenes that need it
  std::optional<ShadowTarget> shadows;     // only for scenes with lights that cast some
  std::optional<ColorTarget> accumulated;  // RGBA32F: the mean of several sub-frames
  std::optional<BackdropTarget> backdrop;  // only for scenes with transmissive surfaces
  std::optional<ColorTarget> emission;     // RGBA32F: the mean of what the surfaces emit, for bloom
  std::optional<ColorTarget> lobes;        // RGBA32F: of sub-frames that the filter takes away
  std::optional<ColorTarget> behind;       // RGBA32F: of one sub-frame, on its way to the backdrop
  std::vector<ColorTarget> layers;         // RGBA32F: LayerPlan::sources
  ColorTarget film;                        // what is read back
};

struct TargetNeeds {
  bool veil = false, accumulated = false, emission = false, lobes = false, behind = false;
  std::size_t layers = 0;
};

// Makes a shadow target of at least so many views and of this side; what fits is kept. `targets` is provided.
void provide_shadows(gl::Context& context, int side_px, int views, FrameTargets& targets);

// Makes a backdrop of this size; one of the same is kept. `targets` is provided.
void provide_backdrop(gl::Context& context, Extent size, FrameTargets& targets);

// Makes what `targets` lacks for the plan; what fits is kept.
void provide_targets(gl::Context& context, const FramePlan& plan, TargetNeeds needs,
                     std::optional<FrameTargets>& targets);

}  // namespace furnace
