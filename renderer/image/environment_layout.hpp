// How the picture of an environment lies in its file, and cubes as equirects.
#pragma once

#include <cstdint>
#include <string_view>

#include "renderer/image/image.hpp"

namespace furnace {

// The faces of a cube as OpenGL looks them up: texel (s, t) of a face, t downwards, holds what is seen in the direction that its
// table gives (OpenGL 4.6 core profile, table 8.19 "Selection of cube map images"):
//
//   +X (1, -b, -a)   -X (-1, -b, a)   +Y (a, 1, b)   -Y (a, -1, -b)   +Z (a, -b, 1)   -Z (-a, -b, -1)
//
// with a = 2 s - 1, b = 2 t - 1. Strips have them in that order. Crosses are folded so that what lies side by side is side by
// side:
//
//         +Y                      +Y
//     -X  +Z  +X  -Z          -X  +Z  +X
//         -Y                      -Y
//                                 -Z, upside down
enum class EnvironmentLayout : std::uint8_t {
  kAuto,             // told by the aspect ratio
  kEquirect,         // 2:1
  kHorizontalCross,  // 4:3
  kVerticalCross,    // 3:4
  kHorizontalStrip,  // 6:1
  kVerticalStrip,    // 1:6
};
inline constexpr EnvironmentLayout kLastEnvironmentLayout = EnvironmentLayout::kVerticalStrip;

std::string_view name_of(EnvironmentLayout layout);  // "auto", "horizontal-cross", ...

// Which of them a picture of that size has; `asked` itself unless that is kAuto, kAuto when there is none.
EnvironmentLayout layout_of(std::int64_t width, std::int64_t height, EnvironmentLayout asked);

// The side of a face. `layout` is that of a cube.
int face_side(const Extent& picture, EnvironmentLayout layout);

// RGB kFloat32, of a cross: makes black what is no face, whatever a program left there.
void clear_beside_faces(Image& picture, EnvironmentLayout layout);

// RGB kFloat32 picture of a cube -> RGB kFloat32 equirect (the convention of ibl/baked_environment.hpp), four faces wide. Each
// texel is the mean over its solid angle of the cube, which is constant over each of its own texels: no light is lost or made
// (to 1e-3), a constant stays the same, and faces meet without a seam. Errors: kTooLarge as make_image. Threads: any.
Image equirect_of_cube(const Image& picture, EnvironmentLayout layout);

}  // namespace furnace
