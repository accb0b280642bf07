#include "renderer/gl/egl.hpp"

#include <climits>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>

#include <fmt/format.h>

namespace furnace::gl {
namespace {

bool has_extension(const char* list, const char* name) {
  const std::size_t length = std::strlen(name);
  for (const char* at = list; at != nullptr && (at = std::strstr(at, name)) != nullptr; at += length) {
    const bool starts = at == list || at[-1] == ' ';
    if (starts && (at[length] == ' ' || at[length] == '\0')) return true;
  }
  return false;
}

const char* client_extensions() {
  return eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
}

template <class Function>
Function egl_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

// "/dev/dri/card0" -> "0000:3b:00.0", by the kernel's device link.
std::string pci_of_drm(const std::string& node) {
  std::error_code ignored;
  const auto name = std::filesystem::path(node).filename();
  const auto link = std::filesystem::read_symlink("/sys/class/drm" / name / "device", ignored);
  return ignored ? std::string() : link.filename().string();
}

std::string device_string(EGLDeviceEXT device, EGLint name) {
  const auto query = egl_function<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  const char* text = query == nullptr ? nullptr : query(device, name);
  return text == nullptr ? std::string() : std::string(text);
}

Candidate describe_device(EGLDeviceEXT device, int index) {
  Candidate candidate;
  candidate.selector = std::to_string(index);
  candidate.platform = "EGL device";
  candidate.device = device;
  const std::string extensions = device_string(device, EGL_EXTENSIONS);
  candidate.software = has_extension(extensions.c_str(), "EGL_MESA_device_software");
  if (has_extension(extensions.c_str(), "EGL_EXT_device_drm")) {
    candidate.drm_node = device_string(device, EGL_DRM_DEVICE_FILE_EXT);
    candidate.pci = pci_of_drm(candidate.drm_node);
  }
  return candidate;
}

EGLDisplay open_display(const Candidate& candidate) {
  const auto get_display = egl_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (get_display == nullptr) return EGL_NO_DISPLAY;
  if (candidate.device != EGL_NO_DEVICE_EXT) {
    return get_display(EGL_PLATFORM_DEVICE_EXT, candidate.device, nullptr);
  }
  return get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

EGLContext create_core_context(EGLDisplay display) {
  constexpr EGLint kConfig[] = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                EGL_NONE};
  EGLConfig config = EGL_NO_CONFIG_KHR;
  EGLint count = 0;
  if (eglChooseConfig(display, kConfig, &config, 1, &count) != EGL_TRUE || count == 0)
    config = EGL_NO_CONFIG_KHR;
  const bool robust =
      has_extension(eglQueryString(display, EGL_EXTENSIONS), "EGL_EXT_create_context_robustness");
  for (const bool with_robustness : {true, false}) {
    if (with_robustness && !robust) continue;
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 with_robustness ? EGL_CONTEXT_OPENGL_ROBUST_ACCESS : EGL_NONE,
                                 EGL_TRUE,
                                 EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                                 EGL_LOSE_CONTEXT_ON_RESET,
                                 EGL_NONE};
    const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
    if (context != EGL_NO_CONTEXT) return context;
  }
  return EGL_NO_CONTEXT;
}

// A display is the process's, and eglTerminate ends what all threads have of it: the last to leave terminates it.
class OpenDisplays {
 public:
  bool enter(EGLDisplay display) {
    const std::lock_guard lock(mutex_);
    if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) return false;
    ++users_[display];
    return true;
  }
  void leave(EGLDisplay display) {
    const std::lock_guard lock(mutex_);
    if (--users_[display] == 0) eglTerminate(display);
  }

 private:
  std::mutex mutex_;
  std::map<EGLDisplay, int> users_;
};

OpenDisplays& open_displays() {
  static OpenDisplays displays;
  return displays;
}

}  // namespace

std::string egl_error_name(EGLint error) {
  switch (error) {
    case EGL_SUCCESS:
      return "EGL_SUCCESS";
    case EGL_NOT_INITIALIZED:
      return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS:
      return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC:
      return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE:
      return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG:
      return "EGL_BAD_CONFIG";
    case EGL_BAD_DISPLAY:
      return "EGL_BAD_DISPLAY";
    case EGL_BAD_MATCH:
      return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER:
      return "EGL_BAD_PARAMETER";
    default:
      return fmt::format("EGL error 0x{:04x}", error);
  }
}

CandidateList list_candidates() {
  CandidateList list;
  const char* extensions = client_extensions();
  std::vector<Candidate> software;
  if (has_extension(extensions, "EGL_EXT_device_enumeration") ||
      has_extension(extensions, "EGL_EXT_device_base")) {
    const auto query_devices = egl_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    EGLint count = 0;
    if (query_devices != nullptr && query_devices(0, nullptr, &count) == EGL_TRUE && count > 0) {
      std::vector<EGLDeviceEXT> devices(std::size_t(count), EGL_NO_DEVICE_EXT);
      query_devices(count, devices.data(), &count);
      for (int i = 0; i < count; ++i) {
        Candidate candidate = describe_device(devices[std::size_t(i)], i);
        (candidate.software ? software : list.candidates).push_back(std::move(candidate));
      }
    } else {
      list.problem = "EGL lists no devices (" + egl_error_name(eglGetError()) + ")";
    }
  } else {
    list.problem = "this EGL cannot list devices (no EGL_EXT_device_enumeration)";
  }
  if (has_extension(extensions, "EGL_MESA_platform_surfaceless")) {
    Candidate surfaceless;
    surfaceless.selector = "software";
    surfaceless.platform = "surfaceless";
    surfaceless.software = true;
    list.candidates.push_back(std::move(surfaceless));
  }
  for (Candidate& candidate : software) list.candidates.push_back(std::move(candidate));
  return list;
}

Connection connect(const Candidate& candidate) {
  Connection connection;
  // The surfaceless platform would take a GPU where there is one: "software" must mean it.
  if (candidate.platform == "surfaceless") setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  connection.display = open_display(candidate);
  if (connection.display == EGL_NO_DISPLAY) {
    connection.problem = "no display: " + egl_error_name(eglGetError());
    return connection;
  }
  if (!open_displays().enter(connection.display)) {
    connection.problem = "eglInitialize failed: " + egl_error_name(eglGetError());
    return connection;
  }
  eglBindAPI(EGL_OPENGL_API);
  connection.context = create_core_context(connection.display);
  if (connection.context == EGL_NO_CONTEXT) {
    connection.problem = "no OpenGL 4.5 core context: " + egl_error_name(eglGetError());
    open_displays().leave(connection.display);
    return connection;
  }
  if (eglMakeCurrent(connection.display, EGL_NO_SURFACE, EGL_NO_SURFACE, connection.context) != EGL_TRUE) {
    connection.problem =
        "the context cannot be made current without a surface: " + egl_error_name(eglGetError());
    eglDestroyContext(connection.display, connection.context);
    open_displays().leave(connection.display);
    connection.context = EGL_NO_CONTEXT;
  }
  return connection;
}

void disconnect(const Connection& connection) {
  if (!connection.usable()) return;
  eglMakeCurrent(connection.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(connection.display, connection.context);
  open_displays().leave(connection.display);
  eglReleaseThread();
}

}  // namespace furnace::gl
