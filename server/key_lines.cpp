#include "server/key_lines.hpp"

#include <algorithm>
#include <cctype>
#include <cstdint>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"

namespace furnace {
namespace {

constexpr std::int64_t kMaxKeyFileBytes = 16 << 20;
constexpr std::size_t kMaxNameBytes = 64;

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

}  // namespace

std::vector<KeyLine> key_lines(std::string_view text) {
  std::vector<KeyLine> lines;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view rest = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (rest.ends_with('\r')) rest.remove_suffix(1);
    if (rest.empty() || rest.front() == '#') continue;
    KeyLine line{fmt::format("line {}", number), {}};
    for (bool more = true; more;) {
      const std::size_t colon = rest.find(':');
      more = colon != std::string_view::npos;
      line.fields.push_back(rest.substr(0, colon));
      if (more) rest.remove_prefix(colon + 1);
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

bool is_key_name(std::string_view name) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '_' || c == '-'; };
  return !name.empty() && name.size() <= kMaxNameBytes && std::ranges::all_of(name, plain);
}

std::optional<std::string> bytes_of_hex(std::string_view digits) {
  if (digits.size() % 2 != 0) return std::nullopt;
  std::string bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2) {
    const int high = hex_digit(digits[i]), low = hex_digit(digits[i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    bytes += static_cast<char>(high * 16 + low);
  }
  return bytes;
}

std::string hex_of_bytes(std::string_view bytes) {
  std::string digits;
  for (const char c : bytes) digits += fmt::format("{:02x}", static_cast<std::uint8_t>(c));
  return digits;
}

std::string read_key_file(const std::filesystem::path& path, bool secrets) {
  namespace fs = std::filesystem;
  std::string text = read_file(path, kMaxKeyFileBytes);
  std::error_code fault;
  const fs::perms others = fs::status(path, fault).permissions() & fs::perms::others_read;
  if (secrets && (fault || others != fs::perms::none))
    fail(ErrorCode::kUnprocessable,
         fmt::format("{} holds secrets and can be read by everyone: chmod o-r", path.filename().string()), {},
         path.string());
  return text;
}

}  // namespace furnace
