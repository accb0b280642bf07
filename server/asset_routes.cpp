#include "server/asset_routes.hpp"

#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "api/document.hpp"
#include "server/asset_store.hpp"
#include "server/hash_text.hpp"
#include "server/inspect_routes.hpp"
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

Reply report(int status, const AssetEntry& entry) {
  const std::string name =
      entry.about.name.empty() ? "" : fmt::format(R"(, "name": {})", api::quoted(entry.about.name));
  return Reply{status,
               "application/json",
               fmt::format(R"({{"id": "asset:{}", "bytes": {}, "mediaType": {}{}}})"
                           "\n",
                           asset_id(entry.hash), entry.bytes, api::quoted(type_of(entry)), name),
               {}}
      .with("Location", std::string(kFolder) + entry.hash.hex())
      .with("Cache-Control", "no-cache");
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
  const AssetStore::Kept kept = store.keep(*upload, wanted, about_of(request));
  return report(kept.is_new ? 201 : 200, kept.entry);
}

// An asset that is there already is answered from the head.
Incoming receive_put(AssetStore& store, const Request& head) {
  if (store.find(wanted_hash(head))) return {nullptr, store.largest_bytes(), true};
  return {store.begin(), store.largest_bytes()};
}

Reply put(AssetStore& store, const Request& request) {
  const ContentHash hash = wanted_hash(request);
  const auto known = request.sink ? std::nullopt : store.find(hash);
  return known ? report(200, *known) : keep(store, request, hash);
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

Reply erase(AssetStore& store, const Request& request) {
  if (!store.erase(known_hash(request))) fail_unknown();
  return Reply{204, {}, {}, {}};
}

}  // namespace

std::vector<Route> asset_routes(const Doors& doors) {
  if (doors.assets == nullptr) return {};
  AssetStore& store = *doors.assets;
  return {
      {"POST", "/v1/assets", [&store](const Request& request) { return keep(store, request, std::nullopt); },
       scope::kAssets, false,
       [&store](const Request&) {
         return Incoming{store.begin(), store.largest_bytes()};
       }},
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
