// The outlines of lights that are surfaces, whole or cut into equal parts.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/scene/light.hpp"

namespace furnace {

// Corners, convex, counter-clockwise.
using LightPolygon = std::vector<glm::dvec2>;

inline constexpr int kMostCorners = int(gpu::DISC_CORNERS) + 4;  // of one part

// In m on the axes of the light; of a sphere the disc through its middle. A disc is a polygon as large as it.
LightPolygon outline_of(const Light& light);

// Part `index` of `count` parts of equal area, all convex and as compact as strips allow; they cover the polygon without overlap.
LightPolygon equal_part(const LightPolygon& polygon, int count, int index);

glm::dvec2 centroid(const LightPolygon& polygon);
double area(const LightPolygon& polygon);

}  // namespace furnace
