#include "renderer/base/log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <thread>
#include <vector>

namespace furnace {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

template <class Body>
std::string stderr_of(Body&& body) {
  testing::internal::CaptureStderr();
  body();
  return testing::internal::GetCapturedStderr();
}

TEST(Log, WritesOneObjectPerLine) {
  const std::string line = stderr_of([] {
    log::info("render.done",
              {{"width", 512}, {"ms", 12.5}, {"cached", true}, {"format", "png"}, {"minus", -3}});
  });
  EXPECT_THAT(line, MatchesRegex("\\{\"time\":\"[0-9-]+T[0-9:]+\\.[0-9]+Z\",\"level\":\"info\","
                                 "\"event\":\"render.done\",\"width\":512,\"ms\":12.5,\"cached\":true,"
                                 "\"format\":\"png\",\"minus\":-3\\}\n"));
}

TEST(Log, EscapesWhatClientsSend) {
  const std::string line = stderr_of([] { log::warning("x", {{"path", "a\"b\\c\nd\x01%n{}"}}); });
  EXPECT_THAT(line, HasSubstr(R"("path":"a\"b\\c\u000ad\u0001%n{}")"));
}

TEST(Log, MendsTextThatIsNotUtf8) {
  const std::string line = stderr_of([] {
    log::info("x", {{"good", "gr\xc3\xbc\xe2\x82\xac\xf0\x9f\x94\xa5"},
                    {"stray",
                     "a\xff"
                     "b\x80"},
                    {"overlong", "\xc0\xaf\xe0\x80\xaf"},
                    {"surrogate", "\xed\xa0\x80"},
                    {"beyond", "\xf4\x90\x80\x80"},
                    {"cut", "\xe2\x82"}});
  });
  EXPECT_THAT(line, HasSubstr("\"good\":\"gr\xc3\xbc\xe2\x82\xac\xf0\x9f\x94\xa5\""));
  EXPECT_THAT(line, HasSubstr(R"("stray":"a\ufffdb\ufffd")"));
  EXPECT_THAT(line, HasSubstr(R"("overlong":"\ufffd\ufffd\ufffd\ufffd\ufffd")"));
  EXPECT_THAT(line, HasSubstr(R"("surrogate":"\ufffd\ufffd\ufffd")"));
  EXPECT_THAT(line, HasSubstr(R"("beyond":"\ufffd\ufffd\ufffd\ufffd")"));
  EXPECT_THAT(line, HasSubstr(R"("cut":"\ufffd\ufffd")"));
}

TEST(Log, WritesNullForWhatIsNoNumber) {
  const std::string line = stderr_of([] {
    log::info("x", {{"nan", std::numeric_limits<double>::quiet_NaN()},
                    {"inf", -std::numeric_limits<double>::infinity()}});
  });
  EXPECT_THAT(line, HasSubstr(R"("nan":null,"inf":null)"));
}

TEST(Log, HonoursTheLevel) {
  const std::string lines = stderr_of([] {
    log::debug("d");
    log::info("i");
    log::set_level(log::Level::kError);
    log::warning("w");
    log::error("e");
    log::set_level(log::Level::kOff);
    log::error("off");
    log::set_level(log::Level::kDebug);
    log::debug("d2");
    log::set_level(log::Level::kInfo);
  });
  std::vector<std::string> events;
  for (std::size_t at = 0; (at = lines.find("event\":\"", at)) != std::string::npos;) {
    at += 8;
    events.push_back(lines.substr(at, lines.find('"', at) - at));
  }
  EXPECT_THAT(events, testing::ElementsAre("i", "e", "d2"));
}

TEST(Log, NamesTheRequestOfItsThread) {
  const std::string lines = stderr_of([] {
    const log::RequestScope outer({"r-1", "4bf92f3577b34da6a3ce929d0e0e4736", "00f067aa0ba902b7"});
    {
      const log::RequestScope inner({"r-\"2", {}, {}});
      log::info("inner");
    }
    log::info("outer");
    std::jthread([] { log::info("other"); }).join();
  });
  EXPECT_THAT(lines, HasSubstr(R"("event":"inner","request":"r-\"2"})"));
  EXPECT_THAT(
      lines,
      HasSubstr(
          R"("event":"outer","request":"r-1","trace_id":"4bf92f3577b34da6a3ce929d0e0e4736","span_id":"00f067aa0ba902b7"})"));
  EXPECT_THAT(lines, HasSubstr(R"("event":"other"})"));
  EXPECT_EQ(log::origin().request, "");
}

TEST(Log, KeepsLinesOfThreadsWhole) {
  const std::string lines = stderr_of([] {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([] {
        for (int i = 0; i < 50; ++i) log::info("line", {{"text", std::string(300, 'x')}});
      });
    }
  });
  std::size_t count = 0;
  for (std::size_t begin = 0; begin < lines.size();) {
    const std::size_t end = lines.find('\n', begin);
    ASSERT_THAT(lines.substr(begin, end - begin), MatchesRegex("\\{\"time\".*\"text\":\"x+\"\\}"));
    begin = end + 1;
    ++count;
  }
  EXPECT_EQ(count, 200u);
}

}  // namespace
}  // namespace furnace
