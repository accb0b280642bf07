// What a request's bytes mean before a route sees them: negotiation, framing, multipart.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "server/byte_range.hpp"
#include "server/content_range.hpp"
#include "server/framing.hpp"
#include "server/multipart.hpp"
#include "server/negotiation.hpp"
#include "server/preferences.hpp"

namespace furnace {
namespace {

// --- negotiation
// ------------------------------------------------------------------------------------------------------

TEST(Negotiation, TheMostSpecificRangeDecides) {
  EXPECT_EQ(accept_quality("", "image/png"), 1);
  EXPECT_EQ(accept_quality("*/*", "image/png"), 1);
  EXPECT_EQ(accept_quality("image/*;q=0.5, image/png;q=0.1", "image/png"), 0.1);
  EXPECT_EQ(accept_quality("image/*;q=0.5, image/png;q=0.1", "image/x-exr"), 0.5);
  EXPECT_EQ(accept_quality("*/*, image/png;q=0", "image/png"), 0);
  EXPECT_EQ(accept_quality("IMAGE/PNG ; Q=0.25", "image/png"), 0.25);
  EXPECT_EQ(accept_quality("text/html", "image/png"), 0);
  EXPECT_EQ(accept_quality("image/p*", "image/png"), 0);
  EXPECT_EQ(accept_quality("image/png;q=nonsense", "image/png"), 0);
  EXPECT_EQ(accept_quality("image/png;q=7", "image/png"), 1);
  EXPECT_EQ(accept_quality(",,;;=,\"", "image/png"), 0);
}

TEST(Negotiation, MediaTypesAndParameters) {
  EXPECT_EQ(media_type_essence(" Application/JSON ; charset=utf-8"), "application/json");
  EXPECT_EQ(media_type_parameter("multipart/form-data; boundary=\"a;b\\\"c\"; x=y", "boundary"), "a;b\"c");
  EXPECT_EQ(media_type_parameter("multipart/form-data; BOUNDARY=abc", "boundary"), "abc");
  EXPECT_EQ(media_type_parameter("multipart/form-data", "boundary"), "");
}

TEST(Negotiation, EntityTags) {
  EXPECT_TRUE(etag_matches("\"abc\"", "abc"));
  EXPECT_TRUE(etag_matches("\"x\", W/\"abc\"", "abc"));
  EXPECT_FALSE(etag_matches("abc", "abc"));
  EXPECT_FALSE(etag_matches("\"abcd\"", "abc"));
  EXPECT_FALSE(etag_matches("*", "abc"));
  EXPECT_FALSE(etag_matches("", "abc"));
}

// --- framing
// ----------------------------------------------------------------------------------------------------------

constexpr std::int64_t kLimit = 1000;

Framing framing_of(std::map<std::string, std::string, HeaderLess> headers,
                   std::string_view version = "HTTP/1.1") {
  Request head;
  head.headers = std::move(headers);
  head.headers.emplace("Host", "h");
  return read_framing(head, version, kLimit);
}

TEST(Framing, WhatIsBelieved) {
  EXPECT_EQ(framing_of({}).refusal.status, 0);
  EXPECT_EQ(framing_of({{"content-length", "1000"}}).content_length, 1000);
  EXPECT_EQ(framing_of({{"Content-Length", "5, 5"}}).content_length, 5);
  EXPECT_TRUE(framing_of({{"Transfer-Encoding", "Chunked"}}).chunked);
  EXPECT_EQ(framing_of({{"Expect", "100-Continue"}}).refusal.status, 0);
  EXPECT_EQ(framing_of({{"Content-Encoding", "identity"}}).refusal.status, 0);
}

TEST(Framing, WhatIsRefused) {
  EXPECT_EQ(framing_of({{"Content-Length", "1001"}}).refusal.status, 413);
  for (const char* length : {"-1", "+1", "0x10", "5, 6", "5,", "1e3", "18446744073709551616", " "}) {
    EXPECT_EQ(framing_of({{"Content-Length", length}}).refusal.status, 400) << length;
  }
  EXPECT_EQ(framing_of({{"Content-Length", "5"}, {"Transfer-Encoding", "chunked"}}).refusal.status, 400);
  EXPECT_EQ(framing_of({{"Transfer-Encoding", "gzip, chunked"}}).refusal.status, 501);
  EXPECT_EQ(framing_of({{"Content-Encoding", "gzip"}}).refusal.status, 415);
  EXPECT_EQ(framing_of({{"Expect", "tea"}}).refusal.status, 417);
  EXPECT_EQ(framing_of({{"Host", "a, b"}}).refusal.status, 400);
  EXPECT_EQ(read_framing(Request{}, "HTTP/1.1", kLimit).refusal.status, 400);
  EXPECT_EQ(read_framing(Request{}, "HTTP/1.0", kLimit).refusal.status, 0);
}

TEST(Framing, RequestIds) {
  EXPECT_TRUE(is_sane_request_id("a-b_c.1"));
  EXPECT_FALSE(is_sane_request_id(""));
  EXPECT_FALSE(is_sane_request_id("a\r\nSet-Cookie: x"));
  EXPECT_FALSE(is_sane_request_id(std::string(65, 'a')));
  EXPECT_NE(new_request_id(), new_request_id());
  EXPECT_TRUE(is_sane_request_id(new_request_id()));
}

// --- preferences
// --------------------------------------------------------------------------------------------------------

TEST(Prefer, WhatTheRfcWrites) {
  using std::chrono::seconds;
  EXPECT_TRUE(parse_preferences("respond-async").respond_async);
  EXPECT_TRUE(parse_preferences("Respond-Async, wait=100").respond_async);
  EXPECT_EQ(parse_preferences("Respond-Async, wait=100").wait, seconds(100));
  EXPECT_EQ(parse_preferences(" return=minimal; foo=\"a\" , Wait = \"20\" ;x=y,wait=3").wait, seconds(20));
  EXPECT_EQ(parse_preferences("wait=0").wait, seconds(0));
  EXPECT_EQ(parse_preferences("wait=2000000000").wait, seconds(86'400));
  for (const char* other :
       {"", ",", "wait", "wait=", "wait=-1", "wait=1.5", "wait=x", "wait=99999999999", "waits=1"})
    EXPECT_FALSE(parse_preferences(other).wait) << other;
  for (const char* other :
       {"respond-async=1", "no-respond-async", "respond-asynchronously", "foo; respond-async"})
    EXPECT_FALSE(parse_preferences(other).respond_async) << other;
}

// --- parts of replies
// --------------------------------------------------------------------------------------------------------

TEST(ByteRanges, OneRangeOrTheWhole) {
  using Kind = RangeWish::Kind;
  const auto part = [](std::string_view field) {
    const RangeWish wish = wished_range(field, 10);
    EXPECT_EQ(wish.kind, Kind::kPart) << field;
    return std::pair(wish.part.first, wish.part.end);
  };
  EXPECT_EQ(part("bytes=0-0"), std::pair(0l, 1l));
  EXPECT_EQ(part("bytes=2-5"), std::pair(2l, 6l));
  EXPECT_EQ(part("bytes=2-"), std::pair(2l, 10l));
  EXPECT_EQ(part("bytes=2-99999999999999999999"), std::pair(2l, 10l));
  EXPECT_EQ(part("bytes=-3"), std::pair(7l, 10l));
  EXPECT_EQ(part("bytes=-30"), std::pair(0l, 10l));
  for (const char* none : {"bytes=10-", "bytes=10-20", "bytes=99999999999999999999-", "bytes=-0"})
    EXPECT_EQ(wished_range(none, 10).kind, Kind::kNone) << none;
  for (const char* whole : {"", "bytes", "bytes=", "bytes=-", "bytes=5-2", "bytes=0-1,3-4", "items=0-1",
                            "bytes=a-b", "bytes=1-b", "bytes= 0-1", "bytes=0-1-2", "bytes=--1"})
    EXPECT_EQ(wished_range(whole, 10).kind, Kind::kWhole) << whole;
}

TEST(ByteRanges, OnlyOfWhatStaysTheSame) {
  const auto served = [](const char* method, std::map<std::string, std::string, HeaderLess> headers,
                         std::string tag) {
    Request request;
    request.method = method;
    request.headers = std::move(headers);
    Reply reply{200, "image/png", "0123456789", {}};
    if (!tag.empty()) reply.with("ETag", std::move(tag));
    serve_range(request, reply);
    return reply;
  };
  const Reply part = served("GET", {{"Range", "bytes=2-3"}}, "\"a\"");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.headers.back(), std::pair(std::string("Content-Range"), std::string("bytes 2-3/10")));
  EXPECT_EQ(served("GET", {{"Range", "bytes=2-3"}, {"If-Range", "\"a\""}}, "\"a\"").status, 206);
  EXPECT_EQ(served("GET", {{"Range", "bytes=2-3"}, {"If-Range", "\"b\""}}, "\"a\"").status, 200);
  EXPECT_EQ(served("GET", {{"Range", "bytes=2-3"}}, "W/\"a\"").status, 200);
  EXPECT_EQ(served("GET", {{"Range", "bytes=2-3"}}, "").status, 200);
  EXPECT_EQ(served("POST", {{"Range", "bytes=2-3"}}, "\"a\"").status, 200);
  EXPECT_EQ(served("HEAD", {{"Range", "bytes=2-3"}}, "\"a\"").status, 200);
  const Reply none = served("GET", {{"Range", "bytes=10-"}}, "\"a\"");
  EXPECT_EQ(none.status, 416);
  EXPECT_EQ(none.headers.back().second, "bytes */10");
  EXPECT_EQ(served("GET", {}, "\"a\"").headers.back().first, "Accept-Ranges");
}

// --- ranges of uploads
// --------------------------------------------------------------------------------------------------------

TEST(ContentRange, IsReadStrictly) {
  const auto range = parse_content_range("bytes 5-9/12");
  ASSERT_TRUE(range);
  EXPECT_EQ(std::tuple(range->first, range->end, range->total), std::tuple(5, 10, 12));
  EXPECT_FALSE(range->only_asks());
  ASSERT_TRUE(parse_content_range("bytes */12"));
  EXPECT_TRUE(parse_content_range("bytes */12")->only_asks());
  for (const char* wrong :
       {"", "bytes", "bytes ", "bytes=0-4/5", "bytes 0-4/*", "bytes */*", "bytes */", "bytes 4-3/5",
        "bytes 0-5/5", "bytes -1-4/5", "bytes 0--4/5", "bytes +0-4/5", "bytes 0-4/5 ",
        "bytes 0-4/99999999999999999999", "bytes 0-4/-5", "Bytes 0-4/5", "bytes 0-4", "bytes 0 -4/5"})
    EXPECT_FALSE(parse_content_range(wrong)) << wrong;
}

// --- multipart
// --------------------------------------------------------------------------------------------------------

constexpr const char* kType = "multipart/form-data; boundary=B";

std::vector<Part> parts_of(std::string_view body, const char* type = kType) {
  return parse_multipart(body, type, 8);
}

ErrorCode refusal_of(std::string_view body, const char* type = kType) {
  try {
    parse_multipart(body, type, 2);
  } catch (const Error& error) {
    return error.code;
  }
  return ErrorCode::kInternal;
}

TEST(Multipart, PartsKeepTheirBytes) {
  const std::string bytes("a\0\r\n-b\r\n--", 10);
  const std::string body =
      "--B\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{}\r\n"
      "--B\r\nContent-Disposition: form-data; name=\"n\"\r\n\r\n" +
      bytes + "\r\n--B--\r\nepilogue";
  const auto parts = parts_of(body);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].head.name, "request");
  EXPECT_EQ(parts[0].body, "{}");
  EXPECT_EQ(parts[1].body, bytes);
}

TEST(Multipart, NamesAreUnquotedInAnyOrder) {
  const auto parts = parts_of(
      "preamble\r\n--B \t\r\nX: y\r\ncontent-disposition: FORM-DATA; filename=\"a \\\"b\\\".glb\"; "
      "name=f\r\n\r\nbytes\r\n--B--");
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].head.name, "f");
  EXPECT_EQ(parts[0].head.file_name, "a \"b\".glb");
  EXPECT_EQ(parts[0].body, "bytes");
}

TEST(Multipart, EmptyBodiesAndNoParts) {
  EXPECT_EQ(parts_of("--B\r\nContent-Disposition: form-data; name=a\r\n\r\n\r\n--B--")[0].body, "");
  EXPECT_EQ(parts_of("--B\r\nContent-Disposition: form-data; name=a\r\n\r\n--B--")[0].body, "");
  EXPECT_TRUE(parts_of("--B--\r\n").empty());
}

// Keeps what it hears, as text.
class Heard : public PartListener {
 public:
  std::string text;

  void begin(PartHead head) override {
    text += '<' + head.name + '|' + head.file_name + '|' + head.media_type + '>';
  }
  void take_part(std::string_view bytes) override {
    EXPECT_FALSE(bytes.empty());
    text += bytes;
  }
  void end() override { text += "</>"; }
};

TEST(Multipart, PiecesOfAnySizeGiveTheSame) {
  const std::string body =
      "preamble\r\n-\r\n--\r\n--B \t\r\nContent-Disposition: form-data; name=a; filename=f.bin\r\n"
      "Content-Type: Image/PNG; x=y\r\n\r\n\r\n--\r\n-\r\r\n--b\r\n--B\r\nContent-Disposition: form-data; "
      "name=empty\r\n\r\n--B\r\nContent-Disposition: form-data; name=c\r\n\r\n\r\n\r\n--B--\r\n--B\r\n";
  for (std::size_t size = 1; size <= body.size(); ++size) {
    Heard heard;
    MultipartReader reader(kType, 3, heard);
    for (std::size_t at = 0; at < body.size(); at += size)
      reader.take(std::string_view(body).substr(at, size));
    reader.finish();
    EXPECT_EQ(heard.text, "<a|f.bin|image/png>\r\n--\r\n-\r\r\n--b</><empty||></><c||>\r\n</>") << size;
  }
}

TEST(Multipart, EveryBodyThatIsCutOffIsRefused) {
  const std::string body = "--B\r\nContent-Disposition: form-data; name=a\r\n\r\nx\r\n--B--";
  for (std::size_t size = 0; size < body.size(); ++size)
    EXPECT_EQ(refusal_of(body.substr(0, size)), ErrorCode::kInvalidRequest) << size;
}

TEST(Multipart, MalformedBodiesAreRefused) {
  const std::string part = "--B\r\nContent-Disposition: form-data; name=a\r\n\r\nx\r\n";
  EXPECT_EQ(refusal_of(part + "--B--", "multipart/form-data"), ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of(part + "--B--", "multipart/form-data; boundary="), ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of(part), ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of(""), ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of("--B"), ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of("--B\r\n\r\nx\r\n--B--"), ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of("--B\r\nContent-Disposition: attachment; name=a\r\n\r\nx\r\n--B--"),
            ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of("--B\r\nContent-Disposition\r\n\r\nx\r\n--B--"), ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of("--B\r\nX: " + std::string(9000, 'x') + "\r\n\r\nx\r\n--B--"),
            ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of(part + part + part + "--B--"), ErrorCode::kTooLarge);
}

// Bodies by others, valid, odd and broken: parsed or refused, nothing else.
TEST(Multipart, OthersBodies) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::current_path().parent_path() / "shared/data/malformed/http-multipart";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no development data at " << folder;
  int parsed = 0, refused = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string body{std::istreambuf_iterator<char>(file), {}};
    const std::string boundary =
        body.starts_with("--") ? body.substr(2, body.find_first_of("\r\n") - 2) : "B";
    try {
      parse_multipart(body, "multipart/form-data; boundary=\"" + boundary + '"', 64);
      ++parsed;
    } catch (const Error& error) {
      EXPECT_TRUE(error.code == ErrorCode::kInvalidRequest || error.code == ErrorCode::kTooLarge)
          << entry.path();
      ++refused;
    }
  }
  EXPECT_GT(parsed + refused, 0);
}

}  // namespace
}  // namespace furnace
