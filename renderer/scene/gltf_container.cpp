#include "renderer/scene/gltf_container.hpp"

#include <array>
#include <cstring>

#include "renderer/base/error.hpp"

namespace furnace {

namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr std::uint32_t kChunkJson = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kChunkBin = 0x004E4942;   // "BIN\0"
constexpr std::size_t kGlbHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr std::size_t kMaxPathBytes = 4096;  // PATH_MAX of Linux

std::uint32_t word_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t word;
  std::memcpy(&word, bytes.data() + offset, sizeof word);  // little-endian file on little-endian machines
  return word;
}

[[noreturn]] void refuse_glb(const std::string& what, std::size_t offset) {
  fail(ErrorCode::kUnprocessable, "broken GLB: " + what + " at byte " + std::to_string(offset));
}

GltfContainer open_glb(std::string_view bytes) {
  if (bytes.size() < kGlbHeaderBytes) refuse_glb("the header is cut off", bytes.size());
  if (word_at(bytes, 4) != 2) refuse_glb("container version is not 2", 4);
  const std::size_t length = word_at(bytes, 8);
  if (length > bytes.size()) refuse_glb("the file is shorter than its header says", 8);

  GltfContainer container;
  std::size_t offset = kGlbHeaderBytes;
  for (int index = 0; offset < length; ++index) {
    if (length - offset < kChunkHeaderBytes) refuse_glb("a chunk header is cut off", offset);
    const std::size_t size = word_at(bytes, offset);
    const std::uint32_t type = word_at(bytes, offset + 4);
    if (size % 4 != 0) refuse_glb("a chunk's length is not a multiple of 4", offset);
    if (size > length - offset - kChunkHeaderBytes) refuse_glb("a chunk is cut off", offset);
    const ByteRange range{offset + kChunkHeaderBytes, size};
    if (index == 0) {
      if (type != kChunkJson) refuse_glb("the first chunk is not JSON", offset);
      container.json = range;
    } else if (type == kChunkJson || (type == kChunkBin && index != 1)) {
      refuse_glb("a JSON or BIN chunk is out of place", offset);
    } else if (type == kChunkBin) {
      container.binary = range;
    }
    offset = range.offset + range.size;
  }
  if (container.json.size == 0) refuse_glb("there is no JSON chunk", kGlbHeaderBytes);
  return container;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string percent_decoded(std::string_view text, const std::string& pointer) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
    if (high < 0 || low < 0) fail(ErrorCode::kUnprocessable, "has a broken % escape", pointer);
    result += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return result;
}

constexpr std::array<std::int8_t, 256> kBase64Values = [] {
  std::array<std::int8_t, 256> values{};
  values.fill(-1);
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < alphabet.size(); ++i) {
    values[static_cast<unsigned char>(alphabet[i])] = static_cast<std::int8_t>(i);
  }
  return values;
}();

std::string base64_decoded(std::string_view text, const std::string& pointer) {
  if (text.size() % 4 != 0) fail(ErrorCode::kUnprocessable, "base64 length is not a multiple of 4", pointer);
  std::size_t padding = 0;
  while (padding < 2 && padding < text.size() && text[text.size() - 1 - padding] == '=') ++padding;
  const std::string_view digits = text.substr(0, text.size() - padding);
  std::string result;
  result.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : digits) {
    const int value = kBase64Values[static_cast<unsigned char>(c)];
    if (value < 0) fail(ErrorCode::kUnprocessable, "has a character that is not base64", pointer);
    bits = (bits << 6) | static_cast<std::uint32_t>(value);
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      result += static_cast<char>((bits >> bit_count) & 0xFF);
    }
  }
  if (bits & ((1u << bit_count) - 1)) fail(ErrorCode::kUnprocessable, "base64 ends in stray bits", pointer);
  return result;
}

bool starts_with_ignoring_case(std::string_view text, std::string_view lower_case_prefix) {
  if (text.size() < lower_case_prefix.size()) return false;
  for (std::size_t i = 0; i < lower_case_prefix.size(); ++i) {
    const char c = text[i] >= 'A' && text[i] <= 'Z' ? static_cast<char>(text[i] - 'A' + 'a') : text[i];
    if (c != lower_case_prefix[i]) return false;
  }
  return true;
}

// RFC 3986, section 3.1: ALPHA *( ALPHA / DIGIT / "+" / "-" / "." ) ":"
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find_first_of(":/?#");
  if (colon == std::string_view::npos || uri[colon] != ':' || colon == 0) return false;
  const std::string_view scheme = uri.substr(0, colon);
  const bool letter_first = (scheme[0] >= 'a' && scheme[0] <= 'z') || (scheme[0] >= 'A' && scheme[0] <= 'Z');
  return letter_first && scheme.find_first_not_of(
                             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                             "0123456789+-.") == std::string_view::npos;
}

bool leaves_its_folder(std::string_view path) {
  while (true) {
    const std::size_t slash = path.find_first_of("/\\");
    if (path.substr(0, slash) == "..") return true;
    if (slash == std::string_view::npos) return false;
    path.remove_prefix(slash + 1);
  }
}

}  // namespace

GltfContainer open_gltf_container(const Blob& document) {
  const std::string_view bytes = document.text();
  if (bytes.size() >= 4 && word_at(bytes, 0) == kGlbMagic) return open_glb(bytes);
  return {{0, bytes.size()}, std::nullopt};
}

bool is_data_uri(std::string_view uri) {
  return starts_with_ignoring_case(uri, "data:");
}

std::string decode_relative_uri(std::string_view uri, const std::string& pointer) {
  if (has_scheme(uri)) {
    fail(ErrorCode::kUnprocessable, "must be a relative path or a data: URI; nothing is fetched", pointer);
  }
  if (uri.size() > kMaxPathBytes) fail(ErrorCode::kUnprocessable, "is too long", pointer);
  std::string path = percent_decoded(uri, pointer);
  if (path.empty()) fail(ErrorCode::kUnprocessable, "is empty", pointer);
  for (const char c : path) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      fail(ErrorCode::kUnprocessable, "has a control character", pointer);
    }
  }
  if (path.front() == '/' || path.front() == '\\')
    fail(ErrorCode::kUnprocessable, "must be relative", pointer);
  if (leaves_its_folder(path)) fail(ErrorCode::kUnprocessable, "must not contain \"..\"", pointer);
  return path;
}

std::string decode_data_uri(std::string_view uri, const std::string& pointer) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) fail(ErrorCode::kUnprocessable, "data: URI without a comma", pointer);
  const std::string_view header = uri.substr(0, comma);
  const std::string_view payload = uri.substr(comma + 1);
  constexpr std::string_view base64_mark = ";base64";
  const bool base64 =
      header.size() >= base64_mark.size() &&
      starts_with_ignoring_case(header.substr(header.size() - base64_mark.size()), base64_mark);
  return base64 ? base64_decoded(payload, pointer) : percent_decoded(payload, pointer);
}

std::string shortened(std::string_view text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return std::string(text);
  std::size_t size = max_bytes;
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0) == 0x80) --size;
  return std::string(text.substr(0, size)) + "...";
}

}  // namespace furnace
