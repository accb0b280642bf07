#include "server/batch_routes.hpp"

#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "api/batch_request.hpp"
#include "api/problem.hpp"
#include "server/zip_archive.hpp"

namespace furnace {
namespace {

struct Planned {
  api::BatchItem item;
  RenderSpec spec;
};

std::vector<Planned> plan(const Doors& doors, const RequestBody& body, const Deadline& deadline) {
  std::vector<Planned> planned;
  for (api::BatchItem& item : api::parse_batch(body.document, doors.capabilities.request, doors.max_batch)) {
    try {
      RenderSpec spec = parse_spec({item.document, body.parts}, {}, doors, deadline);
      planned.push_back({std::move(item), std::move(spec)});
    } catch (Error& error) {
      error.message = fmt::format("{}: {}", item.name, error.message);
      throw;
    }
  }
  return planned;
}

std::string_view ending_of(const OutputSpec& output) {
  const bool is_archive = output.sequence && output.sequence->container == Sequence::Container::kArchive;
  return is_archive ? "zip" : api::name_of(output.format);
}

// The client's or the server's time and room, not the item's fault.
bool ends_the_batch(const Error& error) {
  return error.code == ErrorCode::kOverloaded || error.code == ErrorCode::kDeadlineExceeded ||
         error.code == ErrorCode::kGpuUnavailable || error.code == ErrorCode::kInternal;
}

api::StoredRender draw_planned(const Doors& doors, const std::vector<Planned>& planned,
                               const Deadline& deadline, const RenderService::Progress& progress) {
  const auto count = int(planned.size());
  std::vector<ArchiveFile> files;
  std::vector<api::BatchOutcome> outcomes;
  std::optional<Error> first_error;
  api::StoredRender batch;
  batch.media_type = api::kZip;
  batch.frames = 0;
  for (const auto& [item, spec] : planned) {
    api::BatchOutcome outcome{item.name, item.changes, {}, {}, {}};
    try {
      const Rendered rendered = doors.service.render(spec, deadline);
      outcome.file = fmt::format("{}.{}", item.name, ending_of(spec.output));
      outcome.notes = rendered.image->notes;
      batch.frames += rendered.image->frames;
      files.push_back({outcome.file, rendered.image->bytes});
    } catch (const Error& error) {
      if (ends_the_batch(error)) throw;
      if (!first_error) first_error = error;
      outcome.problem = api::problem_json(error, item.name);
    }
    outcomes.push_back(std::move(outcome));
    if (progress) progress(int(outcomes.size()), count);
  }
  if (files.empty() && first_error) throw *std::move(first_error);
  files.push_back({"index.json", api::batch_index_json(outcomes)});
  batch.bytes = zip_archive(files);
  return batch;
}

}  // namespace

api::StoredRender draw_batch(const Doors& doors, const RequestBody& body, const Deadline& deadline,
                             const RenderService::Progress& progress) {
  return draw_planned(doors, plan(doors, body, deadline), deadline, progress);
}

Reply post_batch(const Doors& doors, const Request& request) {
  const RequestBody body = read_body(request, doors.max_parts);
  const std::vector<Planned> planned = plan(doors, body, request.deadline);
  Reply reply;
  if (doors.jobs != nullptr && JobDoors::is_asked_for(request)) {
    reply = doors.jobs->accept(request);
  } else {
    api::StoredRender batch = draw_planned(doors, planned, request.deadline, {});
    reply = Reply{200, std::move(batch.media_type), std::move(batch.bytes), {}};
    reply.with("Cache-Control", "no-store");
  }
  reply.renders = int(planned.size());
  return reply;
}

}  // namespace furnace
