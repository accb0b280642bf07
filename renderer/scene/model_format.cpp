#include "renderer/scene/model_format.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <set>
#include <utility>

#include "renderer/scene/mtl_text.hpp"
#include "renderer/scene/text_lines.hpp"

namespace furnace {
namespace {

bool is_number(std::string_view word) {
  return !word.empty() && word.find_first_not_of("+-.0123456789eE") == word.npos;
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return without_mark({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

// A statement of OBJ that no other text file begins with: the letter and as many numbers as it needs, or a name.
bool is_obj_statement(std::string_view line) {
  static constexpr std::array<std::string_view, 14> kNamed = {"mtllib", "usemtl", "o",    "g",     "s",
                                                              "maplib", "usemap", "deg",  "curv",  "curv2",
                                                              "surf",   "parm",   "trim", "cstype"};
  static constexpr std::array<std::string_view, 7> kNumbered = {"v", "vn", "vt", "vp", "f", "l", "p"};
  const std::string_view word = take_word(line);
  if (std::ranges::find(kNamed, word) != kNamed.end()) return true;
  if (std::ranges::find(kNumbered, word) == kNumbered.end()) return false;
  const std::string_view first = take_word(line);
  return is_number(first.substr(0, first.find('/')));
}

bool is_obj(std::string_view text) {
  constexpr int kLinesSeen = 2000;  // some begin with long comments
  constexpr int kStatementsSeen = 8;
  constexpr std::size_t kBytesSeen = 1 << 20;  // a statement may go on to the end
  if (text.size() > kBytesSeen)
    text = text.substr(0, std::min(text.find_last_of("\r\n", kBytesSeen), kBytesSeen));
  int statements = 0;
  std::string joined;
  for (int i = 0; i < kLinesSeen && !text.empty() && statements < kStatementsSeen; ++i) {
    const std::string_view line = take_statement(text, joined);
    if (line.empty() || line.front() == '#') continue;
    if (!is_obj_statement(line)) return false;
    ++statements;
  }
  return statements > 0;
}

// Threads: one. Owns: names, each once.
class Names {
 public:
  bool full() const { return names_.size() >= kMostSiblings; }
  void add(std::string_view written) {
    std::optional<std::string> name = sibling_name(written);
    if (name && !full() && seen_.insert(*name).second) names_.push_back(*std::move(name));
  }
  std::vector<std::string> take() { return std::move(names_); }

 private:
  std::set<std::string> seen_;
  std::vector<std::string> names_;
};

// Of the character of UTF-8 (RFC 3629) that the text begins with; 0: it is none, or a control character.
std::size_t character_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned lead = byte(0);
  if (lead < 0x80) return lead < ' ' || lead == 0x7f ? 0 : 1;
  const std::size_t length = lead < 0xc2 ? 0 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : lead < 0xf5 ? 4 : 0;
  unsigned code = lead & (0x7fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0u) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  const bool long_form = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  return long_form || surrogate || code > 0x10ffff ? 0 : length;
}

}  // namespace

std::string_view without_mark(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  return text;
}

std::string_view model_format_name(ModelFormat format) {
  static constexpr std::array<std::string_view, 4> kNames = {"glTF", "OBJ", "STL", "PLY"};
  return kNames[std::size_t(format)];
}

std::optional<std::uint32_t> binary_stl_facets(std::span<const std::byte> document) {
  if (document.size() < kStlHeadBytes) return std::nullopt;
  std::uint32_t facets = 0;
  std::memcpy(&facets, document.data() + kStlHeadBytes - sizeof facets, sizeof facets);
  if (document.size() != kStlHeadBytes + kStlFacetBytes * std::size_t{facets}) return std::nullopt;
  return facets;
}

bool is_text_stl(std::string_view document) {
  const std::string_view text = without_mark(document);
  constexpr std::size_t kSeen = 4096;
  const std::string head = lower(text.substr(0, kSeen));
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  if (first == head.npos || head.compare(first, 5, "solid") != 0) return false;
  return head.find("facet") != head.npos || head.find("endsolid") != head.npos;
}

ModelFormat model_format(std::span<const std::byte> document, std::string_view name) {
  const std::string_view text = text_of(document);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (text.starts_with("glTF") || (first != text.npos && text[first] == '{')) return ModelFormat::kGltf;
  if (text.starts_with("ply\n") || text.starts_with("ply\r")) return ModelFormat::kPly;
  // Some binary ones begin with "solid", too.
  if (binary_stl_facets(document) || is_text_stl(text)) return ModelFormat::kStl;
  if (is_obj(text)) return ModelFormat::kObj;
  const std::string ending = lower(name.substr(std::min(name.rfind('.'), name.size())));
  if (ending == ".obj") return ModelFormat::kObj;
  if (ending == ".stl") return ModelFormat::kStl;
  return ending == ".ply" ? ModelFormat::kPly : ModelFormat::kGltf;
}

std::string_view foreign_format(std::string_view document) {
  struct Mark {
    std::string_view begin, name;
  };
  static constexpr std::array<Mark, 16> kMarks = {{
      {"Kaydara FBX", "an FBX file"},
      {"; FBX", "an FBX file"},
      {"PXR-USDC", "a USD file"},
      {"#usda", "a USD file"},
      {"BLENDER", "a Blender file"},
      {"<?xml", "an XML file"},
      {"<COLLADA", "a COLLADA file"},
      {"<!DOCTYPE", "a web page"},
      {"<html", "a web page"},
      {"version https://git-lfs", "a pointer of Git LFS, not the file that it stands for"},
      {"\x1f\x8b", "a gzip file; unpack it"},
      {"Rar!", "a RAR archive; unpack it"},
      {"7z\xbc\xaf", "a 7z archive; unpack it"},
      {"\xff\xfe", "text in UTF-16, where UTF-8 is asked for"},
      {"\xfe\xff", "text in UTF-16, where UTF-8 is asked for"},
      {"OFF", "an OFF file"},
  }};
  const auto found =
      std::ranges::find_if(kMarks, [&](const Mark& mark) { return document.starts_with(mark.begin); });
  return found == kMarks.end() ? std::string_view() : found->name;
}

bool is_model_name(std::string_view name) {
  static constexpr std::array<std::string_view, 5> kEndings = {".glb", ".gltf", ".obj", ".stl", ".ply"};
  const std::string ending = lower(name.substr(std::min(name.rfind('.'), name.size())));
  return std::ranges::find(kEndings, ending) != kEndings.end();
}

std::string readable_text(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = character_bytes(text);
    if (length == 0) {
      out += '?';
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

std::optional<std::string> sibling_name(std::string_view written) {
  constexpr std::size_t kLongest = 1024;
  std::string name(trimmed(written));
  if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  if (name.size() > kLongest || readable_text(name) != name) return std::nullopt;
  for (char& c : name) {
    if (c == '\\') c = '/';
  }
  while (name.starts_with("./")) name.erase(0, 2);
  const bool climbs = ("/" + name + "/").find("/../") != std::string::npos;
  if (name.starts_with('/') || name.find(':') != std::string::npos || climbs)
    name.erase(0, name.find_last_of("/:") + 1);
  if (name.empty() || name == "." || name == ".." || name.back() == '/') return std::nullopt;
  return name;
}

std::vector<std::string> material_libraries(std::string_view obj) {
  Names names;
  each_statement(without_mark(obj), "mtllib", [&](std::string_view line) {
    // Several names may stand in one line, and one may have spaces.
    constexpr std::string_view kEnding = ".mtl";
    const std::string text = lower(line);
    for (std::size_t at = text.find(kEnding); at != text.npos; at = text.find(kEnding, at + 1)) {
      const std::size_t end = at + kEnding.size();
      if (end >= text.size() || kLineSpace.find(text[end]) == kLineSpace.npos) continue;
      const std::size_t taken = text.size() - line.size();
      names.add(line.substr(0, end - taken));
      line.remove_prefix(end - taken);
    }
    names.add(line);
    return !names.full();
  });
  return names.take();
}

std::vector<std::string> texture_names(std::string_view mtl) {
  GltfNotes told_elsewhere;
  Names names;
  for (const auto& [material, textures] : read_mtl(without_mark(mtl), told_elsewhere).materials)
    for (const MtlTexture& texture : textures) names.add(texture.name);
  return names.take();
}

std::vector<std::string> ply_texture_names(std::string_view ply) {
  constexpr int kMostHeaderLines = 10'000;
  Names names;
  for (int i = 0; i < kMostHeaderLines && !ply.empty(); ++i) {
    std::string_view line = take_line(ply);
    const std::string_view word = take_word(line);
    if (word == "end_header") break;
    if (word == "comment" && lower(take_word(line)) == "texturefile") names.add(line);
  }
  return names.take();
}

}  // namespace furnace
