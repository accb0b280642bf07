// EGL as this project uses it: displays of devices and of Mesa's surfaceless platform, each tried for a context.
#pragma once

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <string>
#include <vector>

#include "renderer/gl/context.hpp"

namespace furnace::gl {

// One way to a context, in the order of preference: hardware devices, the surfaceless platform, software devices.
struct Candidate {
  std::string selector;
  std::string platform;
  std::string pci;
  std::string drm_node;
  EGLDeviceEXT device = EGL_NO_DEVICE_EXT;  // none: surfaceless
  bool software = false;
};

struct CandidateList {
  std::vector<Candidate> candidates;
  std::string problem;  // why devices could not be listed, if so
};
CandidateList list_candidates();

// A current context on the calling thread, or `problem`.
struct Connection {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  std::string problem;

  bool usable() const { return context != EGL_NO_CONTEXT; }
};
Connection connect(const Candidate& candidate);
void disconnect(const Connection& connection);

std::string egl_error_name(EGLint error);

}  // namespace furnace::gl
