#include "server/commands/bundle_file.hpp"

#include <fmt/format.h>

#include "renderer/assets/zip_reader.hpp"
#include "renderer/base/content_hash.hpp"
#include "renderer/base/error.hpp"

namespace furnace {

std::optional<BundleFile> BundleFile::read(const Blob& file) {
  constexpr std::string_view kParts = "parts/";
  if (!is_zip(file)) return std::nullopt;
  const ZipReader archive(file);
  const auto about = archive.read("bundle.json");
  if (!about) return std::nullopt;
  BundleFile bundle;
  bundle.about = api::parse_bundle_json(about->text());
  const auto document = archive.read("request.json");
  if (!document) fail(ErrorCode::kUnprocessable, "the bundle has no request.json");
  bundle.document = document->text();
  for (const std::string& name : archive.names())
    if (name.starts_with(kParts)) bundle.parts.emplace(name.substr(kParts.size()), *archive.read(name));
  return bundle;
}

std::string BundleFile::verdict(std::string_view picture, const std::string& fingerprint) const {
  if (hash_bytes(std::as_bytes(std::span(picture))).hex() == about.sha256)
    return "the same bytes as the bundle's picture";
  if (fingerprint == about.fingerprint)
    return "other bytes than the bundle's picture, on the same build and driver";
  return fmt::format("other bytes than the bundle's picture, which was drawn by {}; this is {}",
                     about.fingerprint, fingerprint);
}

}  // namespace furnace
