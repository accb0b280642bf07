#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "renderer/gl/context.hpp"
#include "api/document.hpp"
#include "server/commands/commands.hpp"

namespace furnace {
namespace {

bool anything_works(const gl::DoctorReport& report) {
  return std::ranges::any_of(report.devices, &gl::DeviceReport::usable);
}

std::string json_text(std::string_view text) {
  return api::quoted(text, text.size());
}

void print_json(const gl::DoctorReport& report) {
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
  fmt::print("]}}\n");
}

void print_fact(std::string_view name, std::string_view value) {
  if (!value.empty()) fmt::print("    {:<9} {}\n", name, value);
}

void print_table(const gl::DoctorReport& report) {
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
  fmt::print("\n{}\n", anything_works(report)
                           ? "Furnace can draw on this machine."
                           : "Furnace cannot draw on this machine: no device gives a GL 4.5 context.");
  for (const std::string& advice : report.advice) fmt::print("- {}\n", advice);
}

}  // namespace

Command doctor_command(CLI::App& root) {
  CLI::App* options =
      root.add_subcommand("doctor", "Tries every EGL device, says what works and how to mend what does not");
  const auto json = std::make_shared<bool>(false);
  options->add_flag("--json", *json, "print JSON");
  return {options, [json] {
            const gl::DoctorReport report = gl::examine_devices();
            *json ? print_json(report) : print_table(report);
            return anything_works(report) ? kDone : kFailed;
          }};
}

}  // namespace furnace
