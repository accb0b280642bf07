#include "server/asset_routes.hpp"

#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "api/document.hpp"
#include "api/problem.hpp"
#include "server/asset_store.hpp"
#include "server/hash_text.hpp"
#include "server/inspect_routes.hpp"
#include "server/multipart.hpp"
#include "server/negotiation.hpp"

namespace furnace {
namespace {

constexpr std::string_view kFolder = "/v1/assets/";
constexpr std::string_view kInspect = "/inspect";
constexpr std::string_view kUnknownType = "application/octet-stream";

[[noreturn]] void fail_unknown() {
  fail(ErrorCode::kNotFound,
       "There is no such asset; PUT /v1/assets/{sha256} or POST /v1/assets uploads one.");
}

std::optional<ContentHash> hash_in(std::string_view path) {
  return parse_hash(path.substr(kFolder.size()));
}

ContentHash known_hash(const Request& request) {
  const auto hash = hash_in(request.path);
  if (!hash) fail_unknown();
  return *hash;
}

ContentHash wanted_hash(const Request& request) {
  const auto hash = hash_in(request.path);
  if (!hash) {
    fail(ErrorCode::kInvalidRequest,
         "An asset's address ends with the 64 lower-case hexadecimal digits of its SHA-256.");
  }
  return *hash;
}

std::string_view type_of(const AssetEntry& entry) {
  return entry.about.media_type.empty() ? kUnknownType : std::string_view(entry.about.media_type);
}

std::string entry_json(const AssetEntry& entry) {
  const std::string name =
      entry.about.name.empty() ? "" : fmt::format(R"(, "name": {})", api::quoted(entry.about.name));
  return fmt::format(R"({{"id": "asset:{}", "bytes": {}, "mediaType": {}{}}})", asset_id(entry.hash),
                     entry.bytes, api::quoted(type_of(entry)), name);
}

Reply json_reply(int status, std::string json) {
  return Reply{status, "application/json", std::move(json) + '\n', {}}.with("Cache-Control", "no-cache");
}

Reply report(const AssetStore::Kept& kept) {
  return json_reply(kept.is_new ? 201 : 200, entry_json(kept.entry))
      .with("Location", std::string(kFolder) + kept.entry.hash.hex());
}

AssetOwner owner_of(const Request& request) {
  return {request.client.name, request.client.asset_bytes};
}

// What a browser or curl says of any body is not said of this one.
AssetAbout about_of(const Request& request) {
  const std::string type = media_type_essence(request.header("Content-Type"));
  return {type == "application/x-www-form-urlencoded" ? std::string() : type,
          media_type_parameter(request.header("Content-Disposition"), "filename")};
}

Reply keep(AssetStore& store, const Request& request, const std::optional<ContentHash>& wanted) {
  const auto upload =
      request.sink ? std::dynamic_pointer_cast<AssetStore::Upload>(request.sink) : store.begin();
  return report(store.keep(*upload, wanted, about_of(request), owner_of(request)));
}

// --- a form of several files

// Uploads of a form's parts, kept when all of them have come.
class Form : public BodySink, private PartListener {
 public:
  Form(AssetStore& store, std::string_view content_type, int max_parts)
      : store_(store), reader_(content_type, max_parts, *this) {}

  void take(std::string_view bytes) override { reader_.take(bytes); }

  Reply keep(const AssetOwner& owner) {
    reader_.finish();
    if (parts_.empty()) fail(ErrorCode::kInvalidRequest, "The form has no part; send each file as one.");
    std::string list;
    bool is_new = false;
    for (const Arrived& part : parts_) {
      const AssetAbout about{part.head.media_type,
                             part.head.file_name.empty() ? part.head.name : part.head.file_name};
      const AssetStore::Kept kept = store_.keep(*part.upload, std::nullopt, about, owner);
      is_new = is_new || kept.is_new;
      const std::string entry = entry_json(kept.entry);
      list += fmt::format(R"({}{{"part": {}, {})", list.empty() ? "" : ", ", api::quoted(part.head.name),
                          std::string_view(entry).substr(1));
    }
    return json_reply(is_new ? 201 : 200, fmt::format(R"({{"assets": [{}]}})", list));
  }

 private:
  struct Arrived {
    PartHead head;
    std::shared_ptr<AssetStore::Upload> upload;
  };

  void begin(PartHead head) override { parts_.push_back({std::move(head), store_.begin()}); }
  void take_part(std::string_view bytes) override { parts_.back().upload->take(bytes); }
  void end() override {}

  AssetStore& store_;
  std::vector<Arrived> parts_;
  MultipartReader reader_;
};

bool is_form(const Request& request) {
  return media_type_essence(request.header("Content-Type")) == "multipart/form-data";
}

// A form may have more than one file of the largest size; what comes in at once is bounded by the store.
Incoming receive_post(const Doors& doors, const Request& head) {
  AssetStore& store = *doors.assets;
  if (!is_form(head)) return {store.begin(), store.largest_bytes()};
  return {std::make_shared<Form>(store, head.header("Content-Type"), doors.max_parts),
          store.largest_bytes() * doors.max_parts};
}

Reply post(const Doors& doors, const Request& request) {
  if (!is_form(request)) return keep(*doors.assets, request, std::nullopt);
  const auto form =
      request.sink ? std::dynamic_pointer_cast<Form>(request.sink)
                   : std::make_shared<Form>(*doors.assets, request.header("Content-Type"), doors.max_parts);
  return form->keep(owner_of(request));
}

// --- a file in one request, or in several

// None where the body is the whole file.
std::optional<ContentRange> range_of(const Request& request) {
  const std::string_view field = request.header("Content-Range");
  if (field.empty()) return std::nullopt;
  const auto range = parse_content_range(field);
  if (!range) {
    fail(ErrorCode::kInvalidRequest,
         "Content-Range is not of the form \"bytes FIRST-LAST/TOTAL\", or \"bytes */TOTAL\" to ask what is "
         "there.");
  }
  return range;
}

PartialUploads::Id upload_id(const Request& request) {
  return {wanted_hash(request), request.client.name};
}

Reply tell_received(Reply reply, std::int64_t received) {
  if (received > 0) reply.with("Range", fmt::format("bytes=0-{}", received - 1));
  return std::move(reply.with("Upload-Offset", std::to_string(received)));
}

Reply incomplete(const AssetStore& store, const Request& request, const ContentRange& range) {
  const PartialUploads::Id id = upload_id(request);
  const std::int64_t received = store.received(id);
  return tell_received(
      json_reply(202, fmt::format(R"({{"id": "asset:{}", "receivedBytes": {}, "bytes": {}}})",
                                  asset_id(id.hash), received, range.total)),
      received);
}

Reply out_of_turn(const AssetStore& store, const Request& request, const ContentRange& range) {
  const std::int64_t received = store.received(upload_id(request));
  const std::string detail =
      received == range.first
          ? "Another request sends bytes of this asset just now."
          : fmt::format("{} bytes are there, so the next ones begin at {}.", received, received);
  return tell_received({409,
                        std::string(api::kProblemMediaType),
                        api::blank_problem_json(409, "Conflict", detail, request.id, request.trace.trace_id),
                        {}},
                       received);
}

// An asset that is there already is answered from the head.
Incoming receive_put(AssetStore& store, const Request& head) {
  const Incoming unwanted{nullptr, store.largest_bytes(), true};
  if (store.find(wanted_hash(head))) return unwanted;
  const auto range = range_of(head);
  if (!range) return {store.begin(), store.largest_bytes()};
  if (range->only_asks()) return unwanted;
  const auto upload = store.resume(upload_id(head), *range);
  return upload ? Incoming{upload, store.largest_bytes()} : unwanted;
}

Reply put(AssetStore& store, const Request& request) {
  const ContentHash hash = wanted_hash(request);
  const auto known = request.sink ? std::nullopt : store.find(hash);
  if (known) return report({*known, false});
  const auto range = range_of(request);
  if (!range) return keep(store, request, hash);
  if (range->only_asks()) return incomplete(store, request, *range);
  const auto upload = request.sink ? std::dynamic_pointer_cast<AssetStore::Upload>(request.sink)
                                   : store.resume(upload_id(request), *range);
  if (!upload) return out_of_turn(store, request, *range);
  const auto kept = store.keep_when_whole(*upload, hash, about_of(request), owner_of(request));
  return kept ? report(*kept) : incomplete(store, request, *range);
}

// RFC 8246: what stands at this address never changes. Somebody else may have put it there: it is no document of ours.
Reply& with_validators(Reply& reply, const AssetEntry& entry) {
  return reply.with("ETag", '"' + entry.hash.hex() + '"')
      .with("Cache-Control", "private, max-age=31536000, immutable")
      .with("Content-Disposition", "attachment");
}

Reply get(AssetStore& store, const Request& request) {
  const ContentHash hash = known_hash(request);
  const auto entry = store.find(hash);
  if (!entry) fail_unknown();
  Reply reply{200, std::string(type_of(*entry)), {}, {}};
  if (etag_matches(request.header("If-None-Match"), hash.hex())) {
    reply = Reply{304, {}, {}, {}};
  } else if (request.method == "HEAD") {
    reply.file = std::shared_ptr<const FileBody>(new FileBody{{}, entry->bytes});  // only its length is told
  } else {
    reply.file = store.open(hash);
    if (!reply.file) fail_unknown();
  }
  return std::move(with_validators(reply, *entry));
}

Reply get_or_inspect(const Doors& doors, const Request& request) {
  const std::string_view path = request.path;
  if (!path.ends_with(kInspect)) return get(*doors.assets, request);
  const auto hash = hash_in(path.substr(0, path.size() - kInspect.size()));
  if (!hash) fail_unknown();
  return inspect_model(doors, fmt::format(R"({{"model":"asset:{}"}})", asset_id(*hash)), {},
                       request.deadline);
}

// Of a key its own; of an administrator's all.
bool may_erase(const Client& client, const AssetEntry& entry) {
  return entry.owner.empty() || entry.owner == client.name || (client.scopes & scope::kAdmin) != 0;
}

Reply erase(AssetStore& store, const Request& request) {
  const ContentHash hash = known_hash(request);
  const auto entry = store.find(hash);
  if (entry && !may_erase(request.client, *entry)) {
    return {403,
            std::string(api::kProblemMediaType),
            api::blank_problem_json(403, "Forbidden", "Another key has uploaded this asset.", request.id,
                                    request.trace.trace_id),
            {}};
  }
  if (!store.erase(hash)) fail_unknown();
  return Reply{204, {}, {}, {}};
}

}  // namespace

std::vector<Route> asset_routes(const Doors& doors) {
  if (doors.assets == nullptr) return {};
  AssetStore& store = *doors.assets;
  return {
      {"POST", "/v1/assets", [doors](const Request& request) { return post(doors, request); }, scope::kAssets,
       false, [doors](const Request& head) { return receive_post(doors, head); }},
      {"PUT", "/v1/assets/*", [&store](const Request& request) { return put(store, request); },
       scope::kAssets, false, [&store](const Request& head) { return receive_put(store, head); }},
      {"GET", "/v1/assets/*", [doors](const Request& request) { return get_or_inspect(doors, request); },
       scope::kRender | scope::kAssets},
      {"DELETE", "/v1/assets/*", [&store](const Request& request) { return erase(store, request); },
       scope::kAssets},
  };
}

AssetResolver references(const Doors& doors, std::map<std::string, Blob> parts, const Deadline& deadline) {
  return {doors.files,
          std::move(parts),
          doors.capabilities.import,
          [&environments = doors.environments](const std::string& name) { return environments.find(name); },
          [store = doors.assets](const std::string& id) -> std::optional<Blob> {
            return store == nullptr ? std::nullopt : store->read(parse_asset_id(id));
          },
          doors.remote == nullptr ? AssetResolver::RemoteFiles() : doors.remote->of_request(deadline)};
}

}  // namespace furnace
