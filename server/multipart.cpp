#include "server/multipart.hpp"

#include <cstddef>
#include <optional>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "server/negotiation.hpp"

namespace furnace {
namespace {

constexpr std::size_t kMaxBoundaryBytes = 70;  // RFC 2046 section 5.1.1
constexpr std::size_t kMaxPartHeadBytes = 8192;
constexpr std::string_view kLineEnd = "\r\n";
constexpr std::string_view kHeadEnd = "\r\n\r\n";

[[noreturn]] void malformed(std::string_view what) {
  fail(ErrorCode::kInvalidRequest, fmt::format("The multipart body is malformed: {}.", what));
}

std::string boundary_of(std::string_view content_type) {
  std::string boundary = media_type_parameter(content_type, "boundary");
  if (boundary.empty() || boundary.size() > kMaxBoundaryBytes ||
      boundary.find_first_of("\r\n") != std::string::npos) {
    malformed("Content-Type needs a boundary of 1 to 70 characters");
  }
  return boundary;
}

// The text before the next `delimiter`, which is taken off `rest` with it.
std::optional<std::string_view> take_until(std::string_view& rest, std::string_view delimiter) {
  const std::size_t end = rest.find(delimiter);
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view taken = rest.substr(0, end);
  rest.remove_prefix(end + delimiter.size());
  return taken;
}

// What follows a boundary on its line: true after the last one. Spaces are allowed (RFC 2046: transport
// padding).
bool take_boundary_end(std::string_view& rest) {
  const bool last = rest.starts_with("--");
  if (last) return true;
  const auto padding = take_until(rest, kLineEnd);
  if (!padding || padding->find_first_not_of(" \t") != std::string_view::npos)
    malformed("text after a boundary");
  return false;
}

void read_disposition(std::string_view value, Part& part) {
  if (media_type_essence(value) != "form-data") malformed("a part's Content-Disposition is not form-data");
  part.name = media_type_parameter(value, "name");
  part.file_name = media_type_parameter(value, "filename");
}

void read_part_head(std::string_view head, Part& part) {
  while (!head.empty()) {
    const std::string_view line = head.substr(0, head.find(kLineEnd));
    head.remove_prefix(std::min(line.size() + kLineEnd.size(), head.size()));
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) malformed("a part's header has no colon");
    if (media_type_essence(line.substr(0, colon)) == "content-disposition") {
      read_disposition(line.substr(colon + 1), part);
    }
  }
  if (part.name.empty()) malformed("a part has no name");
}

// From behind a boundary's line to the next boundary.
Part take_part(std::string_view& rest, std::string_view delimiter) {
  Part part;
  if (rest.starts_with(kLineEnd)) malformed("a part has no name");
  const auto head = take_until(rest, kHeadEnd);
  if (!head) malformed("a part's headers do not end");
  if (head->size() > kMaxPartHeadBytes) malformed("a part's headers are too long");
  read_part_head(*head, part);
  // An empty body's delimiter begins with the line end that closed the headers.
  if (rest.starts_with(delimiter.substr(kLineEnd.size()))) {
    rest.remove_prefix(delimiter.size() - kLineEnd.size());
    return part;
  }
  const auto body = take_until(rest, delimiter);
  if (!body) malformed("the closing boundary is missing");
  part.body = *body;
  return part;
}

}  // namespace

std::vector<Part> parse_multipart(std::string_view body, std::string_view content_type, int max_parts) {
  const std::string delimiter = "\r\n--" + boundary_of(content_type);
  const std::string_view first_delimiter = std::string_view(delimiter).substr(kLineEnd.size());
  std::string_view rest = body;
  if (rest.starts_with(first_delimiter)) {
    rest.remove_prefix(first_delimiter.size());
  } else if (!take_until(rest, delimiter)) {  // a preamble is skipped
    malformed("its boundary does not occur");
  }

  std::vector<Part> parts;
  while (!take_boundary_end(rest)) {
    if (static_cast<int>(parts.size()) == max_parts) {
      fail(ErrorCode::kTooLarge, fmt::format("The multipart body has more than {} parts.", max_parts));
    }
    parts.push_back(take_part(rest, delimiter));
  }
  return parts;
}

}  // namespace furnace
