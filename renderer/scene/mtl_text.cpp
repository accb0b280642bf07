#include "renderer/scene/mtl_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "renderer/scene/model_format.hpp"
#include "renderer/scene/text_lines.hpp"
#include "renderer/scene/text_number.hpp"

namespace furnace {
namespace {

struct NumberStatement {
  std::string_view name;  // as the library wants it
  std::size_t numbers;
};

constexpr std::array<NumberStatement, 16> kNumberStatements = {{{"Ka", 3},
                                                                {"Kd", 3},
                                                                {"Ks", 3},
                                                                {"Ke", 3},
                                                                {"Tf", 3},
                                                                {"Ns", 1},
                                                                {"Ni", 1},
                                                                {"d", 1},
                                                                {"Tr", 1},
                                                                {"Pr", 1},
                                                                {"Pm", 1},
                                                                {"Ps", 1},
                                                                {"Pc", 1},
                                                                {"Pcr", 1},
                                                                {"aniso", 1},
                                                                {"anisor", 1}}};

std::optional<double> number_of(std::string_view word) {
  const std::optional<double> value = number_in(word);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

bool is_texture_statement(std::string_view word) {
  static constexpr std::array<std::string_view, 5> kOthers = {"bump", "norm", "disp", "decal", "refl"};
  return word.starts_with("map_") || std::ranges::find(kOthers, word) != kOthers.end();
}

// Reads one text after the other. Threads: one. Owns: what it has read.
class Reader {
 public:
  explicit Reader(GltfNotes& notes) : notes_(notes) {}

  MtlText read(std::string_view mtl) {
    while (!mtl.empty()) {
      std::string_view line = take_line(mtl);
      const std::string_view whole = line, written = take_word(line);
      const std::string word = lower(written);
      const auto statement = std::ranges::find_if(
          kNumberStatements, [&](const NumberStatement& known) { return lower(known.name) == word; });
      if (statement != kNumberStatements.end()) {
        add_numbers(*statement, line);
        continue;
      }
      if (word == "newmtl") begin_material(line);
      if (is_texture_statement(word)) {
        add_texture(written, line);
      } else {
        append(whole);
      }
    }
    return std::move(out_);
  }

 private:
  void begin_material(std::string_view name) {
    material_ = std::string(name);
    if (out_.materials.size() < kMostMtlMaterials) out_.materials.try_emplace(material_);
  }

  void append(std::string_view line) {
    out_.text += line;
    out_.text += '\n';
  }

  void add_numbers(const NumberStatement& statement, std::string_view line) {
    std::vector<std::string_view> numbers;
    bool readable = true;
    while (!line.empty() && line.front() != '#' && numbers.size() < statement.numbers) {
      const std::string_view word = take_word(line);
      if (numbers.empty() && statement.name == "d" && lower(word) == "-halo") continue;
      readable = readable && number_of(word);
      numbers.push_back(word);
    }
    if (numbers.size() == 1) numbers.resize(statement.numbers, numbers.front());
    if (!readable || numbers.size() != statement.numbers) {
      notes_.add("value-ignored", mtl_place(material_, statement.name),
                 fmt::format("is not {} number{}; it was left out", statement.numbers,
                             statement.numbers == 1 ? "" : "s"));
      return;
    }
    std::string text(statement.name);
    for (const std::string_view number : numbers) text.append(" ").append(number);
    append(text);
  }

  // Up to three numbers, of which the third is of depth.
  static glm::vec2 take_vector(std::string_view& line, glm::vec2 value) {
    for (int i = 0; i < 3; ++i) {
      std::string_view rest = line;
      const auto number = number_of(take_word(rest));
      if (!number || rest.empty()) return value;  // the last word is the file's name
      line = rest;
      if (i < 2) value[i] = float(std::clamp(*number, -1e6, 1e6));
    }
    return value;
  }

  void add_texture(std::string_view statement, std::string_view line) {
    MtlTexture texture;
    texture.statement = std::string(statement);
    std::string_view rest = line;
    std::string ignored;
    while (rest.size() > 1 && rest.front() == '-' && std::isalpha(static_cast<unsigned char>(rest[1])) != 0) {
      const std::string option = lower(take_word(rest));
      if (option == "-o") {
        texture.offset = take_vector(rest, texture.offset);
      } else if (option == "-s") {
        texture.scale = take_vector(rest, texture.scale);
      } else if (option == "-t") {
        if (take_vector(rest, glm::vec2(0)) != glm::vec2(0)) ignored = option;
      } else if (option == "-mm") {
        const auto base = number_of(take_word(rest)), gain = number_of(take_word(rest));
        if (base != 0.0 || gain != 1.0) ignored = option;
      } else {
        const std::string value = lower(take_word(rest));
        if (option == "-clamp") texture.clamps = value == "on";
      }
    }
    texture.name = std::string(rest);
    if (texture.name.empty()) return;
    append(fmt::format("{} {}", statement, texture.name));
    if (!ignored.empty())
      notes_.add("texture-option-ignored", mtl_place(material_, texture.statement),
                 ignored + " has no counterpart and was left out");
    if (material_.empty()) out_.materials.try_emplace(material_);
    const auto owner = out_.materials.find(material_);
    if (owner != out_.materials.end() && textures_++ < kMostMtlTextures)
      owner->second.push_back(std::move(texture));
  }

  GltfNotes& notes_;
  MtlText out_;
  std::string material_;  // whose statements these are
  std::size_t textures_ = 0;
};

}  // namespace

MtlText read_mtl(std::string_view mtl, GltfNotes& notes) {
  return Reader(notes).read(mtl);
}

std::vector<std::string> named_materials(std::string_view obj) {
  std::vector<std::string> names;
  std::set<std::string_view> seen;
  each_statement(obj, "usemtl", [&](std::string_view name) {
    if (!name.empty() && seen.insert(name).second) names.emplace_back(name);
    return names.size() < kMostMtlMaterials;
  });
  return names;
}

bool has_free_forms(std::string_view obj) {
  bool found = false;
  for (const std::string_view word : {"curv", "curv2", "surf"})
    each_statement(obj, word, [&](std::string_view) {
      found = true;
      return false;
    });
  return found;
}

std::string mtl_place(std::string_view material, std::string_view statement) {
  std::string out = "/materials/";
  for (const char c : readable_text(material)) {
    if (c == '~') out += "~0";
    if (c == '/') out += "~1";
    if (c != '~' && c != '/') out += c;
  }
  return out.append("/").append(statement);
}

}  // namespace furnace
