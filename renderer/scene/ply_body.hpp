// What follows the header of a PLY file: numbers, one behind the other.
#pragma once

#include <cstdint>
#include <string_view>

#include "renderer/base/deadline.hpp"
#include "renderer/scene/ply_header.hpp"

namespace furnace {

// Every number of a file is a double, which holds each of PLY's types exactly.
// Errors: kUnprocessable that names element, row and line or byte; kDeadlineExceeded. Threads: one. Owns: nothing.
class PlyBody {
 public:
  PlyBody(std::string_view file, const PlyHeader& header, const Deadline& deadline)
      : file_(file), header_(header), deadline_(deadline), at_(header.body) {}

  // What is read next, for errors.
  void begin_row(const PlyElement& element, std::uint64_t row) {
    element_ = &element;
    row_ = row;
  }
  double number(PlyType type) {
    if ((++taken_ & kDeadlineMask) == 0) check_deadline(deadline_, "import");
    return header_.encoding == PlyEncoding::kText ? text_number() : binary_number(type);
  }
  // How many numbers of `type` follow; the rest of the file has room for them.
  std::uint64_t list_size(PlyType count_type, PlyType type);
  void skip(const PlyProperty& property);
  void skip(const PlyElement& element);

  std::size_t place() const { return at_; }
  void go_to(std::size_t place) { at_ = place; }
  // "is not a readable PLY file: face 3 names ..., in line 17".
  [[noreturn]] void fail_row(std::string_view why) const;

 private:
  static constexpr std::uint64_t kDeadlineMask = 0xffff;

  [[noreturn]] void fail_end() const;
  std::string_view word();
  double text_number();
  double binary_number(PlyType type);
  template <class Number>
  double binary();
  void skip_bytes(std::uint64_t bytes);

  std::string_view file_;
  const PlyHeader& header_;
  const Deadline& deadline_;
  std::size_t at_ = 0;
  const PlyElement* element_ = nullptr;
  std::uint64_t row_ = 0, taken_ = 0;
};

}  // namespace furnace
