// What clients send: documents, forms, header fields; and what a decoder's process answers.
#include <array>
#include <optional>

#include "api/batch_request.hpp"
#include "api/contract.hpp"
#include "api/inspect_request.hpp"
#include "api/problem.hpp"
#include "api/stored_render.hpp"
#include "renderer/assets/zip_reader.hpp"
#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "renderer/decode/channel.hpp"
#include "renderer/decode/messages.hpp"
#include "renderer/scene/model_import.hpp"
#include "server/framing.hpp"
#include "server/negotiation.hpp"
#include "server/request_body.hpp"
#include "tests/api/request_fixture.hpp"
#include "tests/fuzz/checked_decoder.hpp"
#include "tests/fuzz/expectations.hpp"
#include "tests/fuzz/mutators.hpp"

namespace furnace::fuzz {
namespace {

// Runs `body`; the problem document of its Error must be JSON.
template <class Body>
void expect_problem(Body&& body) {
  try {
    body();
  } catch (const Error& error) {
    api::Document::parse(api::problem_json(error, "fuzz"), {});
    throw;
  }
}

// The judge and the explanation agree; what is accepted is the same when read again.
void run_request(Input input) {
  const std::string_view text = text_of(input);
  expect_problem([&] {
    const api::Document document = api::Document::parse(text, {});
    const bool valid = api::request_schema().problems(document).empty();
    const auto explained = api::explain(api::request_schema().document().root(), document.root());
    FURNACE_CHECK(valid == explained.empty(), "valid: {}, explained: {}", valid, explained.size());
    const ContentHash hash = spec_hash(api::parse(text));
    FURNACE_CHECK(valid, "a request that the schema does not allow");
    FURNACE_CHECK(spec_hash(api::parse(text)) == hash, "another reading, another picture");
  });
}

void run_inspect_request(Input input) {
  FileAssets files({}, 0, 0);
  const std::map<std::string, Blob> parts = {{"model.gltf", Blob(R"({"asset":{"version":"2.0"}})")}};
  expect_problem([&] {
    api::parse_inspect_request(text_of(input), AssetResolver(files, parts, small_import_limits()), {});
  });
}

// Every item is a document, and so are its changes.
void run_batch(Input input) {
  constexpr int kMostItems = 50;
  expect_problem([&] {
    const auto items = api::parse_batch(text_of(input), {}, kMostItems).items;
    FURNACE_CHECK(!items.empty() && items.size() <= kMostItems, "{} items", items.size());
    for (const api::BatchItem& item : items) {
      FURNACE_CHECK(!item.name.empty() && item.name.find('/') == std::string::npos, "{}", item.name);
      api::Document::parse(item.changes, {});
      api::Document::parse(item.document, {});
    }
  });
}

// Input: what stands behind the checksum, which chance does not find.
void run_stored_render(Input input) {
  const std::string content(text_of(input));
  const api::StoredRender render = api::decode_stored_render(hash_bytes(input).hex() + "\n" + content);
  const api::StoredRender again = api::decode_stored_render(api::encode_stored_render(render));
  FURNACE_CHECK(again.bytes == render.bytes && again.frames == render.frames, "another render");
}

void run_zip(Input input) {
  constexpr ZipLimits kLimits = {
      .max_entries = 50, .max_total_bytes = 1 << 20, .max_ratio = 100, .free_bytes = 1 << 16};
  const ZipReader archive(Blob(std::string(text_of(input))), kLimits);
  std::int64_t bytes = 0;
  for (const std::string& name : archive.names()) {
    FURNACE_CHECK(!name.empty() && name.front() != '/' && !name.starts_with("../"), "{}", name);
    if (const auto file = archive.read(name)) bytes += std::int64_t(file->size());
  }
  FURNACE_CHECK(bytes <= kLimits.max_total_bytes, "{} bytes", bytes);
  model_in(archive);
}

// Input: the Content-Type; behind a zero byte the body.
// What is heard of a body, and whether it is refused, in pieces of `size` bytes.
class HeardParts : public PartListener {
 public:
  HeardParts(TextPair form, int max_parts, std::size_t size) {
    try {
      MultipartReader reader(form.first, max_parts, *this);
      for (; !form.second.empty(); form.second.remove_prefix(std::min(size, form.second.size())))
        reader.take(form.second.substr(0, size));
      reader.finish();
    } catch (const Error& error) {
      text = error_code_name(error.code);
    }
  }
  std::string text;

 private:
  void begin(PartHead head) override { text += '<' + head.name + '|' + head.file_name + '>'; }
  void take_part(std::string_view bytes) override { text += bytes; }
  void end() override { text += "</>"; }
};

void run_multipart(Input input) {
  constexpr int kMostParts = 8;
  const TextPair texts = split(input);
  const std::string whole = HeardParts(texts, kMostParts, texts.second.size() + 1).text;
  for (const std::size_t size : {1, 7}) {
    const std::string pieces = HeardParts(texts, kMostParts, size).text;
    FURNACE_CHECK(pieces == whole, "in pieces of {}: {} instead of {}", size, pieces, whole);
  }
  Request request;
  request.headers["Content-Type"] = std::string(texts.first);
  request.body = std::string(texts.second);
  const RequestBody body = read_body(request, kMostParts);
  FURNACE_CHECK(body.parts.size() <= 2 * kMostParts, "{} files", body.parts.size());
  for (const auto& [name, file] : body.parts)
    FURNACE_CHECK(!name.empty() && texts.second.find(file.text()) != std::string_view::npos,
                  "the file \"{}\" is not in the body", name);
}

// Input: lines "Name: value", as a head has them.
Request head_of(std::string_view text) {
  Request head;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::size_t colon = line.find(": ");
    if (colon != line.npos) head.headers[std::string(line.substr(0, colon))] = line.substr(colon + 2);
  }
  return head;
}

void run_head(Input input) {
  constexpr std::int64_t kMostBodyBytes = 1 << 20;
  const Request head = head_of(text_of(input));
  const Framing framing = read_framing(head, "HTTP/1.1", kMostBodyBytes);
  FURNACE_CHECK(framing.refusal.status == 0 || framing.refusal.status >= 400, "{}", framing.refusal.status);
  FURNACE_CHECK(framing.content_length >= 0 && framing.content_length <= kMostBodyBytes, "{} bytes",
                framing.content_length);
  for (const std::string_view type : {"image/png", "application/json"}) {
    const double quality = accept_quality(head.header("Accept"), type);
    FURNACE_CHECK(quality >= 0 && quality <= 1, "quality {}", quality);
  }
  etag_matches(head.header("If-None-Match"), "0123");
  media_type_parameter(head.header("Content-Type"), "boundary");
  if (is_sane_request_id(head.header("X-Request-Id")))
    FURNACE_CHECK(head.header("X-Request-Id").find_first_of("\r\n\"") == std::string_view::npos, "an id");
}

// --- answers of a process that may lie

constexpr std::size_t kBlockBytes = 4096;

// As from a process: `block` is what the memory for arrays holds.
decode::WireReader reader_of(std::string_view message, Input block) {
  static const Descriptor memory = decode::empty_block(kBlockBytes);
  static const decode::Mapping mapping(memory.get(), kBlockBytes, decode::Mapping::Access::kWrite);
  std::ranges::fill(mapping.bytes(), std::byte{0});
  std::ranges::copy(block.first(std::min(block.size(), kBlockBytes)), mapping.bytes().begin());
  return decode::WireReader(message, memory.get(), kBlockBytes);
}

// What a job's judge lets through; none: nothing.
template <class Job>
std::optional<typename Job::Result> believed(const Job& job, decode::WireReader& reader) {
  typename Job::Result result;
  fields(reader, result);
  if (!reader.ended_well() || !job.accepts(result)) return std::nullopt;
  return result;
}

// A model that was believed is drawn like any other. Threads: one. Owns: the model.
class LyingDecoder : public CheckedDecoder {
 public:
  explicit LyingDecoder(PlainModel model) : model_(std::move(model)) {}
  PlainModel model(std::span<const std::byte>, std::string_view, ModelFormat, const PlainModelLimits&,
                   const Deadline&) override {
    return model_;
  }

 private:
  PlainModel model_;
};

constexpr PlainModelLimits kModelLimits = {
    .max_vertices = 1000, .max_elements = 1000, .max_bytes = 1 << 20, .max_materials = 20};

void run_model_reply(decode::WireReader& reader) {
  decode::ModelJob job;
  job.limits = kModelLimits;
  auto model = believed(job, reader);
  if (!model) return;
  ModelBundle bundle;
  bundle.format = ModelFormat::kObj;
  LyingDecoder decoder(std::move(*model));
  expect_whole(import_model(bundle, {}, small_import_limits(), decoder, Deadline()));
}

// Input: which job, bytes of its answer; the answer, then what it left in the block.
void run_reply(Input input) {
  constexpr DecodeLimits kLimits = {.max_side_px = 64, .max_area_px = 1024};
  Taker taker(input);
  const std::uint32_t job = taker.number(1);
  const std::size_t size = std::min<std::size_t>(taker.number(2), taker.rest().size());
  decode::WireReader reader = reader_of(text_of(taker.rest().first(size)), taker.rest().subspan(size));
  decode::Reply reply;
  fields(reader, reply);
  if (reply.failed) return;
  switch (job % 5) {
    case 0:
      believed(decode::TextureJob{ColorSpace::kSrgb, kLimits}, reader);
      return;
    case 1:
      believed(decode::EnvironmentJob{kLimits}, reader);
      return;
    case 2: {
      DracoRequest request;
      request.attributes = {{0, DracoComponent::kFloat, 3}};
      request.vertices = request.most_triangles = 8;
      believed(decode::DracoJob{request}, reader);
      return;
    }
    case 3:
      believed(decode::MeshoptJob{{MeshoptMode::kAttributes, MeshoptFilter::kNone, 16, 4}}, reader);
      return;
    default:
      run_model_reply(reader);
  }
}

constexpr std::size_t kMostDocumentBytes = 8 << 10, kMostHeadBytes = 2 << 10, kMostReplyBytes = 6 << 10;

constexpr std::array kTargets = {
    Target{"request", run_request, kMostDocumentBytes, mutate_json},
    Target{"inspect_request", run_inspect_request, kMostHeadBytes, mutate_json},
    Target{"batch", run_batch, kMostHeadBytes, mutate_json},
    Target{"stored_render", run_stored_render, kMostHeadBytes, mutate_bytes},
    Target{"zip", run_zip, kMostHeadBytes, mutate_bytes},
    Target{"multipart", run_multipart, kMostDocumentBytes, mutate_bytes},
    Target{"head", run_head, kMostHeadBytes, mutate_bytes},
    Target{"reply", run_reply, kMostReplyBytes, mutate_bytes},
};

}  // namespace

std::span<const Target> request_targets() {
  return kTargets;
}

}  // namespace furnace::fuzz
