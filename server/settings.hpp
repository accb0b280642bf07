// The table of settings: flag, environment variable, key of the file, help and documentation are all read
// from it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "server/config.hpp"

namespace furnace {

enum class SettingUnit { kText, kAddress, kChoice, kFolder, kCount, kBytes, kDuration };

struct Setting {
  using Member = std::variant<std::string Config::*, std::vector<std::string> Config::*, int Config::*,
                              std::int64_t Config::*>;

  std::string_view name;  // --name, FURNACE_NAME, "name = value"
  Member member;
  SettingUnit unit;
  std::int64_t min, max;     // kCount, kBytes, kDuration (ms)
  std::string_view choices;  // kChoice: "a|b|c"
  std::string_view help;
};

std::span<const Setting> all_settings();
const Setting* find_setting(std::string_view name);
std::string environment_name(const Setting& setting);

// Parses `text` into `config`; returns what is wrong with it, or "".
std::string assign(const Setting& setting, std::string_view text, Config& config);

// "64MiB", or bytes; none for anything else.
std::optional<std::int64_t> parse_size(std::string_view text);

// The value as the file would have it: "64MiB", "30s".
std::string value_text(const Setting& setting, const Config& config);

}  // namespace furnace
