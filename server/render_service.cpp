#include "server/render_service.hpp"

#include <chrono>
#include <utility>

#include "api/render_request.hpp"
#include "renderer/base/content_hash.hpp"
#include "renderer/base/error.hpp"
#include "renderer/image/encode.hpp"
#include "server/build_id.hpp"

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

std::string encode(const Film& film, const OutputSpec& output, const std::vector<TextField>& metadata) {
  switch (output.format) {
    case OutputFormat::kPng:
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

}  // namespace

RenderService::RenderService(Painter painter, Admission& admission, WorkerPool& pool)
    : painter_(std::move(painter)), admission_(admission), pool_(pool) {}

std::string RenderService::etag(const RenderSpec& spec) const {
  return HashBuilder().add(spec_hash(spec)).add(painter_.fingerprint).finish().hex();
}

EncodedImage RenderService::render(const RenderSpec& spec, const Deadline& deadline) {
  for (const std::string& fault : {format_fault(spec), layers_fault(spec.output)})
    if (!fault.empty()) fail(ErrorCode::kUnprocessable, fault);
  const auto asked = Clock::now();
  const Admission::Seat seat = admission_.enter(deadline);
  const double queue_ms = milliseconds_since(asked);

  Film film = painter_.render(spec, deadline);
  if (spec.strict) refuse_notes(film.notes);

  check_deadline(deadline, "encode");
  const auto encoding = Clock::now();
  EncodedImage out{
      {}, api::media_type_of(spec.output.format), std::move(film.notes), film.times, film.exposure_ev};
  std::vector<TextField> metadata = {
      {"Software", "Furnace " + std::string(version())},
      {"furnace:request", spec_hash(spec).hex()},
      {"furnace:fingerprint", painter_.fingerprint},
  };
  metadata.insert(metadata.end(), film.attributes.begin(), film.attributes.end());
  pool_.run(Lane::kEncode, [&] { out.bytes = encode(film, spec.output, metadata); });

  out.times.queue_ms = queue_ms;
  out.times.encode_ms = milliseconds_since(encoding);
  return out;
}

}  // namespace furnace
