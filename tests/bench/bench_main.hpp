// What the benchmarks share that are not Google Benchmark's: the same option for their figures, the same end on an error.
#pragma once

#include <exception>
#include <fstream>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renderer/base/error.hpp"

namespace furnace {

// `run(program)` measures and returns the figures; --benchmark_out=FILE writes them as JSON.
template <class Run>
int bench_main(int argc, char** argv, const Run& run) {
  constexpr std::string_view kOut = "--benchmark_out=";
  try {
    const auto figures = run(std::string(argv[0]));
    for (int i = 1; i < argc; ++i) {
      const std::string_view argument = argv[i];
      if (argument.starts_with(kOut))
        std::ofstream(std::string(argument.substr(kOut.size()))) << figures.dump(2) << "\n";
    }
    return 0;
  } catch (const Error& error) {
    fmt::print(stderr, "{} {}\n", error.message, error.detail);
    return 1;
  }
}

}  // namespace furnace
