#include "renderer/base/deadline.hpp"

#include "renderer/base/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace furnace {
namespace {

using std::chrono::milliseconds;

Error error_of(const Deadline& deadline) {
  try {
    check_deadline(deadline, "drawing");
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

TEST(Deadline, NeverPassesByDefault) {
  EXPECT_FALSE(Deadline().passed());
  EXPECT_NO_THROW(check_deadline(Deadline(), "drawing"));
}

TEST(Deadline, PassesWithTime) {
  EXPECT_FALSE(Deadline(milliseconds(3'600'000)).passed());
  const Error error = error_of(Deadline(milliseconds(0)));
  EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
  EXPECT_THAT(error.message, testing::HasSubstr("drawing"));
}

TEST(Deadline, PassesWhenCancelled) {
  std::stop_source client;
  const Deadline deadline(milliseconds(3'600'000), client.get_token());
  EXPECT_FALSE(deadline.passed());
  client.request_stop();
  EXPECT_TRUE(deadline.passed());
  EXPECT_THAT(error_of(deadline).message, testing::HasSubstr("cancelled"));
}

}  // namespace
}  // namespace furnace
