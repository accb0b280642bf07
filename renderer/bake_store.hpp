// Baked environments and backgrounds kept on disk, so that a restart does not bake or blur again what was before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "renderer/base/file_store.hpp"
#include "renderer/bake_file.hpp"

namespace furnace {

// FOLDER/bakes/vN/KEY.exr, one file a bake or background (bake_file.hpp), N the version of its layout. As FileStore otherwise.
// Threads: any. Owns: the files below FOLDER/bakes; one object per folder and process.
class BakeStore {
 public:
  BakeStore(const std::filesystem::path& folder, std::int64_t budget_bytes)
      : files_({folder / "bakes", "bakes", "exr", kBakeFileLayout, budget_bytes, kLargestBakeFileBytes}) {}

  // Exactly what was saved under `key`, or nothing.
  std::optional<StoredBake> load(const ContentHash& key) {
    return files_.load(key, [&](const std::string& file) { return decode_bake(key, file); });
  }
  bool save(const ContentHash& key, const StoredBake& bake) {
    return files_.save(key, [&] { return encode_bake(key, bake); });
  }
  std::optional<StoredBackground> load_background(const ContentHash& key) {
    return files_.load(key, [&](const std::string& file) { return decode_background(key, file); });
  }
  bool save_background(const ContentHash& key, const StoredBackground& background) {
    return files_.save(key, [&] { return encode_background(key, background); });
  }

  FileStore::Stats stats() const { return files_.stats(); }
  std::filesystem::path path_of(const ContentHash& key) const { return files_.path_of(key); }

 private:
  FileStore files_;
};

}  // namespace furnace
