#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "renderer/base/log.hpp"
#include "renderer/gl/context.hpp"
#include "api/document.hpp"
#include "server/commands/commands.hpp"
#include "server/decoders.hpp"

namespace furnace {
namespace {

bool anything_works(const gl::DoctorReport& report) {
  return std::ranges::any_of(report.devices, &gl::DeviceReport::usable);
}

std::string json_text(std::string_view text) {
  return api::quoted(text, text.size());
}

// What the system does not allow to take from a child that decodes; empty: nothing.
std::string sandbox_problem() {
  log::set_level(log::Level::kError);  // it is told below
  Config config;
  config.decoders = 1;
  try {
    return Decoders(config).processes()->sandbox_problem();
  } catch (const Error& error) {
    return error.message + ": " + error.detail;
  }
}

void print_json(const gl::DoctorReport& report, const std::string& decoders_problem) {
  fmt::print("{{\"usable\": {}, \"devices\": [", anything_works(report));
  std::string_view separator = "\n";
  for (const gl::DeviceReport& device : report.devices) {
    fmt::print(
        "{}  {{\"selector\": {}, \"platform\": {}, \"pci\": {}, \"drmNode\": {}, \"vendor\": {}, "
        "\"renderer\": {}, "
        "\"version\": {}, \"software\": {}, \"usable\": {}, \"problem\": {}}}",
        separator, json_text(device.selector), json_text(device.platform), json_text(device.pci),
        json_text(device.drm_node), json_text(device.vendor), json_text(device.renderer),
        json_text(device.version), device.software, device.usable, json_text(device.problem));
    separator = ",\n";
  }
  fmt::print("\n], \"advice\": [");
  separator = "";
  for (const std::string& advice : report.advice) {
    fmt::print("{}{}", separator, json_text(advice));
    separator = ", ";
  }
  fmt::print("], \"decoders\": {{\"sandboxed\": {}, \"problem\": {}}}}}\n", decoders_problem.empty(),
             json_text(decoders_problem));
}

void print_fact(std::string_view name, std::string_view value) {
  if (!value.empty()) fmt::print("    {:<9} {}\n", name, value);
}

void print_table(const gl::DoctorReport& report, const std::string& decoders_problem) {
  for (const gl::DeviceReport& device : report.devices) {
    fmt::print("[{}] --device {:<10} {}{}\n", device.usable ? "works" : "fails", device.selector,
               device.platform, device.software ? ", software" : "");
    print_fact("renderer", device.renderer);
    print_fact("vendor", device.vendor);
    print_fact("version", device.version);
    print_fact("pci", device.pci);
    print_fact("node", device.drm_node);
    print_fact("problem", device.problem);
  }
  fmt::print("[{}] sandbox of the processes that decode\n", decoders_problem.empty() ? "works" : "fails");
  print_fact("problem", decoders_problem);
  fmt::print("\n{}\n", anything_works(report)
                           ? "Furnace can draw on this machine."
                           : "Furnace cannot draw on this machine: no device gives a GL 4.5 context.");
  for (const std::string& advice : report.advice) fmt::print("- {}\n", advice);
}

}  // namespace

Command doctor_command(CLI::App& root) {
  CLI::App* options = root.add_subcommand(
      "doctor",
      "Tries every EGL device and the decoders' sandbox, says what works and how to mend what does not");
  const auto json = std::make_shared<bool>(false);
  options->add_flag("--json", *json, "print JSON");
  return {options, [json] {
            const gl::DoctorReport report = gl::examine_devices();
            const std::string decoders_problem = sandbox_problem();
            *json ? print_json(report, decoders_problem) : print_table(report, decoders_problem);
            return anything_works(report) ? kDone : kFailed;
          }};
}

}  // namespace furnace
