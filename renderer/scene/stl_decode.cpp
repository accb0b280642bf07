#include "renderer/scene/stl_decode.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/text_number.hpp"

namespace furnace {
namespace {

using Bytes = std::span<const std::byte>;

// There are two conventions of colour. VisCAM: bit 15 says that the facet has one, red in the upper bits. Magics, told by
// "COLOR=" in the head: bit 15 says that it has that of the head, else its own, red in the lower bits.
void add_facets(Bytes document, std::uint32_t facets, ModelBuilder& builder) {
  constexpr std::size_t kComment = 80, kLevels = 31;
  constexpr std::string_view kColor = "COLOR=";
  const std::string_view head(reinterpret_cast<const char*>(document.data()), kComment);
  const std::size_t at = head.find(kColor);
  const bool magics = at != head.npos && at + kColor.size() + 4 <= head.size();
  glm::vec4 whole(1);
  for (int i = 0; magics && i < 3; ++i)
    whole[i] = float(std::uint8_t(head[at + kColor.size() + std::size_t(i)])) / 255;

  Mesh mesh;
  mesh.positions.resize(std::size_t{facets} * 3);
  mesh.indices.resize(mesh.positions.size());
  std::vector<glm::vec4> colors(mesh.positions.size(), whole);
  bool colored = magics;
  for (std::size_t facet = 0; facet < facets; ++facet) {
    const std::byte* record = document.data() + kStlHeadBytes + kStlFacetBytes * facet;
    std::memcpy(&mesh.positions[3 * facet], record + sizeof(glm::vec3), 3 * sizeof(glm::vec3));
    std::uint16_t bits = 0;
    std::memcpy(&bits, record + 4 * sizeof(glm::vec3), sizeof bits);
    const bool marked = (bits & 0x8000) != 0;
    const bool own = marked != magics;
    const auto level = [&](int shift) { return float((bits >> shift) & kLevels) / float(kLevels); };
    colored = colored || own;
    if (!own) continue;
    const glm::vec4 color =
        magics ? glm::vec4(level(0), level(5), level(10), 1) : glm::vec4(level(10), level(5), level(0), 1);
    for (std::size_t k = 0; k < 3; ++k) colors[3 * facet + k] = color;
  }
  for (std::uint32_t i = 0; i < mesh.indices.size(); ++i) mesh.indices[i] = i;
  if (colored) mesh.colors = std::move(colors);
  builder.add_part(std::move(mesh), 0, true);
}

std::string_view take_word(std::string_view& text) {
  constexpr std::string_view kSpace = " \t\r\n\v\f";
  text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(kSpace));
  text.remove_prefix(word.size());
  return word;
}

// A solid's name may be any words.
void skip_line(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_of("\r\n"), text.size()));
}

bool is_keyword(std::string_view word, std::string_view lower_case) {
  constexpr auto same = [](char c, char wanted) { return c == wanted || c == wanted - 'a' + 'A'; };
  return std::ranges::equal(word, lower_case, same);
}

// Reads a text facet by facet. Threads: one. Owns: its corners.
class TextFacets {
 public:
  void read(std::string_view text) {
    while (!text.empty()) {
      const std::string_view word = take_word(text);
      if (is_keyword(word, "vertex")) {
        const float x = number(text), y = number(text), z = number(text);
        polygon_.emplace_back(x, y, z);
      } else if (is_keyword(word, "facet")) {
        close();
        ++facets_;
        open_ = true;
      } else if (is_keyword(word, "endloop") || is_keyword(word, "endfacet")) {
        close();
      } else if (is_keyword(word, "solid") || is_keyword(word, "endsolid")) {
        close();
        skip_line(text);
      }
    }
    close();
  }
  std::vector<glm::vec3> take() { return std::move(corners_); }

 private:
  void close() {
    if ((open_ || !polygon_.empty()) && polygon_.size() < 3)
      fail_unreadable(
          ModelFormat::kStl,
          fmt::format("facet {} has {} of its 3 vertices; is the file cut off?", facets_, polygon_.size()));
    for (std::size_t i = 2; i < polygon_.size(); ++i)
      corners_.insert(corners_.end(), {polygon_[0], polygon_[i - 1], polygon_[i]});
    polygon_.clear();
    open_ = false;
  }

  float number(std::string_view& text) const {
    const std::string_view word = take_word(text);
    const auto value = static_cast<float>(number_in(word).value_or(std::numeric_limits<double>::quiet_NaN()));
    if (!std::isfinite(value))
      fail_unreadable(
          ModelFormat::kStl,
          fmt::format("a vertex of facet {} has \"{}\" in place of a finite number", facets_, word));
    return value;
  }

  std::vector<glm::vec3> corners_, polygon_;
  std::size_t facets_ = 0;  // begun
  bool open_ = false;       // within a facet
};

void add_text(std::string_view text, ModelBuilder& builder) {
  TextFacets facets;
  facets.read(text);
  Mesh mesh;
  mesh.positions = facets.take();
  mesh.indices.resize(mesh.positions.size());
  for (std::uint32_t i = 0; i < mesh.indices.size(); ++i) mesh.indices[i] = i;
  builder.add_part(std::move(mesh), 0, true);
}

// Of a binary file.
std::uint32_t announced_facets(Bytes document) {
  if (document.size() < kStlHeadBytes)
    fail_unreadable(
        ModelFormat::kStl,
        fmt::format("it is no text, and with {} bytes too short for a binary one", document.size()));
  std::uint32_t facets = 0;
  std::memcpy(&facets, document.data() + kStlHeadBytes - sizeof facets, sizeof facets);
  const std::uint64_t needed = kStlHeadBytes + std::uint64_t{kStlFacetBytes} * facets;
  if (needed > document.size())
    fail_unreadable(ModelFormat::kStl, fmt::format("it announces {} facets, which take {} bytes, and has {}",
                                                   facets, needed, document.size()));
  return facets;
}

}  // namespace

void add_stl(Bytes document, ModelBuilder& builder) {
  builder.add_material(builder.plain_material());
  const std::string_view text(reinterpret_cast<const char*>(document.data()), document.size());
  if (!binary_stl_facets(document) && is_text_stl(text)) return add_text(text, builder);
  const std::uint32_t facets = announced_facets(document);
  if (facets > builder.limits().max_elements) fail_too_many(builder.limits().max_elements, "triangles");
  add_facets(document, facets, builder);
}

}  // namespace furnace
