// multipart/form-data (RFC 7578), piece by piece or of a body that is already in memory.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace furnace {

struct PartHead {
  std::string name;
  std::string file_name;   // "" when it is not a file
  std::string media_type;  // as sent; "" when it is not
};

// Hears of one part after the other.
class PartListener {
 public:
  virtual ~PartListener() = default;
  // Any of them may throw.
  virtual void begin(PartHead head) = 0;
  virtual void take_part(std::string_view bytes) = 0;  // not empty; the part's next
  virtual void end() = 0;
};

// Threads: one. Owns: what it cannot judge before more comes, at most a boundary's line or a part's headers.
class MultipartReader {
 public:
  // `content_type` is the whole field, with its boundary. The listener outlives it. Errors: kInvalidRequest.
  MultipartReader(std::string_view content_type, int max_parts, PartListener& listener);

  // Errors: kInvalidRequest for what is not well-formed, kTooLarge for more parts than allowed; those of the listener.
  void take(std::string_view piece);
  // After the last piece. Errors: kInvalidRequest when more must come.
  void finish() const;

 private:
  enum class State { kStart, kPreamble, kBoundaryEnd, kHead, kBodyStart, kBody, kEpilogue };

  bool step(std::string_view& rest);
  bool start(std::string_view& rest);
  bool skip_preamble(std::string_view& rest);
  bool end_boundary(std::string_view& rest);
  bool read_head(std::string_view& rest);
  bool begin_body(std::string_view& rest);
  bool pass_body(std::string_view& rest);

  const std::string delimiter_;  // with the line end before it
  const int max_parts_;
  PartListener& listener_;
  State state_ = State::kStart;
  int parts_ = 0;
  std::string held_;
};

struct Part {
  PartHead head;
  std::string_view body;  // into the request's body
};

// Errors: as MultipartReader.
std::vector<Part> parse_multipart(std::string_view body, std::string_view content_type, int max_parts);

}  // namespace furnace
