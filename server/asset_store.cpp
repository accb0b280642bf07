#include "server/asset_store.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <system_error>
#include <tuple>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/base/log.hpp"
#include "server/hash_text.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kIdScheme = "sha256-";
constexpr const char* kAboutEnding = ".about";
constexpr std::size_t kMaxAboutBytes = 200;  // of each text
constexpr std::int64_t kLeastCharge =
    4096;                                 // what a file takes of a disk, so that their number is bounded too
constexpr std::size_t kDamagedKept = 16;  // for whoever wants to know what happened
constexpr std::chrono::minutes kSweepPeriod{1};

std::int64_t charge(std::int64_t bytes) {
  return std::max(bytes, kLeastCharge);
}

std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c >= ' ' && c <= '~' && out.size() < kMaxAboutBytes) out += c;
  }
  return out;
}

std::int64_t to_ms(fs::file_time_type time) {
  const auto since = std::chrono::file_clock::to_sys(time).time_since_epoch();
  return std::chrono::duration_cast<std::chrono::milliseconds>(since).count();
}

// "CREATED_MS\tMEDIA_TYPE\tNAME\tOWNER\n"
std::string about_text(const AssetEntry& entry) {
  return fmt::format("{}\t{}\t{}\t{}\n", entry.created_ms, entry.about.media_type, entry.about.name,
                     entry.owner);
}

void read_about(std::string_view text, AssetEntry& entry) {
  std::array<std::string_view, 4> fields;
  for (std::string_view& field : fields) {
    field = text.substr(0, text.find_first_of("\t\n"));
    text.remove_prefix(std::min(field.size() + 1, text.size()));
  }
  std::from_chars(fields[0].data(), fields[0].data() + fields[0].size(), entry.created_ms);
  entry.about = {plain(fields[1]), plain(fields[2])};
  entry.owner = plain(fields[3]);
}

// Whether the bytes of an open file have this hash; leaves it where it was.
bool has_hash(int file, const ContentHash& hash) {
  std::vector<std::byte> piece(256 << 10);
  ByteHasher hasher;
  for (off_t offset = 0;;) {
    const ssize_t got = ::pread(file, piece.data(), piece.size(), offset);
    if (got < 0)
      fail(ErrorCode::kStorage, "The asset cannot be read.", {}, std::generic_category().message(errno));
    if (got == 0) return hasher.finish() == hash;
    hasher.add({piece.data(), static_cast<std::size_t>(got)});
    offset += got;
  }
}

}  // namespace

struct AssetStore::Listed {
  ContentHash hash;
  std::int64_t bytes;
  Time used;
};

AssetStore::AssetStore(AssetStoreConfig config)
    : config_(std::move(config)),
      partial_({config_.folder / "partial", config_.budget_bytes, config_.partial_ttl, config_.now}),
      in_memory_(config_.memory_bytes, [](const Blob& blob) { return std::int64_t(blob.size()); }) {
  if (config_.folder.empty()) return;
  UploadFile::remove_abandoned(config_.folder / "uploads");
  partial_.remove_stale();
  remove_widowed_abouts();
  const std::lock_guard changing(change_mutex_);
  swept_ = config_.now();
  trim(0);
}

AssetStore::Upload::~Upload() {
  store_.coming_bytes_ -= bytes_;
}

void AssetStore::Upload::take(std::string_view bytes) {
  const AssetStoreConfig& config = store_.config_;
  const auto size = std::int64_t(bytes.size());
  if (range_ && size > range_->end - range_->first - bytes_)
    fail(ErrorCode::kInvalidRequest, "The body is longer than its Content-Range says.");
  if (size > config.largest_bytes - bytes_)
    fail(ErrorCode::kTooLarge, fmt::format("An asset may have {} bytes.", config.largest_bytes));
  bytes_ += size;
  if ((store_.coming_bytes_ += size) > config.budget_bytes)
    fail(ErrorCode::kOverloaded, "Too many uploads at once; try again in a moment.");
  if (!file_.is_open()) file_ = UploadFile(config.folder / "uploads");
  file_.append(bytes);
  if (!range_) hasher_.add(std::as_bytes(std::span(bytes)));
}

void AssetStore::need_folder() const {
  if (config_.folder.empty()) {
    fail(ErrorCode::kStorage,
         "This server keeps no uploads: its operator has to start it with --data FOLDER (FURNACE_DATA).");
  }
}

std::shared_ptr<AssetStore::Upload> AssetStore::begin() {
  need_folder();
  return std::make_shared<Upload>(*this);
}

AssetStore::Kept AssetStore::keep(Upload& upload, const std::optional<ContentHash>& wanted,
                                  const AssetAbout& about, const AssetOwner& owner) {
  if (upload.bytes_ == 0) fail(ErrorCode::kInvalidRequest, "Send the file as the body.");
  AssetEntry entry{
      upload.hasher_.finish(), upload.bytes_, {plain(about.media_type), plain(about.name)}, 0, owner.name};
  if (wanted && *wanted != entry.hash) {
    fail(ErrorCode::kUnprocessable,
         fmt::format("The body's SHA-256 is {}, the address says {}; nothing was kept.", entry.hash.hex(),
                     wanted->hex()));
  }
  return admit(upload.file_, std::move(entry), owner.quota_bytes);
}

std::shared_ptr<AssetStore::Upload> AssetStore::resume(const PartialUploads::Id& id,
                                                       const ContentRange& range) {
  need_folder();
  if (range.total > config_.largest_bytes)
    fail(ErrorCode::kTooLarge, fmt::format("An asset may have {} bytes.", config_.largest_bytes));
  if (range.first != received(id)) return nullptr;
  UploadFile file = partial_.open(id, range.end - range.first);
  if (!file.is_open() || file.size() != range.first) return nullptr;
  return std::make_shared<Upload>(*this, std::move(file), range);
}

std::optional<AssetStore::Kept> AssetStore::keep_when_whole(Upload& upload, const ContentHash& wanted,
                                                            const AssetAbout& about,
                                                            const AssetOwner& owner) {
  const std::int64_t bytes = upload.file_.size();
  if (bytes < upload.range_->total) return std::nullopt;
  if (!has_hash(upload.file_.descriptor(), wanted)) {
    upload.file_.remove();
    fail(ErrorCode::kUnprocessable,
         "All that came is not the asset of this SHA-256; nothing was kept, begin again.");
  }
  Kept kept =
      admit(upload.file_, {wanted, bytes, {plain(about.media_type), plain(about.name)}, 0, owner.name},
            owner.quota_bytes);
  if (!kept.is_new) upload.file_.remove();
  return kept;
}

// Of everything that belongs to it, as far as this process knows; belongs to change_mutex_.
std::int64_t& AssetStore::owned_by(const std::string& owner) {
  if (!owned_) {
    owned_.emplace();
    for (const Listed& file : list()) (*owned_)[entry_of(file.hash, file.bytes).owner] += charge(file.bytes);
  }
  return (*owned_)[owner];
}

// Of what was removed, while it is still said of; belongs to change_mutex_.
void AssetStore::forget(const ContentHash& hash, std::int64_t bytes) {
  if (owned_) owned_by(entry_of(hash, bytes).owner) -= charge(bytes);
}

// Takes the file over, unless the asset is there already.
AssetStore::Kept AssetStore::admit(UploadFile& file, AssetEntry entry, std::int64_t quota_bytes) {
  sweep();
  const std::lock_guard changing(change_mutex_);
  // A file of another size is damaged, and is replaced.
  if (touch(entry.hash) == entry.bytes) {
    ++uploads_;
    return {entry_of(entry.hash, entry.bytes), false};
  }
  if (charge(entry.bytes) > config_.budget_bytes) {
    fail(ErrorCode::kTooLarge,
         fmt::format("All assets together may have {} bytes, fewer than this one.", config_.budget_bytes));
  }
  if (quota_bytes > 0 && owned_by(entry.owner) + charge(entry.bytes) > quota_bytes) {
    fail(ErrorCode::kTooLarge,
         fmt::format("This key's assets may have {} bytes together and have {}; delete some first.",
                     quota_bytes, owned_by(entry.owner)));
  }
  if (bytes_ + charge(entry.bytes) > config_.budget_bytes && !trim(charge(entry.bytes)))
    fail(ErrorCode::kOverloaded, "There is no room: all assets are in use just now; try again in a moment.");
  entry.created_ms = to_ms(config_.now());
  publish(file, entry);
  return {entry, true};
}

// First what is said of it: an asset that is there has always been said of.
void AssetStore::publish(UploadFile& file, const AssetEntry& entry) {
  UploadFile about(config_.folder / "uploads");
  about.append(about_text(entry));
  about.publish(about_of(entry.hash));
  file.publish(path_of(entry.hash));
  if (owned_) owned_by(entry.owner) += charge(entry.bytes);
  touch(entry.hash);
  ++uploads_;
  ++assets_;
  bytes_ += charge(entry.bytes);
}

fs::path AssetStore::path_of(const ContentHash& hash) const {
  const std::string hex = hash.hex();
  return config_.folder / hex.substr(0, 2) / hex;
}

fs::path AssetStore::about_of(const ContentHash& hash) const {
  return path_of(hash) += kAboutEnding;
}

bool AssetStore::has_expired(Time used) const {
  return config_.ttl.count() > 0 && config_.now() - used > config_.ttl;
}

// Its size, when it is there. A folder that can only be read keeps its order.
std::optional<std::int64_t> AssetStore::touch(const ContentHash& hash) {
  if (config_.folder.empty()) return std::nullopt;
  const fs::path path = path_of(hash);
  std::error_code wrong;
  const Time used = fs::last_write_time(path, wrong);
  if (wrong || has_expired(used)) return std::nullopt;
  const auto identity = file_identity(path);
  fs::last_write_time(path, config_.now(), wrong);
  return identity ? std::optional(identity->size_bytes) : std::nullopt;
}

AssetEntry AssetStore::entry_of(const ContentHash& hash, std::int64_t bytes) const {
  AssetEntry entry{hash, bytes, {}, 0, {}};
  try {
    read_about(read_file(about_of(hash), 1024), entry);
  } catch (const Error&) {  // it is the lesser part
  }
  return entry;
}

std::optional<AssetEntry> AssetStore::find(const ContentHash& hash) {
  sweep();
  const auto bytes = touch(hash);
  return bytes ? std::optional(entry_of(hash, *bytes)) : std::nullopt;
}

std::shared_ptr<const void> AssetStore::use(const ContentHash& hash) {
  const std::lock_guard lock(mutex_);
  ++uses_[hash];
  return {nullptr, [this, hash](const void*) {
            const std::lock_guard lock(mutex_);
            if (--uses_[hash] == 0) uses_.erase(hash);
          }};
}

bool AssetStore::is_used(const ContentHash& hash) const {
  const std::lock_guard lock(mutex_);
  return uses_.contains(hash);
}

std::optional<Blob> AssetStore::read(const ContentHash& hash) {
  sweep();
  const auto in_use = use(hash);
  if (!touch(hash)) return std::nullopt;
  try {
    return *in_memory_.get_or_load(hash, Deadline{}, [&] {
      Blob blob(read_file(path_of(hash), std::numeric_limits<std::int64_t>::max()));
      if (blob.hash() == hash) return blob;
      set_aside(hash);
      fail(ErrorCode::kNotFound, "The asset was damaged.");
    });
  } catch (const Error& error) {
    if (error.code == ErrorCode::kNotFound) return std::nullopt;
    throw;
  }
}

std::shared_ptr<const FileBody> AssetStore::open(const ContentHash& hash) {
  sweep();
  auto in_use = use(hash);
  const auto bytes = touch(hash);
  if (!bytes) return nullptr;
  Descriptor file(::open(path_of(hash).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!file.is_open()) return nullptr;
  if (!has_hash(file.get(), hash)) {
    set_aside(hash);
    return nullptr;
  }
  return std::shared_ptr<const FileBody>(new FileBody{std::move(file), *bytes, std::move(in_use)});
}

bool AssetStore::erase(const ContentHash& hash) {
  const std::lock_guard changing(change_mutex_);
  const auto bytes = touch(hash);
  if (!bytes) return false;
  std::error_code wrong;
  if (!fs::remove(path_of(hash), wrong) || wrong)
    fail(ErrorCode::kStorage, "The server's disk does not let the asset go.", {}, wrong.message());
  forget(hash, *bytes);
  fs::remove(about_of(hash), wrong);
  --assets_;
  bytes_ -= charge(*bytes);
  return true;
}

void AssetStore::set_aside(const ContentHash& hash) {
  const std::lock_guard changing(change_mutex_);
  owned_.reset();
  const fs::path damaged = config_.folder / "damaged";
  log::warning("assets.damaged", {{"asset", hash.hex()}});
  std::error_code wrong;
  fs::create_directories(damaged, wrong);
  std::vector<fs::path> older;
  for (const fs::directory_entry& entry : fs::directory_iterator(damaged, wrong))
    older.push_back(entry.path());
  if (older.size() >= kDamagedKept) fs::remove(older.front(), wrong);
  fs::rename(path_of(hash), damaged / hash.hex(), wrong);
  if (wrong) fs::remove(path_of(hash), wrong);
  fs::remove(about_of(hash), wrong);
  trim(0);
}

// What vanishes meanwhile is left out.
std::vector<AssetStore::Listed> AssetStore::list() const {
  std::vector<Listed> files;
  std::error_code end;
  for (fs::recursive_directory_iterator it(config_.folder, end), last; !end && it != last;
       it.increment(end)) {
    std::error_code wrong;
    const auto hash = parse_hash(it->path().filename().string());
    if (!hash || it->path() != path_of(*hash) || !it->is_regular_file(wrong)) continue;
    const Time used = it->last_write_time(wrong);
    const auto bytes = wrong ? 0 : it->file_size(wrong);
    if (!wrong) files.push_back({*hash, std::int64_t(bytes), used});
  }
  return files;
}

void AssetStore::remove_widowed_abouts() {
  std::vector<fs::path> widowed;
  std::error_code end;
  for (fs::recursive_directory_iterator it(config_.folder, end), last; !end && it != last;
       it.increment(end)) {
    std::error_code wrong;
    fs::path asset = it->path();
    if (asset.extension() != kAboutEnding) continue;
    if (!fs::exists(asset.replace_extension(), wrong) && !wrong) widowed.push_back(it->path());
  }
  for (const fs::path& about : widowed) fs::remove(about, end);
}

// Counts anew, since other processes may share the folder, and removes what has expired, then what was not used for longest,
// until there is room for `room_bytes` more. False when there is not.
bool AssetStore::trim(std::int64_t room_bytes) {
  std::vector<Listed> files = list();
  std::ranges::sort(files, {}, [](const Listed& file) { return std::tuple(file.used, file.hash); });
  std::int64_t sum = 0, count = std::int64_t(files.size());
  for (const Listed& file : files) sum += charge(file.bytes);
  for (const Listed& file : files) {
    const bool is_over = sum > config_.budget_bytes - room_bytes;
    if (!has_expired(file.used) && !is_over) break;
    std::error_code wrong;
    if (is_used(file.hash) || !fs::remove(path_of(file.hash), wrong)) continue;
    forget(file.hash, file.bytes);
    fs::remove(about_of(file.hash), wrong);
    sum -= charge(file.bytes);
    --count;
  }
  assets_ = count;
  bytes_ = sum;
  return sum <= config_.budget_bytes - room_bytes;
}

// Now and then, by whoever comes while nobody else changes anything.
void AssetStore::sweep() {
  const std::unique_lock changing(change_mutex_, std::try_to_lock);
  if (!changing || config_.now() - swept_ < kSweepPeriod) return;
  swept_ = config_.now();
  partial_.remove_stale();
  if (config_.ttl.count() > 0) trim(0);
}

std::string asset_id(const ContentHash& hash) {
  return std::string(kIdScheme) + hash.hex();
}

ContentHash parse_asset_id(std::string_view id) {
  const auto hash = id.starts_with(kIdScheme) ? parse_hash(id.substr(kIdScheme.size())) : std::nullopt;
  if (!hash) {
    fail(ErrorCode::kUnprocessable,
         "an asset is named asset:sha256- and the 64 lower-case hexadecimal digits of its SHA-256");
  }
  return *hash;
}

}  // namespace furnace
