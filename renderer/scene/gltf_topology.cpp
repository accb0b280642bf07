#include "renderer/scene/gltf_topology.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace furnace {

namespace {

enum Mode { kPointList, kLineList, kLineLoop, kLineStrip, kTriangleList, kTriangleStrip, kTriangleFan };

class ElementWriter {
 public:
  explicit ElementWriter(std::uint64_t corners) { indices_.reserve(corners); }

  void line(std::uint32_t a, std::uint32_t b) {
    if (a == b) return;
    indices_.insert(indices_.end(), {a, b});
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a == b || b == c || c == a) return;
    indices_.insert(indices_.end(), {a, b, c});
  }
  std::vector<std::uint32_t> take() { return std::move(indices_); }

 private:
  std::vector<std::uint32_t> indices_;
};

}  // namespace

Topology topology_of(int mode) {
  if (mode == kPointList) return Topology::kPoints;
  return is_triangle_mode(mode) ? Topology::kTriangles : Topology::kLines;
}

bool is_triangle_mode(int mode) {
  return mode >= kTriangleList;
}

std::uint64_t element_count(int mode, std::uint64_t indices) {
  switch (mode) {
    case kPointList:
      return indices;
    case kLineList:
      return indices / 2;
    case kLineLoop:
      return indices < 2 ? 0 : indices;
    case kLineStrip:
      return indices < 2 ? 0 : indices - 1;
    case kTriangleList:
      return indices / 3;
    default:
      return indices < 3 ? 0 : indices - 2;
  }
}

bool has_left_over(int mode, std::uint64_t indices) {
  return (mode == kLineList && indices % 2 != 0) || (mode == kTriangleList && indices % 3 != 0);
}

std::vector<std::uint32_t> expand_topology(int mode, std::vector<std::uint32_t> indices) {
  if (mode == kPointList) return indices;
  const auto count = static_cast<std::size_t>(element_count(mode, indices.size()));
  const std::vector<std::uint32_t>& v = indices;
  ElementWriter out(count * (is_triangle_mode(mode) ? 3 : 2));
  for (std::size_t i = 0; i < count; ++i) {
    switch (mode) {
      case kLineList:
        out.line(v[2 * i], v[2 * i + 1]);
        break;
      case kLineLoop:
        out.line(v[i], v[(i + 1) % v.size()]);
        break;
      case kLineStrip:
        out.line(v[i], v[i + 1]);
        break;
      case kTriangleList:
        out.triangle(v[3 * i], v[3 * i + 1], v[3 * i + 2]);
        break;
      case kTriangleStrip:
        out.triangle(v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]);
        break;
      default:
        out.triangle(v[i + 1], v[i + 2], v[0]);
        break;
    }
  }
  return out.take();
}

}  // namespace furnace
