// What this server can do and what it is, as JSON.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "api/render_request.hpp"

namespace furnace::api {

// What makes pixels besides the request; the server fills it from the renderer's fingerprint.
struct VersionInfo {
  std::string version;      // "0.1.0"
  std::string build;        // version and source hash
  std::string shaders;      // hash of the shader library
  std::string gl;           // GL_RENDERER / GL_VERSION
  std::string fingerprint;  // the Furnace-Fingerprint header
};

// What is configured or depends on the machine; names, formats and extensions are read from the tables that
// implement them.
struct Capabilities {
  VersionInfo version;
  RequestLimits request;
  ImportLimits import;
  std::int64_t max_body_bytes = 64ll << 20;
  int max_texture_px = 0;
  bool software_gl = false;
  bool remote_files = false;  // https: references are fetched, from the hosts that the operator allows
  bool webhooks = false;      // jobs tell of their end
};

std::string capabilities_json(const Capabilities& capabilities);
std::string version_json(const VersionInfo& version);

}  // namespace furnace::api
