#include "server/render_service.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "api/render_request.hpp"
#include "renderer/base/content_hash.hpp"
#include "renderer/base/error.hpp"
#include "renderer/image/encode.hpp"
#include "server/build_id.hpp"
#include "server/zip_archive.hpp"

namespace furnace {
namespace {

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Under "strict" whatever could not be drawn as asked is the client's to mend.
void refuse_notes(const std::vector<Note>& notes) {
  if (notes.empty()) return;
  Error error{
      ErrorCode::kUnprocessable, "strict: the picture could not be drawn exactly as asked", {}, {}, {}, {}};
  for (const Note& note : notes) error.problems.push_back({note.pointer, note.code + ": " + note.message});
  throw error;
}

void check_output(const RenderSpec& spec) {
  for (const std::string& fault : {format_fault(spec), layers_fault(spec.output), sequence_fault(spec)})
    if (!fault.empty()) fail(ErrorCode::kUnprocessable, fault);
}

std::string encode(const Film& film, const OutputSpec& output, const std::vector<TextField>& metadata) {
  switch (output.format) {
    case OutputFormat::kPng:
    case OutputFormat::kWebm:  // format_fault has refused it
      break;
    case OutputFormat::kExr:
      return film.layers.empty()
                 ? encode_exr(film.image, metadata, output.exr_compression)
                 : encode_exr_layers(film.image, film.layers, metadata, output.exr_compression);
    case OutputFormat::kJpeg:
      return encode_jpeg(film.image, output.compression_quality, metadata);
    case OutputFormat::kWebp:
      return encode_webp(film.image, {output.lossless, output.compression_quality}, metadata);
  }
  return encode_png(film.image, metadata);
}

std::unique_ptr<AnimationEncoder> animation_of(const OutputSpec& output, int frames,
                                               const std::vector<TextField>& metadata) {
  const AnimationTiming timing{frames, output.sequence->frames_per_second, output.sequence->loops};
  if (output.format == OutputFormat::kWebp)
    return webp_animation(timing, {output.lossless, output.compression_quality}, metadata);
  if (output.format == OutputFormat::kWebm) return webm_video(timing, output.compression_quality, metadata);
  return png_animation(timing, metadata);
}

void add_times(const StageTimes& more, StageTimes& sum) {
  for (double StageTimes::*stage :
       {&StageTimes::queue_ms, &StageTimes::decode_ms, &StageTimes::bake_ms, &StageTimes::upload_ms,
        &StageTimes::draw_ms, &StageTimes::readback_ms, &StageTimes::encode_ms})
    sum.*stage += more.*stage;
}

void add_notes(std::vector<Note> more, std::vector<Note>& notes) {
  for (Note& note : more)
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
}

std::string frame_name(int frame, std::string_view extension) {
  return fmt::format("frame_{:04}.{}", frame + 1, extension);
}

}  // namespace

std::vector<api::RenderReport::Stage> stages_of(const StageTimes& times) {
  const auto where = [](bool hit, std::string_view cache = "hit") {
    return hit ? cache : std::string_view();
  };
  return {{"queue", times.queue_ms, {}},
          {"decode", times.decode_ms, where(times.decode_hit)},
          {"bake", times.bake_ms, where(times.bake_hit, times.bake_from_disk ? "disk" : "hit")},
          {"upload", times.upload_ms, where(times.upload_hit)},
          {"draw", times.draw_ms, {}},
          {"readback", times.readback_ms, {}},
          {"encode", times.encode_ms, {}}};
}

RenderService::RenderService(Painter painter, Admission& admission, WorkerPool& pool, RenderCache& cache,
                             const SequenceLimits& limits)
    : painter_(std::move(painter)), admission_(admission), pool_(pool), cache_(cache), limits_(limits) {}

ContentHash RenderService::etag(const RenderSpec& spec) const {
  return HashBuilder().add(spec_hash(spec)).add(painter_.fingerprint).finish();
}

std::vector<TextField> RenderService::metadata_of(const RenderSpec& spec) const {
  return {{"Software", "Furnace " + std::string(version())},
          {"furnace:request", spec_hash(spec).hex()},
          {"furnace:fingerprint", painter_.fingerprint}};
}

std::string RenderService::report_of(const RenderSpec& spec, const api::StoredRender& image,
                                     const StageTimes& times) const {
  api::RenderReport report;
  report.request = spec_hash(spec).hex();
  report.fingerprint = painter_.fingerprint;
  report.etag = etag(spec).hex();
  report.media_type = image.media_type;
  report.width = spec.output.width;
  report.height = spec.output.height;
  report.samples = spec.output.samples;
  report.frames = image.frames;
  report.bytes = std::int64_t(image.bytes.size());
  report.exposure_ev = image.exposure_ev;
  report.stages = stages_of(times);
  report.notes = image.notes;
  return api::render_report_json(report);
}

api::StoredRender RenderService::finish(const RenderSpec& spec, Film film, const Deadline& deadline,
                                        StageTimes& times) {
  if (spec.strict) refuse_notes(film.notes);
  check_deadline(deadline, "encode");
  const auto encoding = Clock::now();
  api::StoredRender image;
  image.media_type = api::media_type_of(spec.output);
  image.exposure_ev = film.exposure_ev;
  image.notes = std::move(film.notes);
  std::vector<TextField> metadata = metadata_of(spec);
  metadata.insert(metadata.end(), film.attributes.begin(), film.attributes.end());
  pool_.run(Lane::kEncode, [&] { image.bytes = encode(film, spec.output, metadata); });
  times = film.times;
  times.encode_ms = milliseconds_since(encoding);
  return image;
}

api::StoredRender RenderService::draw_sequence(const RenderSpec& spec, const Deadline& deadline,
                                               const TellProgress& progress, StageTimes& times) {
  const bool is_archive = spec.output.sequence->container == Sequence::Container::kArchive;
  api::StoredRender sequence;
  sequence.media_type = api::media_type_of(spec.output);
  std::unique_ptr<AnimationEncoder> animation;
  std::vector<ArchiveFile> files;
  int done = 0, frames = 0;
  const auto take = [&](int i, int count, const RenderSpec& frame, Film film) {
    if (i == 0) {
      sequence.exposure_ev = film.exposure_ev;
      sequence.frames = count;
      if (!is_archive) animation = animation_of(spec.output, count, metadata_of(spec));
    }
    StageTimes frame_times;
    if (is_archive) {
      api::StoredRender image = finish(frame, std::move(film), deadline, frame_times);
      add_notes(std::move(image.notes), sequence.notes);
      files.push_back({frame_name(i, api::name_of(spec.output.format)), std::move(image.bytes)});
    } else {
      if (spec.strict) refuse_notes(film.notes);
      add_notes(std::move(film.notes), sequence.notes);
      const auto encoding = Clock::now();
      pool_.run(Lane::kEncode, [&] { animation->add(film.image); });
      frame_times = film.times;
      frame_times.encode_ms = milliseconds_since(encoding);
    }
    add_times(frame_times, times);
    done = i + 1;
    frames = count;
    if (progress) progress({done, frames});
  };
  const TellStage tell = [&](std::string_view stage, double share) {
    if (progress) progress({done, frames, stage, share});
  };
  draw_frames(painter_, spec, limits_, deadline, tell, take);
  const auto finishing = Clock::now();
  pool_.run(Lane::kEncode, [&] { sequence.bytes = is_archive ? zip_archive(files) : animation->finish(); });
  times.encode_ms += milliseconds_since(finishing);
  return sequence;
}

api::StoredRender RenderService::draw(const RenderSpec& spec, const Deadline& deadline,
                                      const TellProgress& progress, StageTimes& times) {
  const auto asked = Clock::now();
  const Admission::Seat seat = admission_.enter(deadline);
  const double queue_ms = milliseconds_since(asked);
  const TellStage tell = [&](std::string_view stage, double share) {
    if (progress) progress({0, 0, stage, share});
  };
  api::StoredRender image = spec.output.sequence
                                ? draw_sequence(spec, deadline, progress, times)
                                : finish(spec, painter_.render(spec, deadline, tell), deadline, times);
  times.queue_ms = queue_ms;
  image.report = report_of(spec, image, times);
  return image;
}

Rendered RenderService::render(const RenderSpec& spec, const Deadline& deadline,
                               const TellProgress& progress) {
  check_output(spec);
  Rendered out;
  auto found =
      cache_.get_or_draw(etag(spec), deadline, [&] { return draw(spec, deadline, progress, out.times); });
  out.image = std::move(found.render);
  out.origin = found.origin;
  return out;
}

void RenderService::render_frames(const RenderSpec& spec, const Deadline& deadline, const TakeFrame& take) {
  check_output(spec);
  const Admission::Seat seat = admission_.enter(deadline);
  draw_frames(painter_, spec, limits_, deadline, {},
              [&](int i, int count, const RenderSpec& frame, Film film) {
                StageTimes times;
                take(i, count, finish(frame, std::move(film), deadline, times));
              });
}

}  // namespace furnace
