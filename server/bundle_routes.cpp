#include "server/bundle_routes.hpp"

#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "api/bundle.hpp"
#include "server/zip_archive.hpp"

namespace furnace {
namespace {

void check_size(const api::SelfContained& request, std::int64_t max_bytes) {
  std::int64_t bytes = 0;
  for (const auto& [name, file] : request.parts) bytes += std::int64_t(file.size());
  if (bytes <= max_bytes) return;
  fail(ErrorCode::kTooLarge,
       fmt::format("The files of a bundle may have {} bytes together; this request's have {}.", max_bytes,
                   bytes));
}

}  // namespace

Reply post_bundle(const Doors& doors, const Request& request) {
  const RequestBody body = read_body(request, doors.max_parts);
  std::vector<ReadReference> reads;
  const RenderSpec spec = parse_spec(body, {}, doors, &reads);
  api::SelfContained contained = api::self_contained(body.document, reads, spec.output);
  check_size(contained, doors.max_bundle_bytes);
  const Rendered rendered = doors.service.render(spec, request.deadline);

  const bool is_archive = api::media_type_of(spec.output) == api::kZip;
  api::BundleAbout about;
  about.fingerprint = doors.service.fingerprint();
  about.is_exact = doors.is_exact;
  about.etag = doors.service.etag(spec).hex();
  about.picture = fmt::format("picture.{}", is_archive ? "zip" : api::name_of(spec.output.format));
  about.sha256 = hash_bytes(std::as_bytes(std::span(rendered.image->bytes))).hex();
  std::vector<ArchiveFile> files = {{"bundle.json", api::bundle_json(about)},
                                    {"request.json", std::move(contained.document)},
                                    {about.picture, rendered.image->bytes},
                                    {"report.json", rendered.image->report}};
  for (const auto& [name, file] : contained.parts)
    files.push_back({"parts/" + name, std::string(file.text())});
  return Reply{200, std::string(api::kZip), zip_archive(files), {}}
      .with("Content-Disposition",
            fmt::format("attachment; filename=\"furnace-{}.zip\"", about.etag.substr(0, 12)))
      .with("Furnace-Fingerprint", about.fingerprint)
      .with("Cache-Control", "no-store");
}

}  // namespace furnace
