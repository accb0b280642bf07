// Files that clients have uploaded, below a folder, each named by the SHA-256 of its bytes:
//   ab/abcd...        the bytes; the file's time is when they were last asked for
//   ab/abcd....about  when they came, their media type and name
//   uploads/          what is coming in
//   partial/          what comes in over several requests
//   damaged/          files whose bytes are no longer those of their name
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/blob.hpp"
#include "renderer/base/budget_cache.hpp"
#include "renderer/base/byte_hasher.hpp"
#include "server/content_range.hpp"
#include "server/file_body.hpp"
#include "server/http_types.hpp"
#include "server/partial_uploads.hpp"
#include "server/upload_file.hpp"

namespace furnace {

struct AssetStoreConfig {
  using Time = std::filesystem::file_time_type;
  std::filesystem::path folder;              // made by the first upload; empty: nothing can be uploaded
  std::int64_t largest_bytes = 256ll << 20;  // of one asset
  std::int64_t budget_bytes =
      4ll << 30;  // of all assets together, each counted as 4 KiB at least; of all uploads too
  std::chrono::milliseconds ttl{0};                                // unused for longer: removed; 0: never
  std::chrono::milliseconds partial_ttl = std::chrono::hours(24);  // the same of what is incomplete
  std::int64_t memory_bytes = 0;                                   // assets kept in memory for renders
  std::function<Time()> now = Time::clock::now;
};

// What a client says of an asset; text beyond printable ASCII, and beyond 200 bytes, is dropped.
struct AssetAbout {
  std::string media_type = {};  // "": application/octet-stream
  std::string name = {};        // may be empty
};

// Who uploads. An asset belongs to who was first to upload it.
struct AssetOwner {
  std::string name = {};         // a key's; "": nobody
  std::int64_t quota_bytes = 0;  // what all that belongs to it may have, counted as in the budget; 0: any
};

struct AssetEntry {
  ContentHash hash;
  std::int64_t bytes = 0;
  AssetAbout about;
  std::int64_t created_ms = 0;  // since the epoch
  std::string owner = {};       // AssetOwner::name
};

// Threads: any. Owns: the files below its folder, which other processes may share; uploads in flight.
class AssetStore {
 public:
  explicit AssetStore(AssetStoreConfig config);

  // An asset that is coming in. Nothing is on the disk before the first byte; what is not kept is removed.
  // Threads: one. Owns: its temporary file. The store outlives it.
  class Upload : public BodySink {
   public:
    explicit Upload(AssetStore& store) : store_(store) {}
    // `range` of a whole that has come up to its first byte; what was taken stays.
    Upload(AssetStore& store, UploadFile partial, const ContentRange& range)
        : store_(store), range_(range), file_(std::move(partial)) {}
    ~Upload() override;
    // Errors: kTooLarge, kOverloaded (too much comes in at once), kInvalidRequest (more than the range), kStorage.
    void take(std::string_view bytes) override;
    std::int64_t bytes() const { return bytes_; }

   private:
    friend class AssetStore;
    AssetStore& store_;
    const std::optional<ContentRange> range_;
    UploadFile file_;
    ByteHasher hasher_;
    std::int64_t bytes_ = 0;  // taken
  };

  // Errors: kStorage when nothing can be uploaded.
  std::shared_ptr<Upload> begin();
  struct Kept {
    AssetEntry entry;
    bool is_new = false;
  };
  // Keeps what was uploaded, for good when this returns; `wanted`: the hash it must have. Removes what was not used for
  // longest, but nothing that is in use. Errors: kInvalidRequest (empty), kUnprocessable (another hash), kOverloaded (no
  // room), kTooLarge (the owner's quota), kStorage.
  Kept keep(Upload& upload, const std::optional<ContentHash>& wanted, const AssetAbout& about,
            const AssetOwner& owner = {});

  // What is there of an asset that comes in over several requests of one client.
  std::int64_t received(const PartialUploads::Id& id) const { return partial_.received(id); }
  // To take the bytes of `range`; null when they are not the next ones, or when another request sends just now.
  // Errors: kTooLarge, kOverloaded, kStorage.
  std::shared_ptr<Upload> resume(const PartialUploads::Id& id, const ContentRange& range);
  // As keep, once all is there; none before. What turns out to be another asset is removed.
  std::optional<Kept> keep_when_whole(Upload& upload, const ContentHash& wanted, const AssetAbout& about,
                                      const AssetOwner& owner = {});

  // Counts as use. None: there is no such asset, or not any more.
  std::optional<AssetEntry> find(const ContentHash& hash);
  // The bytes, verified. None as find, and when they were damaged. Errors: kStorage.
  std::optional<Blob> read(const ContentHash& hash);
  // Likewise, for sending; the asset is in use until it is gone.
  std::shared_ptr<const FileBody> open(const ContentHash& hash);
  bool erase(const ContentHash& hash);  // false: there was none

  std::int64_t largest_bytes() const { return config_.largest_bytes; }
  struct Stats {
    std::int64_t assets = 0, bytes = 0;  // at the last count of what is on the disk, and since
    std::int64_t uploads = 0;            // kept, repeated ones too
  };
  Stats stats() const { return {assets_, bytes_, uploads_}; }

 private:
  struct Listed;
  using Path = std::filesystem::path;
  using Time = AssetStoreConfig::Time;

  void need_folder() const;
  Path path_of(const ContentHash& hash) const;
  Path about_of(const ContentHash& hash) const;
  std::optional<std::int64_t> touch(const ContentHash& hash);
  std::shared_ptr<const void> use(const ContentHash& hash);
  bool is_used(const ContentHash& hash) const;
  bool has_expired(Time used) const;
  AssetEntry entry_of(const ContentHash& hash, std::int64_t bytes) const;
  Kept admit(UploadFile& file, AssetEntry entry, std::int64_t quota_bytes);
  void publish(UploadFile& file, const AssetEntry& entry);
  std::int64_t& owned_by(const std::string& owner);
  void forget(const ContentHash& hash, std::int64_t bytes);
  void set_aside(const ContentHash& hash);
  void remove_widowed_abouts();
  std::vector<Listed> list() const;
  bool trim(std::int64_t room_bytes);
  void sweep();

  const AssetStoreConfig config_;
  PartialUploads partial_;
  BudgetCache<Blob> in_memory_;
  std::atomic<std::int64_t> coming_bytes_{0};  // of all uploads in flight
  std::atomic<std::int64_t> assets_{0}, bytes_{0}, uploads_{0};
  std::mutex change_mutex_;  // what is kept and removed, one after the other
  Time swept_{};             // belongs to it
  std::optional<std::map<std::string, std::int64_t>>
      owned_;                 // likewise: bytes by owner, once they were asked for
  mutable std::mutex mutex_;  // of the member below
  std::map<ContentHash, int> uses_;
};

// "sha256-" and 64 lower-case hexadecimal digits, as in "asset:sha256-...": what is written in a request.
std::string asset_id(const ContentHash& hash);
// Errors: kUnprocessable for anything else.
ContentHash parse_asset_id(std::string_view id);

}  // namespace furnace
