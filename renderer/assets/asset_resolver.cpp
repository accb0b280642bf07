#include "renderer/assets/asset_resolver.hpp"
#include "renderer/assets/zip_reader.hpp"

#include "renderer/scene/gltf_container.hpp"
#include "renderer/scene/model_import.hpp"
#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"

#include <algorithm>
#include <cctype>
#include <functional>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace furnace {

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kUriCacheBytes = 4 << 20;
constexpr int kReadAttempts = 3;  // of a file that changes while it is read

// What `body` finds wrong is wrong at this place of the request; an error that points into a model's own document keeps its
// pointer and gets the place as a breadcrumb.
template <class Body>
auto at(const std::string& pointer, Body&& body) -> decltype(body()) {
  try {
    return body();
  } catch (Error& error) {
    if (error.pointer.empty()) error.pointer = pointer;
    error.context.push_back(pointer);
    throw;
  }
}

// One text for a missing file and for one that a link leads out of the roots: nobody learns what exists
// outside.
[[noreturn]] void fail_missing_file(const std::string& relative) {
  fail(ErrorCode::kNotFound, "there is no file \"" + relative + "\" in the asset folders");
}

void check_relative(const std::string& relative) {
  const fs::path path(relative);
  const bool climbs = std::ranges::find(path, fs::path("..")) != path.end();
  const bool is_plain =
      !relative.empty() && relative.find('\0') == std::string::npos && path.is_relative() && !climbs;
  if (is_plain) return;
  fail(ErrorCode::kUnprocessable, "a file is named by a path relative to the asset folders, without \"..\"");
}

bool is_below(const fs::path& root, const fs::path& path) {
  return std::ranges::mismatch(root, path).in1 == root.end();
}

ContentHash identity_key(const FileIdentity& identity) {
  return HashBuilder()
      .add(static_cast<std::int64_t>(identity.device))
      .add(static_cast<std::int64_t>(identity.inode))
      .add(identity.size_bytes)
      .add(identity.modified_ns)
      .finish();
}

std::string_view last_segment(std::string_view path) {
  return path.substr(path.find_last_of('/') + 1);
}

std::string folder_of(const std::string& path) {
  return path.substr(0, path.size() - last_segment(path).size());
}

using Uris = std::vector<std::string>;

// Gives a sibling by its URI, or none.
using FindSibling = std::function<std::optional<Blob>(const std::string&)>;

// What the MTL files name: beside them, else beside the model.
void add_textures(const Uris& libraries, const FindSibling& find, ModelBundle& bundle) {
  for (const std::string& library : libraries) {
    const auto file = bundle.siblings.find(library);
    if (file == bundle.siblings.end()) continue;
    const std::string folder = folder_of(library);
    for (const std::string& name : texture_names(file->second.text())) {
      if (bundle.siblings.size() >= kMostSiblings) return;
      if (bundle.siblings.contains(name)) continue;
      std::optional<Blob> texture = find(folder + name);
      if (!texture && !folder.empty()) texture = find(name);
      if (texture) bundle.siblings.emplace(name, *std::move(texture));
    }
  }
}

std::shared_ptr<const ModelBundle> make_bundle(Blob document, ModelFormat format, const Uris& uris,
                                               const FindSibling& find) {
  auto bundle = std::make_shared<ModelBundle>();
  bundle->document = std::move(document);
  bundle->format = format;
  for (const std::string& uri : uris) {
    if (std::optional<Blob> sibling = find(uri)) bundle->siblings.emplace(uri, *std::move(sibling));
  }
  if (format == ModelFormat::kObj) add_textures(uris, find, *bundle);
  bundle->seal();
  return bundle;
}

std::optional<Blob> find_named(const NamedFiles& files, const std::string& name) {
  const auto found = files.find(name);
  return found == files.end() ? std::nullopt : std::optional(found->second);
}

Blob file_in(const ZipReader& archive, const std::string& path) {
  std::optional<Blob> file = archive.read(path);
  if (!file) fail(ErrorCode::kNotFound, "there is no file \"" + readable_text(path) + "\" in the archive");
  return *std::move(file);
}

bool is_same_name(std::string_view a, std::string_view b) {
  const auto lower = [](unsigned char c) { return std::tolower(c); };
  return std::ranges::equal(a, b, {}, lower, lower);
}

// Where an OBJ or a PLY says that its textures are is a folder of the machine that wrote it: the file of that name, wherever
// it lies in the archive and however its name is capitalised; none if there are several.
std::optional<Blob> find_anywhere(const ZipReader& archive, const std::string& uri) {
  std::optional<std::string> found;
  for (const std::string& name : archive.names()) {
    if (!is_same_name(last_segment(name), last_segment(uri))) continue;
    if (found) return std::nullopt;
    found = name;
  }
  return found ? archive.read(*found) : std::nullopt;
}

// `path`: of the model in the archive; "": the only one. `named` comes before the archive's files, `find` after them.
std::shared_ptr<const ModelBundle> read_archive(const Blob& file, std::string path,
                                                const ImportLimits& limits, const NamedFiles& named,
                                                const FindSibling& find) {
  const ZipReader archive(file);
  if (path.empty()) path = model_in(archive);
  Blob document = file_in(archive, path);
  const ModelFormat format = model_format(document, path);
  const Uris uris = model_siblings(document, format, limits);
  const std::string folder = folder_of(path);
  return make_bundle(std::move(document), format, uris, [&](const std::string& uri) {
    if (std::optional<Blob> file = find_named(named, uri)) return file;
    std::optional<Blob> sibling = archive.read(fs::path(folder + uri).lexically_normal().string());
    if (!sibling) sibling = find(uri);
    return sibling || format == ModelFormat::kGltf ? sibling : find_anywhere(archive, uri);
  });
}

}  // namespace

struct FileAssets::State {
  std::vector<fs::path> roots;  // canonical
  std::int64_t max_file_bytes;
  BudgetCache<Blob> contents;  // by FileIdentity
  BudgetCache<Uris> uris;      // by the document's hash and format

  State(std::int64_t cache_bytes, std::int64_t max_bytes)
      : max_file_bytes(max_bytes),
        contents(cache_bytes, [](const Blob& blob) { return static_cast<std::int64_t>(blob.size()); }),
        uris(kUriCacheBytes, [](const Uris& list) {
          std::size_t bytes = sizeof(Uris);
          for (const std::string& uri : list) bytes += sizeof(std::string) + uri.size();
          return static_cast<std::int64_t>(bytes);
        }) {}

  fs::path resolve(const std::string& relative) const;
  Blob read(const std::string& relative);
};

fs::path FileAssets::State::resolve(const std::string& relative) const {
  check_relative(relative);
  for (const fs::path& root : roots) {
    std::error_code error;
    const fs::path path =
        fs::canonical(root / relative, error);  // links resolved; an error when it does not exist
    if (!error && is_below(root, path) && file_identity(path)) return path;
  }
  fail_missing_file(relative);
}

Blob FileAssets::State::read(const std::string& relative) {
  const fs::path path = resolve(relative);
  for (int attempt = 0; attempt < kReadAttempts; ++attempt) {
    const std::optional<FileIdentity> before = file_identity(path);
    if (!before) fail_missing_file(relative);
    const auto blob = contents.get_or_load(identity_key(*before), Deadline{},
                                           [&] { return Blob(read_file(path, max_file_bytes)); });
    if (file_identity(path) == before) return *blob;
  }
  fail(ErrorCode::kStorage, "the file \"" + relative + "\" is being written");
}

FileAssets::FileAssets(std::vector<fs::path> roots, std::int64_t cache_bytes, std::int64_t max_file_bytes)
    : state_(std::make_shared<State>(cache_bytes, max_file_bytes)) {
  for (const fs::path& root : roots) state_->roots.push_back(fs::weakly_canonical(root));
}

Blob FileAssets::read(const std::string& relative, const std::string& pointer) {
  return at(pointer, [&] { return state_->read(relative); });
}

std::shared_ptr<const ModelBundle> FileAssets::read_model(const std::string& relative,
                                                          const std::string& pointer,
                                                          const ImportLimits& limits,
                                                          const NamedFiles& named) {
  return at(pointer, [&] {
    const Blob document = state_->read(relative);
    const std::string folder = folder_of(relative);
    const auto find = [&](const std::string& uri) -> std::optional<Blob> {
      if (std::optional<Blob> file = find_named(named, uri)) return file;
      try {
        return state_->read(folder + uri);
      } catch (const Error& error) {
        if (error.code == ErrorCode::kNotFound) return std::nullopt;
        throw;
      }
    };
    if (is_zip(document)) return read_archive(document, {}, limits, named, find);
    const ModelFormat format = model_format(document, relative);
    const ContentHash key = HashBuilder().add(document.hash()).add(std::int64_t(format)).finish();
    const auto uris =
        state_->uris.get_or_load(key, Deadline{}, [&] { return model_siblings(document, format, limits); });
    return make_bundle(document, format, *uris, find);
  });
}

namespace {

constexpr std::string_view kPartScheme = "part:";
constexpr std::string_view kFileScheme = "file:";
constexpr std::string_view kEnvironmentScheme = "environment:";
constexpr std::string_view kAssetScheme = "asset:";

[[noreturn]] void fail_unknown_scheme(const std::string& pointer) {
  fail(ErrorCode::kUnprocessable,
       "a reference begins with \"part:\", \"file:\", \"asset:\", \"data:\" or \"https:\"", pointer);
}

// Schemes of URLs compare without case (RFC 3986 section 3.1).
bool is_remote(std::string_view reference) {
  const std::size_t colon = std::min(reference.find(':'), std::size_t(8));
  std::string scheme(reference.substr(0, colon));
  std::ranges::transform(scheme, scheme.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return scheme == "https" || scheme == "http";
}

// Its path alone: an ending in the query says nothing of the file.
std::string without_query(const std::string& url) {
  return url.substr(0, url.find_first_of("?#"));
}

struct AssetName {
  std::string id;
  std::string path;  // in the archive that it is; "": the asset itself
};

AssetName asset_name(const std::string& reference) {
  const std::size_t slash = std::min(reference.find('/'), reference.size());
  return {reference.substr(kAssetScheme.size(), slash - kAssetScheme.size()),
          reference.substr(std::min(slash + 1, reference.size()))};
}

// By its whole name, else by the last segments of both names; two different files of that name are refused.
std::optional<Blob> find_sibling(const std::map<std::string, Blob>& parts, const std::string& uri) {
  if (const auto exact = parts.find(uri); exact != parts.end()) return exact->second;
  std::optional<Blob> found;
  for (const auto& [name, blob] : parts) {
    if (last_segment(name) != last_segment(uri)) continue;
    if (found && found->hash() != blob.hash()) {
      fail(ErrorCode::kUnprocessable,
           "the model refers to \"" + uri +
               "\", and two different parts of the request could be meant; name one so");
    }
    found = blob;
  }
  return found;
}

}  // namespace

AssetResolver::AssetResolver(FileAssets& files, std::map<std::string, Blob> parts, ImportLimits limits,
                             NamedEnvironments environments, UploadedAssets uploads, RemoteFiles remote)
    : files_(&files),
      parts_(std::move(parts)),
      limits_(limits),
      environments_(std::move(environments)),
      uploads_(std::move(uploads)),
      remote_(std::move(remote)) {}

Blob AssetResolver::uploaded(const std::string& id) const {
  std::optional<Blob> file = uploads_ ? uploads_(id) : std::nullopt;
  if (!file) fail(ErrorCode::kNotFound, "there is no asset \"" + readable_text(id) + "\"; upload it (again)");
  return *std::move(file);
}

std::optional<Blob> AssetResolver::remote(const std::string& url, const std::string& relative) const {
  if (remote_) return remote_(url, relative);
  fail(ErrorCode::kUnprocessable,
       "files of other servers are not fetched here: the operator names the hosts with remote-allow; upload "
       "the file instead, or send it as a part");
}

Blob AssetResolver::read(const std::string& reference, const std::string& pointer) const {
  Blob file = look_up(reference, pointer);
  if (reads_ != nullptr) reads_->push_back({reference, pointer, file, nullptr});
  return file;
}

std::shared_ptr<const ModelBundle> AssetResolver::read_model(const std::string& reference,
                                                             const std::string& pointer,
                                                             const NamedFiles& named) const {
  auto model = find_model(reference, pointer, named);
  if (reads_ != nullptr) reads_->push_back({reference, pointer, {}, model});
  return model;
}

Blob AssetResolver::look_up(const std::string& reference, const std::string& pointer) const {
  if (reference.starts_with(kPartScheme)) {
    const std::string name = reference.substr(kPartScheme.size());
    const auto part = parts_.find(name);
    if (part == parts_.end()) fail(ErrorCode::kNotFound, "the request has no part \"" + name + "\"", pointer);
    return part->second;
  }
  if (reference.starts_with(kFileScheme)) return files_->read(reference.substr(kFileScheme.size()), pointer);
  if (reference.starts_with(kEnvironmentScheme)) {
    const std::string name = reference.substr(kEnvironmentScheme.size());
    std::optional<Blob> file = environments_ ? environments_(name) : std::nullopt;
    if (!file) fail(ErrorCode::kNotFound, "there is no environment named \"" + name + "\"", pointer);
    return *std::move(file);
  }
  if (reference.starts_with(kAssetScheme)) {
    return at(pointer, [&] {
      const AssetName name = asset_name(reference);
      const Blob file = uploaded(name.id);
      return name.path.empty() ? file : file_in(ZipReader(file), name.path);
    });
  }
  if (is_data_uri(reference)) return Blob(decode_data_uri(reference, pointer));
  if (is_remote(reference)) return at(pointer, [&] { return remote(reference, {}).value(); });
  fail_unknown_scheme(pointer);
}

std::shared_ptr<const ModelBundle> AssetResolver::find_model(const std::string& reference,
                                                             const std::string& pointer,
                                                             const NamedFiles& named) const {
  if (reference.starts_with(kFileScheme))
    return files_->read_model(reference.substr(kFileScheme.size()), pointer, limits_, named);
  return at(pointer, [&] {
    const bool is_far = is_remote(reference);
    const auto find = [&](const std::string& uri) {
      std::optional<Blob> file = find_named(named, uri);
      if (!file) file = find_sibling(parts_, uri);
      return file || !is_far ? file : remote(reference, uri);
    };
    const bool is_asset = reference.starts_with(kAssetScheme);
    const AssetName name = is_asset ? asset_name(reference) : AssetName{};
    Blob document = is_asset ? uploaded(name.id) : look_up(reference, pointer);
    if (is_zip(document) || !name.path.empty())
      return read_archive(document, name.path, limits_, named, find);
    const ModelFormat format = model_format(document, is_data_uri(reference) ? std::string()
                                                      : is_far               ? without_query(reference)
                                                                             : reference);
    const Uris uris = model_siblings(document, format, limits_);
    return make_bundle(std::move(document), format, uris, find);
  });
}

}  // namespace furnace
