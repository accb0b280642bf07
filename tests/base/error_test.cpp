#include "renderer/base/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

namespace furnace {
namespace {

TEST(Error, GathersBreadcrumbsInnermostFirst) {
  try {
    with_context("scene", [] {
      with_context("texture 3", [] { fail(ErrorCode::kUnprocessable, "broken", "/images/3", "zlib -3"); });
    });
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    EXPECT_EQ(error.message, "broken");
    EXPECT_EQ(error.pointer, "/images/3");
    EXPECT_EQ(error.detail, "zlib -3");
    EXPECT_THAT(error.context, testing::ElementsAre("texture 3", "scene"));
  }
}

TEST(Error, ContextPassesResultsThrough) {
  EXPECT_EQ(with_context("x", [] { return std::string("result"); }), "result");
}

TEST(Error, CodesHaveNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (int code = 0; code <= static_cast<int>(ErrorCode::kStorage); ++code) {
    names.insert(error_code_name(static_cast<ErrorCode>(code)));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(ErrorCode::kStorage) + 1);
}

}  // namespace
}  // namespace furnace
