// A repro bundle as `furnace render` takes it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "api/bundle.hpp"
#include "renderer/base/blob.hpp"

namespace furnace {

struct BundleFile {
  api::BundleAbout about;
  std::string document;
  std::map<std::string, Blob> parts;

  // None for what is no bundle. Errors: those of ZipReader and parse_bundle_json; kUnprocessable when it has no request.
  static std::optional<BundleFile> read(const Blob& file);

  // For people: whether `picture`, drawn on this build and driver, is the bundle's, and why it may not be.
  std::string verdict(std::string_view picture, const std::string& fingerprint) const;
};

}  // namespace furnace
