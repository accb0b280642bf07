#include "renderer/scene/meshopt_decode.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include <meshoptimizer.h>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "renderer/scene/meshopt_attributes.hpp"

namespace furnace {

namespace {

// A byte of the densest code, the control byte of four bytes that never change, stands for 256 times as many.
constexpr std::uint64_t kMostExpansion = 1024;

[[noreturn]] void fail_damaged() {
  fail(ErrorCode::kUnprocessable, "the meshopt data are damaged");
}

// The appendix "Filters" of KHR_meshopt_compression: YCoCg, K bits of precision by the highest bit of the fourth.
template <class T>
void undo_color_filter(std::span<std::byte> bytes) {
  using Signed = std::make_signed_t<T>;
  constexpr float kMost = float(T(~T(0)));
  for (std::size_t at = 0; at < bytes.size(); at += 4 * sizeof(T)) {
    std::array<T, 4> v;
    std::memcpy(v.data(), &bytes[at], sizeof(v));
    const int scale = (1 << std::bit_width(v[3])) - 1;
    const int y = v[0], co = Signed(v[1]), cg = Signed(v[2]);
    const int alpha = v[3] & scale >> 1;
    const std::array<int, 4> rgba{y + co - cg, y + cg, y - co - cg, alpha << 1 | (alpha & 1)};
    const float factor = scale > 0 ? kMost / float(scale) : 0;
    for (std::size_t c = 0; c < 4; ++c)
      v[c] = T(std::lround(std::clamp(float(rgba[c]) * factor, 0.0f, kMost)));
    std::memcpy(&bytes[at], v.data(), sizeof(v));
  }
}

void undo_filter(const MeshoptLayout& layout, std::vector<std::byte>& bytes) {
  switch (layout.filter) {
    case MeshoptFilter::kNone:
      return;
    case MeshoptFilter::kOctahedral:
      return meshopt_decodeFilterOct(bytes.data(), layout.count, layout.stride);
    case MeshoptFilter::kQuaternion:
      return meshopt_decodeFilterQuat(bytes.data(), layout.count, layout.stride);
    case MeshoptFilter::kExponential:
      return meshopt_decodeFilterExp(bytes.data(), layout.count, layout.stride);
    case MeshoptFilter::kColor:
      return layout.stride == 4 ? undo_color_filter<std::uint8_t>(bytes)
                                : undo_color_filter<std::uint16_t>(bytes);
  }
}

}  // namespace

const char* meshopt_fault(const MeshoptLayout& layout) {
  const std::uint64_t stride = layout.stride;
  if (layout.mode == MeshoptMode::kAttributes) {
    if (stride % 4 != 0 || stride < 4 || stride > 256)
      return "needs a byteStride that is a multiple of 4 from 4 to 256";
    const bool four = layout.filter == MeshoptFilter::kOctahedral || layout.filter == MeshoptFilter::kColor;
    if (four && stride != 4 && stride != 8) return "needs a byteStride of 4 or 8 for its filter";
    if (layout.filter == MeshoptFilter::kQuaternion && stride != 8)
      return "needs a byteStride of 8 for its filter";
    return nullptr;
  }
  if (stride != 2 && stride != 4) return "needs a byteStride of 2 or 4 for indices";
  if (layout.mode == MeshoptMode::kTriangles && layout.count % 3 != 0) return "needs a count divisible by 3";
  if (layout.filter != MeshoptFilter::kNone) return "takes no filter for indices";
  return nullptr;
}

std::vector<std::byte> decode_meshopt(std::span<const std::byte> bytes, const MeshoptLayout& layout) {
  FURNACE_CHECK(meshopt_fault(layout) == nullptr, "a meshopt layout that {}", meshopt_fault(layout));
  if (layout.count == 0) return {};
  if (layout.count > kMostExpansion * bytes.size() / layout.stride) {
    fail(ErrorCode::kUnprocessable, "the meshopt data of " + std::to_string(bytes.size()) +
                                        " bytes are too short for " + std::to_string(layout.count) +
                                        " elements");
  }
  std::vector<std::byte> result(layout.count * layout.stride);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  bool sound = false;
  switch (layout.mode) {
    case MeshoptMode::kAttributes:
      sound = decode_meshopt_attributes(bytes, layout.stride, result);
      break;
    case MeshoptMode::kTriangles:
      sound = meshopt_decodeIndexBuffer(result.data(), layout.count, layout.stride, data, bytes.size()) == 0;
      break;
    case MeshoptMode::kIndices:
      sound =
          meshopt_decodeIndexSequence(result.data(), layout.count, layout.stride, data, bytes.size()) == 0;
      break;
  }
  if (!sound) fail_damaged();
  undo_filter(layout, result);
  return result;
}

}  // namespace furnace
