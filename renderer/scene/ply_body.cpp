#include "renderer/scene/ply_body.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "renderer/scene/text_number.hpp"

namespace furnace {
namespace {

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

}  // namespace

void PlyBody::fail_row(std::string_view why) const {
  const std::string_view name = element_ == nullptr ? "" : ply_name(element_->name);
  if (header_.encoding != PlyEncoding::kText)
    fail_ply(fmt::format("{} {} {}, at byte {}", name, row_, why, at_));
  const std::string_view read = file_.substr(header_.body, at_ - header_.body);
  const auto ends = std::size_t(std::ranges::count(read, '\n'));
  const auto lines = ends > 0 ? ends : std::size_t(std::ranges::count(read, '\r'));
  fail_ply(fmt::format("{} {} {}, in line {}", name, row_, why, header_.body_line + lines));
}

void PlyBody::fail_end() const {
  fail_row("is cut off: the file ends");
}

std::string_view PlyBody::word() {
  while (at_ < file_.size() && is_space(file_[at_])) ++at_;
  if (at_ == file_.size()) fail_end();
  std::size_t end = at_ + 1;
  while (end < file_.size() && !is_space(file_[end])) ++end;
  return file_.substr(at_, end - at_);
}

double PlyBody::text_number() {
  const std::string_view text = word();
  const std::optional<double> value = number_in(text);
  if (!value) fail_row(fmt::format("has \"{}\" for a number", ply_name(text)));
  at_ += text.size();
  return *value;
}

template <class Number>
double PlyBody::binary() {
  if (file_.size() - at_ < sizeof(Number)) fail_end();
  std::array<char, sizeof(Number)> bytes;
  std::memcpy(bytes.data(), file_.data() + at_, sizeof(Number));
  static_assert(std::endian::native == std::endian::little);
  if (header_.encoding == PlyEncoding::kBigEndian) std::ranges::reverse(bytes);
  at_ += sizeof(Number);
  return double(std::bit_cast<Number>(bytes));
}

double PlyBody::binary_number(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
      return binary<std::int8_t>();
    case PlyType::kUint8:
      return binary<std::uint8_t>();
    case PlyType::kInt16:
      return binary<std::int16_t>();
    case PlyType::kUint16:
      return binary<std::uint16_t>();
    case PlyType::kInt32:
      return binary<std::int32_t>();
    case PlyType::kUint32:
      return binary<std::uint32_t>();
    case PlyType::kFloat32:
      return double(binary<float>());
    case PlyType::kFloat64:
      break;
  }
  return binary<double>();
}

std::uint64_t PlyBody::list_size(PlyType count_type, PlyType type) {
  const double count = number(count_type);
  if (!(count >= 0) || count != std::floor(count))
    fail_row(fmt::format("has a list of {:.9g} values", count));
  const std::size_t left = file_.size() - at_;
  // Of text each takes a digit and what stands before it.
  const std::size_t bytes = header_.encoding == PlyEncoding::kText ? 2 : ply_type_bytes(type);
  if (count > double(left / bytes))
    fail_row(fmt::format("is cut off: a list has {:.0f} values, and {} bytes are left", count, left));
  return std::uint64_t(count);
}

void PlyBody::skip_bytes(std::uint64_t bytes) {
  if (bytes > file_.size() - at_) fail_end();
  at_ += bytes;
}

void PlyBody::skip(const PlyProperty& property) {
  const std::uint64_t count = property.count_type ? list_size(*property.count_type, property.type) : 1;
  if (header_.encoding != PlyEncoding::kText) return skip_bytes(count * ply_type_bytes(property.type));
  for (std::uint64_t i = 0; i < count; ++i) number(property.type);
}

void PlyBody::skip(const PlyElement& element) {
  if (element.properties.empty()) return;
  for (std::uint64_t row = 0; row < element.count; ++row) {
    begin_row(element, row);
    for (const PlyProperty& property : element.properties) skip(property);
  }
}

}  // namespace furnace
