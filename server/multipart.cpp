#include "server/multipart.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "server/negotiation.hpp"

namespace furnace {
namespace {

constexpr std::size_t kMaxBoundaryBytes = 70;  // RFC 2046 section 5.1.1
constexpr std::size_t kMaxPaddingBytes = 256;  // behind a boundary
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

void read_disposition(std::string_view value, PartHead& head) {
  if (media_type_essence(value) != "form-data") malformed("a part's Content-Disposition is not form-data");
  head.name = media_type_parameter(value, "name");
  head.file_name = media_type_parameter(value, "filename");
}

PartHead part_head(std::string_view text) {
  PartHead head;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find(kLineEnd));
    text.remove_prefix(std::min(line.size() + kLineEnd.size(), text.size()));
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) malformed("a part's header has no colon");
    const std::string name = media_type_essence(line.substr(0, colon));
    if (name == "content-disposition") read_disposition(line.substr(colon + 1), head);
    if (name == "content-type") head.media_type = media_type_essence(line.substr(colon + 1));
  }
  if (head.name.empty()) malformed("a part has no name");
  return head;
}

// Whether `text` may become one that starts with `wanted` when more comes.
bool may_start_with(std::string_view text, std::string_view wanted) {
  return text.size() < wanted.size() && wanted.starts_with(text);
}

}  // namespace

MultipartReader::MultipartReader(std::string_view content_type, int max_parts, PartListener& listener)
    : delimiter_("\r\n--" + boundary_of(content_type)), max_parts_(max_parts), listener_(listener) {}

void MultipartReader::take(std::string_view piece) {
  std::string joined;
  if (!held_.empty()) {
    joined = std::exchange(held_, {});
    joined.append(piece);
    piece = joined;
  }
  while (step(piece)) {
  }
  held_ = piece;
}

// One step on; false when more must come for the next.
bool MultipartReader::step(std::string_view& rest) {
  switch (state_) {
    case State::kStart:
      return start(rest);
    case State::kPreamble:
      return skip_preamble(rest);
    case State::kBoundaryEnd:
      return end_boundary(rest);
    case State::kHead:
      return read_head(rest);
    case State::kBodyStart:
      return begin_body(rest);
    case State::kBody:
      return pass_body(rest);
    case State::kEpilogue:
      rest = {};
      return false;
  }
  return false;
}

// The first boundary may stand without a line end before it.
bool MultipartReader::start(std::string_view& rest) {
  const std::string_view first = std::string_view(delimiter_).substr(kLineEnd.size());
  if (may_start_with(rest, first)) return false;
  state_ = State::kPreamble;
  if (rest.starts_with(first)) {
    rest.remove_prefix(first.size());
    state_ = State::kBoundaryEnd;
  }
  return true;
}

bool MultipartReader::skip_preamble(std::string_view& rest) {
  const std::size_t at = rest.find(delimiter_);
  if (at == std::string_view::npos) {
    rest.remove_prefix(rest.size() - std::min(rest.size(), delimiter_.size() - 1));
    return false;
  }
  rest.remove_prefix(at + delimiter_.size());
  state_ = State::kBoundaryEnd;
  return true;
}

// "--" after the last one; else the line ends, perhaps behind spaces (RFC 2046: transport padding).
bool MultipartReader::end_boundary(std::string_view& rest) {
  constexpr std::string_view kLast = "--";
  if (rest.starts_with(kLast)) {
    state_ = State::kEpilogue;
    return true;
  }
  const std::size_t end = rest.find(kLineEnd);
  if (end == std::string_view::npos) {
    if (rest.size() > kMaxPaddingBytes) malformed("text after a boundary");
    return false;
  }
  if (rest.substr(0, end).find_first_not_of(" \t") != std::string_view::npos)
    malformed("text after a boundary");
  if (parts_ == max_parts_)
    fail(ErrorCode::kTooLarge, fmt::format("The multipart body has more than {} parts.", max_parts_));
  ++parts_;
  rest.remove_prefix(end + kLineEnd.size());
  state_ = State::kHead;
  return true;
}

bool MultipartReader::read_head(std::string_view& rest) {
  if (rest.starts_with(kLineEnd)) malformed("a part has no name");
  const std::size_t end = rest.find(kHeadEnd);
  if (std::min(end, rest.size()) > kMaxPartHeadBytes) malformed("a part's headers are too long");
  if (end == std::string_view::npos) return false;
  listener_.begin(part_head(rest.substr(0, end)));
  rest.remove_prefix(end + kHeadEnd.size());
  state_ = State::kBodyStart;
  return true;
}

// An empty body's delimiter begins with the line end that closed the headers.
bool MultipartReader::begin_body(std::string_view& rest) {
  const std::string_view bare = std::string_view(delimiter_).substr(kLineEnd.size());
  if (may_start_with(rest, bare)) return false;
  state_ = State::kBody;
  if (rest.starts_with(bare)) {
    rest.remove_prefix(bare.size());
    listener_.end();
    state_ = State::kBoundaryEnd;
  }
  return true;
}

bool MultipartReader::pass_body(std::string_view& rest) {
  const std::size_t at = rest.find(delimiter_);
  const bool ends = at != std::string_view::npos;
  const std::size_t known = ends ? at : rest.size() - std::min(rest.size(), delimiter_.size() - 1);
  if (known > 0) listener_.take_part(rest.substr(0, known));
  rest.remove_prefix(known);
  if (!ends) return false;
  rest.remove_prefix(delimiter_.size());
  listener_.end();
  state_ = State::kBoundaryEnd;
  return true;
}

void MultipartReader::finish() const {
  switch (state_) {
    case State::kStart:
    case State::kPreamble:
      malformed("its boundary does not occur");
    case State::kBoundaryEnd:
      malformed("text after a boundary");
    case State::kHead:
      malformed("a part's headers do not end");
    case State::kBodyStart:
    case State::kBody:
      malformed("the closing boundary is missing");
    case State::kEpilogue:
      return;
  }
}

namespace {

// Of a body that is taken in one piece, each part comes in one piece or, cut off, not to its end.
class PartCollector : public PartListener {
 public:
  std::vector<Part> parts;

  void begin(PartHead head) override { parts.push_back({std::move(head), {}}); }
  void take_part(std::string_view bytes) override { parts.back().body = bytes; }
  void end() override {}
};

}  // namespace

std::vector<Part> parse_multipart(std::string_view body, std::string_view content_type, int max_parts) {
  PartCollector collector;
  MultipartReader reader(content_type, max_parts, collector);
  reader.take(body);
  reader.finish();
  return std::move(collector.parts);
}

}  // namespace furnace
