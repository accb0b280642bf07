#include "server/config.hpp"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/settings.hpp"

namespace furnace {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

LoadedConfig from_file(std::string text) {
  return load_config({.file_text = std::move(text), .environment = {}, .flags = {}});
}

TEST(Config, DefaultsAreValid) {
  const LoadedConfig loaded = load_config({});
  EXPECT_THAT(loaded.problems, IsEmpty());
  EXPECT_THAT(loaded.warnings, IsEmpty());
}

TEST(Config, EveryDefaultIsAValueOfItsOwnSetting) {
  for (const Setting& setting : all_settings()) {
    Config config;
    const std::string text = value_text(setting, config);
    EXPECT_EQ(assign(setting, text, config), "") << setting.name;
    EXPECT_EQ(value_text(setting, config), text) << setting.name;
    EXPECT_FALSE(setting.help.empty()) << setting.name;
  }
}

TEST(Config, FlagsBeatEnvironmentBeatsFile) {
  const LoadedConfig loaded = load_config({.file_text = "queue = 1\nseats = 1\nmax-side = 100\n",
                                           .environment = {{"FURNACE_QUEUE", "2"}, {"FURNACE_SEATS", "2"}},
                                           .flags = {{"queue", "3"}}});
  EXPECT_THAT(loaded.problems, IsEmpty());
  EXPECT_EQ(loaded.config.queue, 3);
  EXPECT_EQ(loaded.config.seats, 2);
  EXPECT_EQ(loaded.config.max_side_px, 100);
  EXPECT_EQ(loaded.origins.at("queue"), "flag");
  EXPECT_EQ(loaded.origins.at("seats"), "environment");
  EXPECT_EQ(loaded.origins.at("max-side"), "file");
  EXPECT_EQ(loaded.origins.at("max-area"), "default");
}

TEST(Config, AHigherSourceReplacesAList) {
  const LoadedConfig loaded = load_config(
      {.file_text = "assets = /usr\n", .environment = {{"FURNACE_ASSETS", "/etc:/tmp"}}, .flags = {}});
  EXPECT_THAT(loaded.config.assets, ElementsAre("/etc", "/tmp"));
  const LoadedConfig flags = load_config(
      {.file_text = "assets = /usr\n", .environment = {}, .flags = {{"assets", "/etc"}, {"assets", "/tmp"}}});
  EXPECT_THAT(flags.config.assets, ElementsAre("/etc", "/tmp"));
}

TEST(Config, AllProblemsAreToldAtOnce) {
  const LoadedConfig loaded =
      load_config({.file_text = "nonsense\nno-such = 1\nqueue = many\n",
                   .environment = {{"FURNACE_TIMEOUT", "0s"}, {"FURNACE_LISTEN", "8080"}},
                   .flags = {{"determinism", "sometimes"}, {"assets", "/no/such/folder"}}});
  EXPECT_EQ(loaded.problems.size(), 7u);
  EXPECT_THAT(loaded.problems, Contains(HasSubstr("line 1")));
  EXPECT_THAT(loaded.problems, Contains(HasSubstr("no setting 'no-such'")));
  EXPECT_THAT(loaded.problems, Contains(HasSubstr("'many' is not a whole number")));
  EXPECT_THAT(loaded.problems, Contains(HasSubstr("FURNACE_TIMEOUT: 0s is outside of 1ms to 60min")));
  EXPECT_THAT(loaded.problems, Contains(HasSubstr("FURNACE_LISTEN")));
  EXPECT_THAT(loaded.problems, Contains(HasSubstr("fast|exact")));
  EXPECT_THAT(loaded.problems, Contains(HasSubstr("/no/such/folder")));
}

TEST(Config, UnknownVariablesAreWarnedOf) {
  const LoadedConfig loaded =
      load_config({.file_text = {},
                   .environment = {{"FURNACE_QUEU", "2"}, {"PATH", "/bin"}, {"FURNACE_CONFIG", "x"}},
                   .flags = {}});
  EXPECT_THAT(loaded.problems, IsEmpty());
  EXPECT_THAT(loaded.warnings, ElementsAre(HasSubstr("FURNACE_QUEU")));
}

TEST(Config, UnitsAreRead) {
  const LoadedConfig loaded =
      from_file("max-body = 3MiB\nmax-bodies = 1GiB\nmax-json=2048\ntimeout = 250ms\ndrain-timeout=2min\n");
  EXPECT_THAT(loaded.problems, IsEmpty());
  EXPECT_EQ(loaded.config.max_body_bytes, 3ll << 20);
  EXPECT_EQ(loaded.config.max_json_bytes, 2048);
  EXPECT_EQ(loaded.config.timeout_ms, 250);
  EXPECT_EQ(loaded.config.drain_timeout_ms, 120'000);
  // A bare number has no unit of time, a wrong or overflowing one is not a size.
  EXPECT_EQ(from_file("timeout = 30\n").problems.size(), 1u);
  EXPECT_EQ(from_file("max-body = 3MB\n").problems.size(), 1u);
  EXPECT_EQ(from_file("max-body = 9223372036854775807GiB\n").problems.size(), 1u);
}

TEST(Config, ThePrintedConfigurationIsAConfigurationFile) {
  const LoadedConfig first =
      from_file("queue = 7\nmax-body = 3MiB\nadmin-listen = 127.0.0.1:0\n# comment\n\n");
  const LoadedConfig second = from_file(print_config(first));
  EXPECT_THAT(second.problems, IsEmpty());
  for (const Setting& setting : all_settings()) {
    EXPECT_EQ(value_text(setting, second.config), value_text(setting, first.config)) << setting.name;
  }
}

TEST(Config, AnOpenAddressNeedsKeysOrAWord) {
  EXPECT_THAT(from_file("listen = 0.0.0.0:8080\n").problems, ElementsAre(HasSubstr("allow-anonymous")));
  const LoadedConfig anonymous = from_file("listen = 0.0.0.0:8080\nallow-anonymous = on\n");
  EXPECT_THAT(anonymous.problems, IsEmpty());
  EXPECT_THAT(anonymous.warnings, ElementsAre(HasSubstr("no API keys")));
  const LoadedConfig keys = from_file("listen = 0.0.0.0:8080\napi-keys-file = keys\n");
  EXPECT_THAT(keys.problems, IsEmpty());
  EXPECT_THAT(keys.warnings, IsEmpty());
  EXPECT_THAT(from_file("admin-listen = 0.0.0.0:8081\n").warnings, ElementsAre(HasSubstr("0.0.0.0:8081")));
  for (const char* near : {"listen = [::1]:8080\n", "listen = localhost:8080\nallow-anonymous = on\n"}) {
    EXPECT_THAT(from_file(near).problems, IsEmpty());
    EXPECT_THAT(from_file(near).warnings, IsEmpty());
  }
}

TEST(Config, Origins) {
  EXPECT_THAT(from_file("cors-origins = https://example.com,http://localhost:3000\n").problems, IsEmpty());
  EXPECT_THAT(from_file("cors-origins = example.com\n").problems, ElementsAre(HasSubstr("cors-origins")));
}

TEST(Config, SettingsThatContradictEachOther) {
  EXPECT_EQ(from_file("max-body = 64MiB\nmax-bodies = 1MiB\n").problems.size(), 1u);
  EXPECT_EQ(from_file("determinism = exact\ndevice = 0\n").problems.size(), 1u);
  EXPECT_EQ(from_file("listen =\n").problems.size(), 1u);
}

TEST(Config, Addresses) {
  EXPECT_EQ(parse_address("127.0.0.1:8080")->port, 8080);
  EXPECT_EQ(parse_address("[::1]:0")->host, "::1");
  EXPECT_EQ(parse_address("localhost:65535")->port, 65535);
  for (const char* wrong :
       {"", ":80", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "::1:80", "h:8x"}) {
    EXPECT_FALSE(parse_address(wrong)) << wrong;
  }
}

TEST(Config, EnvironmentNames) {
  EXPECT_EQ(environment_name(*find_setting("max-body")), "FURNACE_MAX_BODY");
}

}  // namespace
}  // namespace furnace
