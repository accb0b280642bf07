#include "renderer/scene/obj_vertices.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include "renderer/scene/model_builder.hpp"
#include "renderer/scene/text_lines.hpp"
#include "renderer/scene/text_number.hpp"

namespace furnace {
namespace {

constexpr std::size_t kPosition = 3, kWeighted = 4, kColored = 6, kWithAlpha = 7;

bool is_count(std::size_t count) {
  return count == kPosition || count == kWeighted || count == kColored || count == kWithAlpha;
}

[[noreturn]] void fail_of_count(std::size_t number, std::size_t count) {
  fail_unreadable(
      ModelFormat::kObj,
      count < kPosition
          ? fmt::format("vertex {} has {} of its 3 numbers", number, count)
          : fmt::format("vertex {} has {} numbers, which is neither a place nor a place and a colour", number,
                        count > kWithAlpha ? "more than 7" : fmt::to_string(count)));
}

// What the "v" statements of a document have in common.
struct Survey {
  bool any_colored = false, any_bare = false;
  bool any_other = false;  // an alpha, or words that the library may take for numbers or not
};

void survey(std::string_view statement, Survey& out) {
  std::size_t count = 0;
  for (; !statement.empty(); ++count)
    out.any_other |=
        std::string_view("+-.0123456789").find(take_word(statement).front()) == std::string_view::npos;
  out.any_other |= count != kPosition && count != kWeighted && count != kColored;
  out.any_colored |= count >= kColored;
  out.any_bare |= count < kColored;
}

Survey survey_of(std::string_view obj) {
  Survey out;
  std::string joined;
  while (!obj.empty()) {
    std::string_view statement = take_statement(obj, joined);
    if (take_word(statement) == "v") survey(statement, out);
  }
  return out;
}

}  // namespace

ObjVertex obj_vertex(std::string_view statement, std::size_t number) {
  std::array<float, kWithAlpha + 1> numbers{};
  std::size_t count = 0;
  while (!statement.empty() && count < numbers.size()) {
    const std::optional<double> value = number_in(take_word(statement));
    if (!value) break;
    numbers[count++] = float(*value);
  }
  if (!is_count(count)) fail_of_count(number, count);
  ObjVertex vertex;
  vertex.position = {numbers[0], numbers[1], numbers[2]};
  if (count == kWeighted && numbers[3] != 0) vertex.position /= numbers[3];
  if (count >= kColored) vertex.color = {numbers[3], numbers[4], numbers[5]};
  return vertex;
}

std::optional<std::string> with_even_vertices(std::string_view obj) {
  const Survey survey = survey_of(obj);
  if (!survey.any_other && !(survey.any_colored && survey.any_bare)) return {};
  std::vector<ObjVertex> vertices;
  bool colored = false;
  float most_color = 0;
  std::string joined;
  for (std::string_view left = obj; !left.empty();) {
    std::string_view statement = take_statement(left, joined);
    if (take_word(statement) != "v") continue;
    vertices.push_back(obj_vertex(statement, vertices.size() + 1));
    if (const auto& color = vertices.back().color) {
      colored = true;
      most_color = std::max({most_color, color->r, color->g, color->b});
    }
  }
  const glm::vec3 white(most_color > 1 ? 255.0f : 1.0f);
  std::string out;
  out.reserve(obj.size() + vertices.size() * 8);
  const ObjVertex* next = vertices.data();
  for (std::string_view left = obj; !left.empty();) {
    const char* const begin = left.data();
    std::string_view statement = take_statement(left, joined);
    if (take_word(statement) != "v") {
      out.append(begin, left.data());
      continue;
    }
    fmt::format_to(std::back_inserter(out), "v {} {} {}", next->position.x, next->position.y,
                   next->position.z);
    const glm::vec3 color = next->color.value_or(white);
    if (colored) fmt::format_to(std::back_inserter(out), " {} {} {}", color.r, color.g, color.b);
    out += '\n';
    ++next;
  }
  return out;
}

}  // namespace furnace
