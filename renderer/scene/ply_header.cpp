#include "renderer/scene/ply_header.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "renderer/scene/model_builder.hpp"

namespace furnace {
namespace {

// Far above what a thousand properties take.
constexpr std::size_t kMostHeaderBytes = 1 << 20;

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes = {{{"char", PlyType::kInt8},
                                                                          {"int8", PlyType::kInt8},
                                                                          {"uchar", PlyType::kUint8},
                                                                          {"uint8", PlyType::kUint8},
                                                                          {"short", PlyType::kInt16},
                                                                          {"int16", PlyType::kInt16},
                                                                          {"ushort", PlyType::kUint16},
                                                                          {"uint16", PlyType::kUint16},
                                                                          {"int", PlyType::kInt32},
                                                                          {"int32", PlyType::kInt32},
                                                                          {"uint", PlyType::kUint32},
                                                                          {"uint32", PlyType::kUint32},
                                                                          {"float", PlyType::kFloat32},
                                                                          {"float32", PlyType::kFloat32},
                                                                          {"double", PlyType::kFloat64},
                                                                          {"float64", PlyType::kFloat64}}};

constexpr std::array<std::pair<std::string_view, PlyEncoding>, 3> kEncodings = {
    {{"ascii", PlyEncoding::kText},
     {"binary_little_endian", PlyEncoding::kLittleEndian},
     {"binary_big_endian", PlyEncoding::kBigEndian}}};

std::string_view take_word(std::string_view& line) {
  constexpr std::string_view kSpace = " \t\r\v\f";
  line.remove_prefix(std::min(line.find_first_not_of(kSpace), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kSpace));
  line.remove_prefix(word.size());
  return word;
}

bool equals_ignoring_case(std::string_view word, std::string_view lower) {
  return std::ranges::equal(word, lower,
                            [](char a, char b) { return (a >= 'A' && a <= 'Z' ? char(a + 32) : a) == b; });
}

// Threads: one. Owns: the header it reads.
class HeaderReader {
 public:
  explicit HeaderReader(std::string_view file)
      : file_(file), head_(file.substr(0, std::min(file.size(), kMostHeaderBytes))) {}

  PlyHeader read();

 private:
  [[noreturn]] void fail_line(std::string_view why) const {
    fail_ply(fmt::format("{}, in line {}", why, line_));
  }
  std::string_view take_line();
  PlyType type_of(std::string_view word) const;
  void read_format(std::string_view line);
  void read_comment(std::string_view line);
  void read_element(std::string_view line);
  void read_property(std::string_view line);

  std::string_view file_, head_;
  char end_ = '\n';
  std::size_t at_ = 0, line_ = 0;
  bool has_format_ = false;
  PlyHeader header_;
};

std::string_view HeaderReader::take_line() {
  const std::size_t end = head_.find(end_, at_);
  if (end == head_.npos)
    fail_ply(head_.size() < file_.size() ? fmt::format("its header is longer than {} bytes", kMostHeaderBytes)
                                         : "it ends before end_header");
  ++line_;
  const std::string_view line = head_.substr(at_, end - at_);
  at_ = end + 1;
  return line;
}

PlyType HeaderReader::type_of(std::string_view word) const {
  const auto row = std::ranges::find(kTypes, word, &decltype(kTypes)::value_type::first);
  if (row == kTypes.end()) fail_line(fmt::format("there is no type \"{}\"", ply_name(word)));
  return row->second;
}

void HeaderReader::read_format(std::string_view line) {
  const std::string_view word = take_word(line);
  const auto row = std::ranges::find(kEncodings, word, &decltype(kEncodings)::value_type::first);
  if (row == kEncodings.end()) fail_line(fmt::format("there is no format \"{}\"", ply_name(word)));
  const std::string_view version = take_word(line);
  if (version != "1.0") fail_line(fmt::format("its version is \"{}\", not 1.0", ply_name(version)));
  header_.encoding = row->second;
  has_format_ = true;
}

void HeaderReader::read_comment(std::string_view line) {
  constexpr std::size_t kMostNameBytes = 1023;
  if (!equals_ignoring_case(take_word(line), "texturefile")) return;
  const std::size_t first = line.find_first_not_of(" \t\r");
  if (first == line.npos) return;
  const std::string_view name = line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
  if (name.size() > kMostNameBytes) fail_line("a name has more than 1023 bytes");
  header_.textures.push_back(name);
}

void HeaderReader::read_element(std::string_view line) {
  PlyElement element;
  element.name = take_word(line);
  const std::string_view count = take_word(line);
  const auto [end, fault] = std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (fault != std::errc{} || end != count.data() + count.size())
    fail_line(fmt::format("\"{}\" is no count of elements", ply_name(count)));
  header_.elements.push_back(std::move(element));
}

void HeaderReader::read_property(std::string_view line) {
  if (header_.elements.empty()) fail_line("a property is of no element");
  PlyProperty property;
  std::string_view type = take_word(line);
  if (type == "list") {
    property.count_type = type_of(take_word(line));
    type = take_word(line);
  }
  property.type = type_of(type);
  property.name = take_word(line);
  if (property.name.empty()) fail_line("a property has no name");
  header_.elements.back().properties.push_back(property);
}

PlyHeader HeaderReader::read() {
  constexpr std::string_view kMark = "\xef\xbb\xbf", kMagic = "ply";
  if (head_.starts_with(kMark)) at_ = kMark.size();
  const std::size_t first_end = head_.find_first_of("\r\n", at_);
  if (head_.substr(at_, first_end - at_) != kMagic) fail_ply("it does not begin with \"ply\"");
  if (first_end != head_.npos && head_.substr(first_end, 2) != "\r\n") end_ = head_[first_end];
  take_line();
  for (;;) {
    std::string_view line = take_line();
    const std::string_view word = take_word(line);
    if (word == "end_header") break;
    if (word == "format") {
      read_format(line);
    } else if (word == "comment") {
      read_comment(line);
    } else if (word == "element") {
      read_element(line);
    } else if (word == "property") {
      read_property(line);
    }
    // obj_info, and what else there is: old versions of Blender wrote a comment without its keyword.
  }
  if (!has_format_) fail_ply("its header says no format");
  header_.body = at_;
  header_.body_line = line_ + 1;
  return std::move(header_);
}

// As text: a digit and what ends it.
std::uint64_t least_bytes(const PlyElement& element, PlyEncoding encoding) {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : element.properties)
    bytes += encoding == PlyEncoding::kText ? 2 : ply_type_bytes(property.count_type.value_or(property.type));
  return bytes;
}

void check_counts(const PlyHeader& header, std::size_t file_bytes) {
  // The last number of a text needs nothing behind it.
  std::uint64_t left = file_bytes - header.body + (header.encoding == PlyEncoding::kText ? 1 : 0);
  for (const PlyElement& element : header.elements) {
    const std::uint64_t bytes = least_bytes(element, header.encoding);
    if (bytes == 0) continue;
    if (element.count > left / bytes)
      fail_ply(fmt::format("it announces {} of \"{}\", and ends after {} bytes, which hold {} at most",
                           element.count, ply_name(element.name), file_bytes, left / bytes));
    left -= element.count * bytes;
  }
}

}  // namespace

std::size_t ply_type_bytes(PlyType type) {
  static constexpr std::array<std::size_t, 8> kBytes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[std::size_t(type)];
}

void fail_ply(std::string_view why) {
  fail_unreadable(ModelFormat::kPly, why);
}

std::string_view ply_name(std::string_view name) {
  constexpr std::size_t kLongest = 32;
  return name.substr(0, kLongest);
}

PlyHeader read_ply_header(std::string_view file) {
  PlyHeader header = HeaderReader(file).read();
  check_counts(header, file.size());
  return header;
}

}  // namespace furnace
