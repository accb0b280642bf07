#include "api/problem.hpp"

#include <gtest/gtest.h>

#include <set>

#include "api/document.hpp"

namespace furnace::api {
namespace {

constexpr ErrorCode kCodes[] = {
    ErrorCode::kInvalidRequest, ErrorCode::kNotFound,       ErrorCode::kMethodNotAllowed,
    ErrorCode::kNotAcceptable,  ErrorCode::kTooLarge,       ErrorCode::kUnsupportedMedia,
    ErrorCode::kUnprocessable,  ErrorCode::kOverloaded,     ErrorCode::kInternal,
    ErrorCode::kBadGateway,     ErrorCode::kGpuUnavailable, ErrorCode::kDeadlineExceeded,
    ErrorCode::kStorage,
};

TEST(Problem, EachCodeHasItsStatus) {
  const int statuses[] = {400, 404, 405, 406, 413, 415, 422, 429, 500, 502, 503, 504, 507};
  for (std::size_t i = 0; i < std::size(kCodes); ++i) EXPECT_EQ(http_status(kCodes[i]), statuses[i]);
}

TEST(Problem, EachCodeHasItsTypeAndTitle) {
  std::set<std::string> types, titles;
  for (const ErrorCode code : kCodes) {
    Error error;
    error.code = code;
    error.message = "what happened";
    const Document document = Document::parse(problem_json(error, "id"), {});
    const Value problem = document.root();
    types.emplace(problem["type"].text());
    titles.emplace(problem["title"].text());
    EXPECT_EQ(problem["status"].integer(), http_status(code));
    EXPECT_EQ(problem["title"].text(), problem_title(code));
    EXPECT_EQ(problem["detail"].text(), "what happened");
    EXPECT_EQ(problem["instance"].text(), "id");
    EXPECT_FALSE(problem["pointer"]);
    EXPECT_FALSE(problem["errors"]);
  }
  EXPECT_EQ(types.size(), std::size(kCodes));
  EXPECT_EQ(titles.size(), std::size(kCodes));
  EXPECT_TRUE(types.contains("/problems/too-large"));
}

TEST(Problem, PrivateHalvesDoNotLeak) {
  Error error{ErrorCode::kInternal, "public", "", "secret-detail", {}, {"secret-context"}};
  EXPECT_EQ(problem_json(error, "id").find("secret"), std::string::npos);
}

TEST(Problem, CarriesPointerAndAllProblems) {
  Error error{ErrorCode::kUnprocessable, "two", "/a", "", {{"/a", "first"}, {"/b~1c", "second"}}, {}};
  const Document document = Document::parse(problem_json(error, ""), {});
  const Value problem = document.root();
  EXPECT_FALSE(problem["instance"]);
  EXPECT_EQ(problem["pointer"].text(), "/a");
  ASSERT_EQ(problem["errors"].size(), 2u);
  EXPECT_EQ(problem["errors"].at(1)["pointer"].text(), "/b~1c");
  EXPECT_EQ(problem["errors"].at(1)["detail"].text(), "second");
}

TEST(Problem, BytesThatAreNotUtf8StayJson) {
  Error error;
  error.message = "no part \"\xFF\xFE\"";
  EXPECT_NO_THROW(Document::parse(problem_json(error, "\x80"), {}));
}

}  // namespace
}  // namespace furnace::api
