#include "server/routes.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/content_hash.hpp"
#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "api/contract.hpp"
#include "api/document.hpp"
#include "api/render_request.hpp"
#include "server/asset_routes.hpp"
#include "server/batch_routes.hpp"
#include "server/bundle_routes.hpp"
#include "server/build_id.hpp"
#include "server/environment_routes.hpp"
#include "server/hash_text.hpp"
#include "server/inspect_routes.hpp"
#include "server/negotiation.hpp"
#include "server/request_body.hpp"

namespace furnace {
namespace {

constexpr std::string_view kJson = "application/json";
constexpr std::string_view kRenders = "/v1/renders/", kReports = "/v1/reports/";
constexpr std::string_view kPlainText = "text/plain; charset=utf-8";
constexpr std::size_t kMaxNoteCodes = 8;  // in a header; the metrics count them all

// --- POST /v1/renders
// -------------------------------------------------------------------------------------------------

// What Accept likes best; of what it likes as much, or not at all, the first of the table, which is PNG.
OutputFormat preferred_format(std::string_view accept) {
  const auto quality = [&](const api::FormatRow& row) { return accept_quality(accept, row.media_type); };
  return std::ranges::max_element(api::kFormats, {}, quality)->format;
}

// An animated PNG is a PNG to whoever knows no better.
double quality_of(std::string_view accept, std::string_view media_type) {
  const double quality = accept_quality(accept, media_type);
  return media_type == api::kAnimatedPng ? std::max(quality, accept_quality(accept, "image/png")) : quality;
}

// Where the document asks for what Accept refuses; "" when it left the choice to Accept.
std::string choice_of_file(std::string_view document, const api::RequestLimits& limits) {
  const auto parsed = api::Document::parse(document, {limits.max_json_depth, limits.max_json_bytes});
  const api::Value output = parsed.root()["output"];
  if (const api::Value container = output["sequence"]["container"]) return container.pointer();
  return output["format"] ? output["format"].pointer() : std::string();
}

std::string server_timing(const std::vector<api::RenderReport::Stage>& stages) {
  std::vector<std::string> texts;
  for (const api::RenderReport::Stage& stage : stages)
    texts.push_back(fmt::format("{}{}{};dur={:.2f}", stage.name,
                                stage.cache.empty() ? "" : ";desc=", stage.cache, stage.ms));
  return fmt::format("{}", fmt::join(texts, ", "));
}

// A structured field (RFC 8941): how many notes, and their codes, each once.
std::string notes_field(const std::vector<Note>& notes) {
  std::vector<std::string_view> codes;
  for (const Note& note : notes) {
    if (codes.size() < kMaxNoteCodes && std::ranges::find(codes, note.code) == codes.end())
      codes.push_back(note.code);
  }
  if (codes.empty()) return "0";
  return fmt::format("{};codes=\"{}\"", notes.size(), fmt::join(codes, " "));
}

std::string_view origin_name(RenderOrigin origin) {
  switch (origin) {
    case RenderOrigin::kDrawn:
      return "drawn";
    case RenderOrigin::kJoined:
      return "joined";
    case RenderOrigin::kMemory:
      return "memory";
    case RenderOrigin::kDisk:
      break;
  }
  return "disk";
}

// RFC 9211: what the cache of renders did.
std::string cache_status(RenderOrigin origin) {
  switch (origin) {
    case RenderOrigin::kDrawn:
      return "furnace; fwd=miss; stored";
    case RenderOrigin::kJoined:
      return "furnace; fwd=miss; collapsed";
    default:
      return fmt::format("furnace; hit; detail={}", origin_name(origin));
  }
}

Reply& with_tag(Reply& reply, const Doors& doors, const std::string& etag) {
  return reply.with("ETag", '"' + etag + '"').with("Furnace-Fingerprint", doors.service.fingerprint());
}

// The links only where the picture is still kept.
Reply& with_validators(Reply& reply, const Doors& doors, const std::string& etag, bool is_kept) {
  if (is_kept)
    reply.with("Content-Location", fmt::format("{}{}", kRenders, etag))
        .with("Link", fmt::format("<{}{}>; rel=\"describedby\"; type=\"{}\"", kReports, etag, kJson));
  return with_tag(reply, doors, etag).with("Vary", "Accept").with("Cache-Control", "no-cache");
}

void count_render(Metrics& metrics, const RenderSpec& spec, const Rendered& rendered) {
  metrics.cache_lookups.Add({{"cache", "renders"}, {"result", std::string(origin_name(rendered.origin))}})
      .Increment();
  if (rendered.origin != RenderOrigin::kDrawn) return;
  metrics.renders.Increment();
  metrics.pixels.Increment(double(spec.output.width) * spec.output.height * rendered.image->frames);
  metrics.observe_stages(rendered.times);
  for (const Note& note : rendered.image->notes) {
    metrics.notes.Add({{"code", note.code}}).Increment();
    log::info("render.note", {{"code", note.code}, {"pointer", note.pointer}, {"message", note.message}});
  }
}

Reply post_render(const Doors& doors, const Request& request) {
  const RequestBody body = read_body(request, doors.max_parts);
  if (doors.jobs == nullptr || !JobDoors::is_asked_for(request)) return answer_document(doors, request, body);
  parse_spec(body, request.header("Accept"), doors, request.deadline);  // what is wrong is told at once
  return doors.jobs->accept(request);
}

RenderCache::Pointer kept_render(const Doors& doors, const Request& request, std::string_view prefix) {
  const auto tag = parse_hash(std::string_view(request.path).substr(prefix.size()));
  RenderCache::Pointer kept = tag ? doors.service.find(*tag, request.deadline) : nullptr;
  if (kept) return kept;
  fail(ErrorCode::kNotFound,
       "There is no such render. They are kept for a while only; the same request draws it again.");
}

// A picture under its tag never changes (RFC 8246).
Reply get_render(const Doors& doors, const Request& request) {
  const RenderCache::Pointer kept = kept_render(doors, request, kRenders);
  const std::string etag = request.path.substr(kRenders.size());
  const bool unchanged = etag_matches(request.header("If-None-Match"), etag);
  Reply reply = unchanged ? Reply{304, {}, {}, {}} : Reply{200, kept->media_type, kept->bytes, {}};
  return with_tag(reply, doors, etag).with("Cache-Control", "public, max-age=31536000, immutable");
}

Reply get_report(const Doors& doors, const Request& request) {
  return Reply{200, std::string(kJson), kept_render(doors, request, kReports)->report, {}}.with(
      "Cache-Control", "no-cache");
}

// --- documents
// --------------------------------------------------------------------------------------------------------

// The same text for every request, with its hash as its tag.
Route document(std::string_view path, std::string_view media_type, std::string text) {
  const std::string etag = hash_bytes(std::as_bytes(std::span(text))).hex();
  return {"GET", path,
          [media_type, text = std::move(text), etag](const Request& request) {
            const bool unchanged = etag_matches(request.header("If-None-Match"), etag);
            Reply reply = unchanged ? Reply{304, {}, {}, {}} : Reply{200, std::string(media_type), text, {}};
            return reply.with("ETag", '"' + etag + '"').with("Cache-Control", "no-cache");
          },
          scope::kOpen};
}

std::string welcome() {
  return fmt::format(
      "Furnace {}: one JSON document describes one picture.\n\n"
      "  curl -X POST http://HOST:PORT/v1/renders -H 'Content-Type: application/json' -d '{{}}' -o "
      "picture.png\n\n"
      "GET /v1/render?KEY=VALUE  the same in a URL, for <img>; keys are in /openapi.json\n"
      "POST /v1/bundles         a picture with all it takes to draw it again\n"
      "POST /v1/inspect         what is in a model\n"
      "POST /v1/assets          uploads a file, for \"asset:sha256-...\" in documents\n"
      "PUT /v1/environments/NAME  names an HDRI; its report and its baked maps\n"
      "GET /v1/schema.json      every field of the document, with unit, range and default\n"
      "GET /openapi.json        the whole API\n"
      "GET /v1/capabilities     formats, limits, extensions, fingerprint\n"
      "GET /readyz              draws a probe picture and checks it\n",
      version());
}

// --- operations
// -------------------------------------------------------------------------------------------------------

Reply plain(std::string text) {
  return Reply{200, std::string(kPlainText), std::move(text), {}}.with("Cache-Control", "no-store");
}

Reply get_metrics(const Doors& doors) {
  doors.metrics.seats.Set(doors.admission.seats());
  doors.metrics.seats_in_use.Set(doors.admission.seats_in_use());
  doors.metrics.queue_length.Set(doors.admission.waiting());
  if (doors.jobs != nullptr) {
    doors.metrics.jobs_waiting.Set(doors.jobs->waiting());
    doors.metrics.webhooks_unfinished.Set(double(doors.jobs->unfinished_webhooks()));
  }
  if (doors.assets != nullptr) doors.metrics.observe_assets(doors.assets->stats());
  if (doors.decoders != nullptr) doors.metrics.observe_decoders(doors.decoders->stats());
  if (doors.renderer) doors.metrics.observe_renderer(doors.renderer());
  return Reply{200, "text/plain; version=0.0.4; charset=utf-8", doors.metrics.text(), {}}.with(
      "Cache-Control", "no-store");
}

Reply get_ready(const Doors& doors) {
  doors.metrics.ready.Set(0);
  doors.readiness.check();
  doors.metrics.ready.Set(1);
  return plain("ready\n");
}

}  // namespace

Reply answer_document(const Doors& doors, const Request& request, const RequestBody& body) {
  const RenderSpec spec = parse_spec(body, request.header("Accept"), doors, request.deadline);
  const ContentHash tag = doors.service.etag(spec);
  const std::string etag = tag.hex();
  if (etag_matches(request.header("If-None-Match"), etag)) {
    doors.metrics.not_modified.Increment();
    Reply unchanged{304, {}, {}, {}};
    return with_validators(unchanged, doors, etag, doors.service.keeps(tag));
  }
  const Rendered rendered = doors.service.render(spec, request.deadline);
  const api::StoredRender& image = *rendered.image;
  count_render(doors.metrics, spec, rendered);
  Reply reply{200, image.media_type, image.bytes, {}};
  if (rendered.origin == RenderOrigin::kDrawn)
    reply.with("Server-Timing", server_timing(stages_of(rendered.times)));
  reply.with("Cache-Status", cache_status(rendered.origin))
      .with("Furnace-Notes", notes_field(image.notes))
      .with("Furnace-Exposure-Ev", fmt::format("{}", image.exposure_ev));
  return with_validators(reply, doors, etag, doors.service.keeps(tag));
}

void Readiness::check(std::chrono::milliseconds timeout) {
  if (draining_) fail(ErrorCode::kGpuUnavailable, "The server is shutting down.");
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) {
    if (!was_good_) fail(ErrorCode::kGpuUnavailable, "The probe picture is being drawn.");
    return;
  }
  if (Clock::now() < good_until_) return;
  bool right = false;
  try {
    right = probe_(Deadline(timeout));
  } catch (const Error& error) {
    was_good_ = false;
    fail(ErrorCode::kGpuUnavailable, "The probe picture could not be drawn: " + error.message, {},
         error.detail);
  }
  was_good_ = right;
  if (!right) {
    fail(ErrorCode::kGpuUnavailable,
         "The probe picture came out wrong; furnace doctor examines the machine.");
  }
  good_until_ = Clock::now() + std::chrono::seconds(1);
}

// A format in the document wins, unless Accept excludes it; without one Accept chooses.
RenderSpec parse_spec(const RequestBody& body, std::string_view accept, const Doors& doors,
                      const Deadline& deadline, std::vector<ReadReference>* reads) {
  const OutputFormat preferred = preferred_format(accept);
  const api::Capabilities& can = doors.capabilities;
  AssetResolver assets = references(doors, body.parts, deadline);
  if (reads != nullptr) assets.record(*reads);
  const RenderSpec spec = api::parse_render_request(body.document, assets, can.request, preferred);
  const std::string_view media_type = api::media_type_of(spec.output);
  if (quality_of(accept, media_type) > 0) return spec;
  if (std::string pointer = choice_of_file(body.document, can.request); !pointer.empty())
    fail(ErrorCode::kNotAcceptable, fmt::format("This asks for {}, which Accept refuses.", media_type),
         std::move(pointer));
  std::vector<std::string_view> types;
  for (const api::FormatRow& row : api::kFormats) types.push_back(row.media_type);
  fail(ErrorCode::kNotAcceptable, spec.output.sequence
                                      ? fmt::format("This sequence is {}, which Accept refuses.", media_type)
                                      : fmt::format("A render is one of {}.", fmt::join(types, ", ")));
}

std::string draw_job(const Doors& doors, const JobRequest& job, const Deadline& deadline,
                     const TellProgress& progress) {
  Request request;
  request.headers = {{"Content-Type", job.content_type}};
  request.body = job.body;
  const RequestBody body = read_body(request, doors.max_parts);
  if (job.target == kBatches) return api::encode_stored_render(draw_batch(doors, body, deadline, progress));
  const RenderSpec spec = parse_spec(body, job.accept, doors, deadline);
  const Rendered rendered = doors.service.render(spec, deadline, progress);
  count_render(doors.metrics, spec, rendered);
  return api::encode_stored_render(*rendered.image);
}

std::vector<Route> operation_routes(const Doors& doors, bool with_metrics) {
  std::vector<Route> routes = {
      {"GET", "/livez", [](const Request&) { return plain("alive\n"); }, scope::kOpen},
      {"GET", "/readyz", [doors](const Request&) { return get_ready(doors); }, scope::kOpen},
      document("/version", kJson, api::version_json(doors.capabilities.version)),
  };
  if (with_metrics)
    routes.push_back(
        {"GET", "/metrics", [doors](const Request&) { return get_metrics(doors); }, scope::kAdmin});
  return routes;
}

std::vector<Route> public_routes(const Doors& doors, bool with_metrics) {
  std::vector<Route> routes = operation_routes(doors, with_metrics);
  routes.push_back({"POST", "/v1/renders",
                    [doors](const Request& request) { return post_render(doors, request); }, scope::kRender,
                    true});
  routes.push_back({"POST", kBatches, [doors](const Request& request) { return post_batch(doors, request); },
                    scope::kRender, true});
  routes.push_back({"POST", "/v1/bundles",
                    [doors](const Request& request) { return post_bundle(doors, request); }, scope::kRender,
                    true});
  routes.push_back({"GET", "/v1/renders/*",
                    [doors](const Request& request) { return get_render(doors, request); }, scope::kRender});
  routes.push_back({"GET", "/v1/reports/*",
                    [doors](const Request& request) { return get_report(doors, request); }, scope::kRender});
  routes.push_back({"POST", "/v1/inspect",
                    [doors](const Request& request) { return post_inspect(doors, request); },
                    scope::kRender});
  routes.push_back(
      document("/v1/schema.json", "application/schema+json", std::string(api::render_request_schema())));
  routes.push_back(document("/openapi.json", kJson, api::openapi_document(version())));
  routes.push_back(document("/v1/capabilities", kJson, api::capabilities_json(doors.capabilities)));
  for (Route& route : environment_routes(doors.environments)) routes.push_back(std::move(route));
  if (doors.jobs != nullptr)
    for (Route& route : doors.jobs->routes()) routes.push_back(std::move(route));
  for (Route& route : image_url_routes(doors)) routes.push_back(std::move(route));
  for (Route& route : asset_routes(doors)) routes.push_back(std::move(route));
  routes.push_back(document("/", kPlainText, welcome()));
  return routes;
}

}  // namespace furnace
