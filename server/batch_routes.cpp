#include "server/batch_routes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/image/codecs.hpp"
#include "renderer/image/encode.hpp"
#include "api/batch_request.hpp"
#include "api/problem.hpp"
#include "server/contact_sheet.hpp"
#include "server/zip_archive.hpp"

namespace furnace {
namespace {

struct Planned {
  api::BatchItem item;
  RenderSpec spec;
};

struct Plan {
  std::vector<Planned> items;
  std::optional<api::ContactSheet> sheet;
};

void check_sheet(const api::ContactSheet& sheet, int count, std::int64_t max_area_px) {
  const Extent size = ContactSheetPicture::extent_of(count, sheet.columns, sheet.cell_px);
  if (size.area() <= max_area_px) return;
  fail(
      ErrorCode::kTooLarge,
      fmt::format(
          "{} cells of {} px make a sheet of {} x {} px, and a picture may have {} px; ask for smaller cells",
          count, sheet.cell_px, size.width, size.height, max_area_px),
      "/contactSheet");
}

Plan plan(const Doors& doors, const RequestBody& body, const Deadline& deadline) {
  const api::RequestLimits& limits = doors.capabilities.request;
  api::Batch batch = api::parse_batch(body.document, limits, doors.max_batch);
  if (batch.sheet) check_sheet(*batch.sheet, int(batch.items.size()), limits.max_area_px);
  Plan planned{{}, batch.sheet};
  for (api::BatchItem& item : batch.items) {
    try {
      RenderSpec spec = parse_spec({item.document, body.parts}, {}, doors, deadline);
      planned.items.push_back({std::move(item), std::move(spec)});
    } catch (Error& error) {
      error.message = fmt::format("{}: {}", item.name, error.message);
      throw;
    }
  }
  return planned;
}

// The same picture, as large as a cell; of a sequence its first frame.
RenderSpec spec_of_cell(const RenderSpec& spec, int cell_px) {
  RenderSpec cell = spec;
  OutputSpec& output = cell.output;
  const double scale = double(cell_px) / std::max(output.width, output.height);
  output.width = std::clamp(int(std::lround(output.width * scale)), 1, cell_px);
  output.height = std::clamp(int(std::lround(output.height * scale)), 1, cell_px);
  output.format = OutputFormat::kPng;
  output.bit_depth = 8;
  output.layers.clear();
  output.sequence.reset();
  cell.strict = false;  // the picture itself tells
  return cell;
}

Image cell_picture(RenderService& service, const RenderSpec& spec, int cell_px, const Deadline& deadline) {
  const Rendered drawn = service.render(spec_of_cell(spec, cell_px), deadline);
  return decode_png(std::as_bytes(std::span(drawn.image->bytes)), ColorSpace::kSrgb, DecodeLimits{});
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

api::StoredRender draw_planned(const Doors& doors, const Plan& planned, const Deadline& deadline,
                               const TellProgress& progress) {
  const auto count = int(planned.items.size());
  std::optional<ContactSheetPicture> sheet;
  if (planned.sheet) sheet.emplace(count, planned.sheet->columns, planned.sheet->cell_px);
  std::vector<ArchiveFile> files;
  std::vector<api::BatchOutcome> outcomes;
  std::optional<Error> first_error;
  api::StoredRender batch;
  batch.media_type = api::kZip;
  batch.frames = 0;
  for (const auto& [item, spec] : planned.items) {
    api::BatchOutcome outcome{item, {}, {}, {}};
    try {
      const auto tell = [&](const RenderProgress& item_has) {
        if (progress) progress({int(outcomes.size()), count, item_has.stage, item_has.share});
      };
      const Rendered rendered = doors.service.render(spec, deadline, tell);
      outcome.file = fmt::format("{}.{}", item.name, ending_of(spec.output));
      outcome.notes = rendered.image->notes;
      batch.frames += rendered.image->frames;
      files.push_back({outcome.file, rendered.image->bytes});
      if (sheet)
        sheet->put(int(outcomes.size()), cell_picture(doors.service, spec, planned.sheet->cell_px, deadline));
    } catch (const Error& error) {
      if (ends_the_batch(error)) throw;
      if (!first_error) first_error = error;
      outcome.problem = api::problem_json(error, item.name);
    }
    outcomes.push_back(std::move(outcome));
    if (progress) progress({int(outcomes.size()), count});
  }
  if (files.empty() && first_error) throw *std::move(first_error);
  if (sheet) files.push_back({std::string(api::kContactSheetFile), encode_png(sheet->image(), {})});
  files.push_back({"index.json", api::batch_index_json(outcomes, sheet ? sheet->columns() : 0)});
  batch.bytes = zip_archive(files);
  return batch;
}

}  // namespace

api::StoredRender draw_batch(const Doors& doors, const RequestBody& body, const Deadline& deadline,
                             const TellProgress& progress) {
  return draw_planned(doors, plan(doors, body, deadline), deadline, progress);
}

Reply post_batch(const Doors& doors, const Request& request) {
  const RequestBody body = read_body(request, doors.max_parts);
  const Plan planned = plan(doors, body, request.deadline);
  Reply reply;
  if (doors.jobs != nullptr && JobDoors::is_asked_for(request)) {
    reply = doors.jobs->accept(request);
  } else {
    api::StoredRender batch = draw_planned(doors, planned, request.deadline, {});
    reply = Reply{200, std::move(batch.media_type), std::move(batch.bytes), {}};
    reply.with("Cache-Control", "no-store");
  }
  reply.renders *= int(planned.items.size());
  return reply;
}

}  // namespace furnace
