#include "renderer/gl/context.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/gl/driver.hpp"
#include "renderer/gl/egl.hpp"
#include "renderer/gl/gl.hpp"

namespace furnace::gl {
namespace {

std::string gl_string(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text == nullptr ? std::string() : std::string(text);
}

bool is_software_renderer(const std::string& renderer) {
  return renderer.find("llvmpipe") != std::string::npos || renderer.find("softpipe") != std::string::npos;
}

bool matches(const Candidate& candidate, const std::string& device) {
  if (device == "auto") return true;
  if (device == "software") return candidate.software;
  return candidate.selector == device || (!candidate.pci.empty() && candidate.pci == device);
}

bool file_exists(const char* path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

std::vector<std::string> advise(const DoctorReport& report, const std::string& list_problem) {
  bool any = false, hardware = false;
  for (const DeviceReport& device : report.devices) {
    any = any || device.usable;
    hardware = hardware || (device.usable && !device.software);
  }
  std::vector<std::string> advice;
  if (!list_problem.empty()) advice.push_back(list_problem);
  const bool nvidia = file_exists("/proc/driver/nvidia/version") || file_exists("/dev/nvidia0");
  const bool nvidia_vendor = file_exists("/usr/share/glvnd/egl_vendor.d/10_nvidia.json") ||
                             file_exists("/etc/glvnd/egl_vendor.d/10_nvidia.json");
  if (!hardware && nvidia && !nvidia_vendor) {
    advice.emplace_back(
        "An NVIDIA GPU is here but its EGL vendor file 10_nvidia.json is not: install the driver's EGL "
        "library "
        "(libnvidia-egl / libnvidia-gl), or in a container run with "
        "NVIDIA_DRIVER_CAPABILITIES=graphics,utility.");
  }
  if (!hardware && !nvidia && !file_exists("/dev/dri")) {
    advice.emplace_back(
        "No GPU is visible (no /dev/dri, no NVIDIA driver). In a container pass one with --device /dev/dri "
        "or --gpus all; "
        "without a GPU the software rasteriser serves.");
  }
  if (!hardware && file_exists("/dev/dri/renderD128") && !nvidia) {
    advice.emplace_back(
        "/dev/dri/renderD128 exists: if its device is listed above as failing, add this user to the group "
        "`render` "
        "and install the GPU's Mesa driver.");
  }
  if (!any) {
    advice.emplace_back(
        "For the software rasteriser install Mesa: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri");
  }
  return advice;
}

}  // namespace

struct Context::State {
  Connection connection;
  Limits limits;
  std::string renderer;
  std::string version;
};

void apply_determinism(Determinism determinism) {
  if (determinism != Determinism::kExact) return;
  // llvmpipe compiles for the host CPU; a fixed vector width and a fixed feature set give every x86-64 the same code.
  setenv("LP_NATIVE_VECTOR_WIDTH", "128", 1);
  setenv("GALLIUM_OVERRIDE_CPU_CAPS", "sse4.1", 1);
}

DoctorReport examine_devices() {
  DoctorReport report;
  const CandidateList list = list_candidates();
  for (const Candidate& candidate : list.candidates) {
    DeviceReport device;
    device.selector = candidate.selector;
    device.platform = candidate.platform;
    device.pci = candidate.pci;
    device.drm_node = candidate.drm_node;
    device.software = candidate.software;
    const Connection connection = connect(candidate);
    device.usable = connection.usable();
    device.problem = connection.problem;
    if (connection.usable()) {
      device.vendor = gl_string(GL_VENDOR);
      device.renderer = gl_string(GL_RENDERER);
      device.version = gl_string(GL_VERSION);
      device.software = device.software || is_software_renderer(device.renderer);
      disconnect(connection);
    }
    report.devices.push_back(std::move(device));
  }
  report.advice = advise(report, list.problem);
  return report;
}

std::unique_ptr<Context> Context::create(const ContextConfig& config) {
  const CandidateList list = list_candidates();
  // Exact pixels exist on the software rasteriser only.
  const bool exact = config.determinism == Determinism::kExact;
  std::string tried;
  for (const Candidate& candidate : list.candidates) {
    if (!matches(candidate, config.device) || (exact && !candidate.software)) continue;
    auto state = std::make_unique<State>();
    state->connection = connect(candidate);
    if (!state->connection.usable()) {
      tried += fmt::format("; {} {}: {}", candidate.platform, candidate.selector, state->connection.problem);
      continue;
    }
    state->renderer = gl_string(GL_RENDERER);
    state->version = gl_string(GL_VERSION);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &state->limits.max_texture_px);
    std::array<GLfloat, 2> widths{1, 1};
    glGetFloatv(GL_ALIASED_LINE_WIDTH_RANGE, widths.data());
    GLint flags = 0;
    glGetIntegerv(GL_CONTEXT_FLAGS, &flags);
    if ((flags & GL_CONTEXT_FLAG_FORWARD_COMPATIBLE_BIT) == 0) state->limits.max_line_width = widths[1];
    GLint texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    state->limits.max_buffer_texels = std::size_t(texels);
    state->limits.software = is_software_renderer(state->renderer);
    install_debug_output();
    return std::unique_ptr<Context>(new Context(std::move(state)));
  }
  if (!list.problem.empty()) tried += "; " + list.problem;
  fail(ErrorCode::kGpuUnavailable,
       fmt::format("no OpenGL 4.5 context for device \"{}\"{}; run `furnace doctor`", config.device, tried));
}

Context::Context(std::unique_ptr<State> state) : state_(std::move(state)) {}
Context::~Context() {
  disconnect(state_->connection);
}

const Limits& Context::limits() const {
  return state_->limits;
}
const std::string& Context::renderer() const {
  return state_->renderer;
}
const std::string& Context::version() const {
  return state_->version;
}
bool Context::lost() const {
  return glGetGraphicsResetStatus() != GL_NO_ERROR;
}

}  // namespace furnace::gl
