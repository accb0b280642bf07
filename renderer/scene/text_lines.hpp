// Lines and words of OBJ and MTL: views of the text, but for statements over several lines.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace furnace {

inline constexpr std::string_view kLineSpace = " \t\r\v\f";

inline std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kLineSpace);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kLineSpace) - first + 1);
}

// Takes the next line off `text`, without space at its ends; lines end in \n, \r\n or \r.
inline std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return trimmed(line);
}

// Takes the next statement of an OBJ file off `text`: a line, or several in `joined` of which all but the last end in a
// backslash.
inline std::string_view take_statement(std::string_view& text, std::string& joined) {
  std::string_view line = take_line(text);
  if (!line.ends_with('\\')) return line;
  joined.clear();
  while (line.ends_with('\\')) {
    joined.append(line.substr(0, line.size() - 1)).append(1, ' ');
    if (text.starts_with('\n') && text.data()[-1] == '\r') text.remove_prefix(1);
    line = take_line(text);
  }
  joined.append(line);
  return trimmed(joined);
}

// Takes the next word off a trimmed line.
inline std::string_view take_word(std::string_view& line) {
  const std::size_t end = std::min(line.find_first_of(kLineSpace), line.size());
  const std::string_view word = line.substr(0, end);
  line = trimmed(line.substr(end));
  return word;
}

inline std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = char(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

// Calls `body` with the rest of each line that begins with `keyword`, until it returns false. Found as text first: files
// are large and such statements are rare.
template <class Body>
void each_statement(std::string_view text, std::string_view keyword, Body&& body) {
  for (std::size_t at = text.find(keyword); at != text.npos; at = text.find(keyword, at + 1)) {
    const std::size_t before = at == 0 ? text.npos : text.find_last_not_of(" \t", at - 1);
    if (before != text.npos && text[before] != '\n' && text[before] != '\r') continue;
    std::string_view rest = text.substr(at);
    std::string_view line = take_line(rest);
    if (take_word(line) == keyword && !body(line)) return;
  }
}

}  // namespace furnace
