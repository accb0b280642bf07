#include "server/environment_registry.hpp"

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/image/encode.hpp"
#include "server/environment_report.hpp"

namespace furnace {
namespace {

std::int64_t bytes_of(const EnvironmentBake& bake) {
  return std::int64_t(bake.maps->byte_size() + bake.riemann_irradiance.byte_size());
}

}  // namespace

EnvironmentRegistry::EnvironmentRegistry(Baker baker, Admission& admission, WorkerPool& pool,
                                         Decoder& decoder, RegistryConfig config)
    : baker_(std::move(baker)),
      admission_(admission),
      pool_(pool),
      decoder_(decoder),
      limits_(config.limits),
      files_(std::move(config.folder), config.files_bytes),
      maps_(config.maps_bytes, bytes_of) {}

Blob EnvironmentRegistry::file_of(const std::string& name) {
  std::optional<Blob> file = files_.find(name);
  if (!file) {
    fail(ErrorCode::kNotFound,
         fmt::format("there is no environment \"{}\"; PUT /v1/environments/{{name}} makes one", name));
  }
  return *std::move(file);
}

api::EnvironmentReport EnvironmentRegistry::summary_of(const std::string& name, const Blob& file,
                                                       const Deadline& deadline) {
  const Admission::Seat seat = admission_.enter(deadline);
  EnvironmentSpec spec;
  spec.map = EnvironmentFile{file};
  try {
    const EnvironmentAnswer answer = baker_(spec, deadline);
    return report_of(name, file, answer.summary, answer.was_cached);
  } catch (Error& error) {
    error.pointer.clear();  // into a render request, which this is not
    throw;
  }
}

EnvironmentRegistry::Put EnvironmentRegistry::put(const std::string& name, const Blob& file,
                                                  const Deadline& deadline) {
  EnvironmentFiles::check_name(name);  // before any work
  Put put;
  put.report = summary_of(name, file, deadline);
  put.is_new = files_.put(name, file);
  return put;
}

api::EnvironmentReport EnvironmentRegistry::report(const std::string& name, const Deadline& deadline) {
  return summary_of(name, file_of(name), deadline);
}

std::string EnvironmentRegistry::map_exr(const std::string& name, const std::string& map,
                                         const Deadline& deadline) {
  const Blob file = file_of(name);
  const Admission::Seat seat = admission_.enter(deadline);
  const auto bake = maps_.get_or_load(file.hash(), deadline, [&] {
    EnvironmentBakeSettings settings;
    settings.limits = limits_;
    return bake_whole_environment(file, settings, pool_, decoder_, deadline);
  });
  for (const EnvironmentMap& candidate : bake->list()) {
    if (candidate.name == map) return encode_exr(*candidate.equirect, {});
  }
  fail(ErrorCode::kNotFound,
       fmt::format("environment \"{}\" has no map \"{}\"; its report lists them", name, map));
}

}  // namespace furnace
