// A headless OpenGL 4.5 core context through EGL: a GPU device first, then Mesa's surfaceless platform. No display, ever.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace furnace::gl {

enum class Determinism {
  kFast,   // the driver's native speed: same bytes on one machine
  kExact,  // the software rasteriser with fixed vector width and CPU features: same bytes on any x86-64 with the same Mesa
};

struct ContextConfig {
  std::string device = "auto";  // auto | software | EGL device index | PCI address such as 0000:3b:00.0
  Determinism determinism = Determinism::kFast;
};

// One way to a context that was tried.
struct DeviceReport {
  std::string selector;                   // what to give as ContextConfig::device: "0", "software"
  std::string platform;                   // "EGL device" or "surfaceless"
  std::string pci;                        // "" when unknown
  std::string drm_node;                   // "" when none
  std::string vendor, renderer, version;  // GL strings, when a context came up
  bool software = false;
  bool usable = false;
  std::string problem;  // why not usable, and what to do
};

// Everything `furnace doctor` shows: every EGL device and the surfaceless platform, each tried for a context.
// Threads: any that has no current context.
struct DoctorReport {
  std::vector<DeviceReport> devices;
  std::vector<std::string> advice;  // what to install or change when nothing, or only software, works
};
DoctorReport examine_devices();

// Sets the software rasteriser's pins for kExact in this process's environment. Call once in main, before any EGL call
// and before any thread: the driver reads them when it loads.
void apply_determinism(Determinism determinism);

struct Limits {
  int max_texture_px = 0;
  std::size_t max_buffer_texels = 0;
  float max_line_width = 1;  // 1 in forward-compatible contexts
  bool software = false;
};

// Permission to call GL: whoever holds a Context& is on its thread with it current.
// Threads: the one that made it. Owns: the EGL context; destroys it.
class Context {
 public:
  // Errors: kGpuUnavailable; the message names each device tried and points to `furnace doctor`.
  static std::unique_ptr<Context> create(const ContextConfig& config);
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const Limits& limits() const;
  const std::string& renderer() const;  // GL_RENDERER
  const std::string& version() const;   // GL_VERSION
  // True after a GPU reset (robustness): every object is gone and the context must be rebuilt.
  bool lost() const;

 private:
  struct State;
  explicit Context(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace furnace::gl
