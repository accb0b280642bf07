// PLY files in every encoding from the same values.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "tests/support/model_files.hpp"

namespace furnace::test {

// Statements of the header, then values in their order. Threads: one. Owns: the file.
class PlyWriter {
 public:
  explicit PlyWriter(PlyForm form, std::string_view line_end = "\n") : form_(form), line_end_(line_end) {
    static constexpr std::string_view kForms[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    line("ply").line(fmt::format("format {} 1.0", kForms[int(form)]));
  }

  PlyWriter& line(std::string_view text) {
    file_ += text;
    file_ += line_end_;
    return *this;
  }
  // By a type's name, of either family.
  PlyWriter& put(std::string_view type, double value) {
    if (form_ == PlyForm::kText) {
      file_ += fmt::format("{} ", value);
    } else if (type == "char" || type == "int8") {
      add(std::int8_t(value));
    } else if (type == "uchar" || type == "uint8") {
      add(std::uint8_t(value));
    } else if (type == "short" || type == "int16") {
      add(std::int16_t(value));
    } else if (type == "ushort" || type == "uint16") {
      add(std::uint16_t(value));
    } else if (type == "int" || type == "int32") {
      add(std::int32_t(value));
    } else if (type == "uint" || type == "uint32") {
      add(std::uint32_t(value));
    } else if (type == "float" || type == "float32") {
      add(float(value));
    } else {
      add(value);
    }
    return *this;
  }
  template <class Values>
  PlyWriter& put_all(std::string_view type, const Values& values) {
    for (const auto value : values) put(type, double(value));
    return *this;
  }
  // With its length before it.
  template <class Values>
  PlyWriter& put_list(std::string_view count_type, std::string_view type, const Values& values) {
    return put(count_type, double(values.size())).put_all(type, values);
  }
  const std::string& file() const { return file_; }

 private:
  template <class Number>
  void add(Number value) {
    test::put(file_, value, form_ == PlyForm::kBig);
  }

  PlyForm form_;
  std::string_view line_end_;
  std::string file_;
};

}  // namespace furnace::test
