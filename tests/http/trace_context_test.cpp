#include "server/trace_context.hpp"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace furnace {
namespace {

using ::testing::MatchesRegex;

constexpr std::string_view kTrace = "4bf92f3577b34da6a3ce929d0e0e4736", kParent = "00f067aa0ba902b7";

TEST(TraceContext, GoesOnWithWhatIsValid) {
  struct Row {
    std::string_view field;
    unsigned flags;
  };
  for (const Row& row : {
           Row{"00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01", 1},
           {"00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-00", 0},
           {"00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-03", 3},
           {"00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-fd", 1},  // unknown flags
           // Versions to come.
           {"cc-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01", 1},
           {"01-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01-", 1},
           {"cc-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01-what-the-future-will-be-like", 1},
       }) {
    const TraceContext context = trace_of(row.field);
    EXPECT_EQ(context.trace_id, kTrace) << row.field;
    EXPECT_EQ(context.parent_id, kParent) << row.field;
    EXPECT_EQ(context.flags, row.flags) << row.field;
    EXPECT_THAT(context.span_id, MatchesRegex("[0-9a-f]{16}"));
    EXPECT_NE(context.span_id, kParent);
    EXPECT_EQ(context.text(),
              "00-" + std::string(kTrace) + "-" + context.span_id + "-0" + std::to_string(row.flags));
  }
}

TEST(TraceContext, BeginsAnewInsteadOfWhatIsNot) {
  for (const std::string_view field : {
           "",
           "00",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-0",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01-",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01-what-the-future-will-be-like",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-010",
           "cc-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01.what-the-future-will-not-be-like",
           "ff-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
           "0x-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
           "00-00000000000000000000000000000000-00f067aa0ba902b7-01",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-0000000000000000-01",
           "00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00F067AA0BA902B7-01",
           "00-4bf92f3577b34da6a3ce929d0e0e473.-00f067aa0ba902b7-01",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b.-01",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-.0",
           "00-4bf92f3577b34da6a3ce929d0e0e473-000f067aa0ba902b7-01",
           "00_4bf92f3577b34da6a3ce929d0e0e4736_00f067aa0ba902b7_01",
           // Two fields, as the server joins them.
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01, "
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
       }) {
    const TraceContext context = trace_of(field);
    EXPECT_NE(context.trace_id, kTrace) << field;
    EXPECT_THAT(context.text(), MatchesRegex("00-[0-9a-f]{32}-[0-9a-f]{16}-02")) << field;
    EXPECT_EQ(context.parent_id, "");
    EXPECT_NE(context.trace_id, trace_of(field).trace_id);
  }
}

}  // namespace
}  // namespace furnace
