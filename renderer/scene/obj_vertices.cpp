#include "renderer/scene/obj_vertices.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include "renderer/scene/model_builder.hpp"
#include "renderer/scene/text_lines.hpp"

namespace furnace {
namespace {

constexpr std::size_t kPosition = 3, kWeighted = 4, kColored = 6, kWithAlpha = 7;

// At most one more than can be, up to a comment.
std::size_t count_words(std::string_view statement) {
  std::size_t count = 0;
  while (!statement.empty() && statement.front() != '#' && count <= kWithAlpha) {
    take_word(statement);
    ++count;
  }
  return count;
}

bool is_count(std::size_t count) {
  return count == kPosition || count == kWeighted || count == kColored || count == kWithAlpha;
}

std::optional<float> number_of(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  float number = 0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (fault != std::errc{} || end != word.data() + word.size()) return {};
  return number;
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
  bool any_colored = false, any_bare = false, any_alpha = false;
  bool continued = false;  // a statement goes on in the next line, which the library puts together
  float most_color = 0;
};

Survey survey_of(std::string_view obj) {
  Survey survey;
  for (std::size_t number = 1; !obj.empty();) {
    std::string_view line = take_line(obj);
    if (take_word(line) != "v") continue;
    survey.continued |= line.ends_with('\\');
    const std::size_t count = count_words(line);
    if (!survey.continued && !is_count(count)) fail_of_count(number, count);
    survey.any_colored |= count >= kColored;
    survey.any_bare |= count < kColored;
    survey.any_alpha |= count == kWithAlpha;
    ++number;
  }
  return survey;
}

}  // namespace

ObjVertex obj_vertex(std::string_view statement, std::size_t number) {
  std::array<float, kWithAlpha + 1> numbers{};
  std::size_t count = 0;
  while (!statement.empty() && count < numbers.size()) {
    const std::optional<float> value = number_of(take_word(statement));
    if (!value) break;
    numbers[count++] = *value;
  }
  if (!is_count(count)) fail_of_count(number, count);
  ObjVertex vertex;
  vertex.position = {numbers[0], numbers[1], numbers[2]};
  if (count == kWeighted && numbers[3] != 0) vertex.position /= numbers[3];
  if (count >= kColored) vertex.color = {numbers[3], numbers[4], numbers[5]};
  return vertex;
}

std::optional<std::string> with_even_vertices(std::string_view obj) {
  Survey survey = survey_of(obj);
  if (survey.continued || !survey.any_colored || (!survey.any_bare && !survey.any_alpha)) return {};
  std::vector<ObjVertex> vertices;
  for (std::string_view left = obj; !left.empty();) {
    std::string_view line = take_line(left);
    if (take_word(line) != "v") continue;
    vertices.push_back(obj_vertex(line, vertices.size() + 1));
    if (const auto& color = vertices.back().color)
      survey.most_color = std::max({survey.most_color, color->r, color->g, color->b});
  }
  const glm::vec3 white(survey.most_color > 1 ? 255.0f : 1.0f);
  std::string out;
  out.reserve(obj.size() + vertices.size() * 8);
  const ObjVertex* next = vertices.data();
  for (std::string_view left = obj; !left.empty();) {
    const char* const begin = left.data();
    std::string_view line = take_line(left);
    if (take_word(line) != "v") {
      out.append(begin, left.data());
      continue;
    }
    const glm::vec3 color = next->color.value_or(white);
    fmt::format_to(std::back_inserter(out), "v {} {} {} {} {} {}\n", next->position.x, next->position.y,
                   next->position.z, color.r, color.g, color.b);
    ++next;
  }
  return out;
}

}  // namespace furnace
