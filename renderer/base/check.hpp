// FURNACE_CHECK: for our own mistakes, in every build. A user's mistake is `fail` (error.hpp).
#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace furnace::detail {

[[noreturn]] inline void check_failed(const char* expression, const std::string& values,
                                      const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  fmt::print(stderr, "FURNACE_CHECK({}) failed at {}:{}: {}\n", expression, file, line, values);
  std::fflush(stderr);
  std::abort();
}

}  // namespace furnace::detail

// Aborts unless `condition`; the rest is an fmt string that shows the values concerned.
// Example: FURNACE_CHECK(index < size, "index {} of {}", index, size);
#define FURNACE_CHECK(condition, ...)                                          \
  do {                                                                         \
    if (!(condition)) [[unlikely]]                                             \
      ::furnace::detail::check_failed(#condition, ::fmt::format(__VA_ARGS__)); \
  } while (false)
