// References in a request -> bytes. What "part:", "file:" and "asset:" mean is decided here, once, for every door. A model's
// file may be a ZIP archive of the model and the files it names.
#pragma once

#include "renderer/scene/gltf_import.hpp"
#include "renderer/base/blob.hpp"
#include "renderer/base/budget_cache.hpp"

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace furnace {

// Files by the URI that a model names them with, before any that lie beside it.
using NamedFiles = std::map<std::string, Blob>;

// Reads files below configured roots. A file is hashed once and again only when its (device, inode, size, mtime) changed.
// Refuses paths that leave every root (.., symlinks), says so without telling what exists outside.
// Threads: any. Owns: a byte-bounded cache of file contents.
class FileAssets {
 public:
  FileAssets(std::vector<std::filesystem::path> roots, std::int64_t cache_bytes, std::int64_t max_file_bytes);

  Blob read(const std::string& relative, const std::string& pointer);
  // The document and every file it names, resolved beside it, or in its archive.
  std::shared_ptr<const ModelBundle> read_model(const std::string& relative, const std::string& pointer,
                                                const ImportLimits& limits, const NamedFiles& named = {});

 private:
  struct State;
  std::shared_ptr<State> state_;
};

// What a reference turned out to be.
struct ReadReference {
  std::string reference, pointer;
  Blob file;                                 // of a model: empty
  std::shared_ptr<const ModelBundle> model;  // null: a file
};

// What a request may refer to. `parts` are the files of a multipart request, by part name and by file name.
// Threads: one request.
class AssetResolver {
 public:
  // Environments by the names their users gave them; none: there is no such name.
  using NamedEnvironments = std::function<std::optional<Blob>(const std::string& name)>;

  // What was uploaded, by what stands between "asset:" and the next slash; none: there is no such asset. Errors: any.
  using UploadedAssets = std::function<std::optional<Blob>(const std::string& id)>;

  AssetResolver(FileAssets& files, std::map<std::string, Blob> parts, ImportLimits limits,
                NamedEnvironments environments = {}, UploadedAssets uploads = {});

  // From now on tells of every read in `reads`, which outlives this.
  void record(std::vector<ReadReference>& reads) { reads_ = &reads; }

  // `reference` is "part:NAME", "file:RELATIVE", "environment:NAME", "asset:ID", "asset:ID/PATH" (a file in an archive),
  // "data:..." (base64 or percent-encoded); `pointer` is its place in the request.
  // Errors: kUnprocessable for an unknown scheme, a broken data: URI or archive, kNotFound for a name that is not there.
  Blob read(const std::string& reference, const std::string& pointer) const;
  // As read, with the siblings that a .gltf, an OBJ and its MTL files, or a PLY name: other parts of the request by name or file name (also by the last path segment), or files
  // beside the document; first of all those of `named`. What is missing is left out: the importer tells of it.
  std::shared_ptr<const ModelBundle> read_model(const std::string& reference, const std::string& pointer,
                                                const NamedFiles& named = {}) const;

 private:
  Blob uploaded(const std::string& id) const;
  Blob look_up(const std::string& reference, const std::string& pointer) const;
  std::shared_ptr<const ModelBundle> find_model(const std::string& reference, const std::string& pointer,
                                                const NamedFiles& named) const;

  FileAssets* files_;
  std::map<std::string, Blob> parts_;
  ImportLimits limits_;
  NamedEnvironments environments_;
  UploadedAssets uploads_;
  std::vector<ReadReference>* reads_ = nullptr;
};

}  // namespace furnace
