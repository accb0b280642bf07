#include "renderer/assets/zip_reader.hpp"

#include <algorithm>
#include <memory>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <libdeflate.h>

#include "renderer/scene/model_format.hpp"
#include "renderer/base/error.hpp"

namespace furnace {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint32_t kEndMark = 0x06054b50, kEntryMark = 0x02014b50, kLocalMark = 0x04034b50;
constexpr std::size_t kEndBytes = 22, kEntryBytes = 46, kLocalBytes = 30;
constexpr std::size_t kMaxComment = 0xffff, kMaxName = 1024;
constexpr std::uint32_t kIs64 = 0xffffffff;
constexpr std::uint32_t kStored = 0, kDeflated = 8;
// Encrypted, patches, strongly encrypted, masked.
constexpr std::uint32_t kRefusedFlags = 1u << 0 | 1u << 5 | 1u << 6 | 1u << 13;
constexpr std::size_t kMostListed = 10;

[[noreturn]] void refuse(std::string_view what) {
  fail(ErrorCode::kUnprocessable, fmt::format("the ZIP archive cannot be used: {}", what));
}

std::uint32_t number(Bytes bytes, std::size_t at, int size) {
  std::uint32_t value = 0;
  for (int i = 0; i < size; ++i)
    value |= std::to_integer<std::uint32_t>(bytes[at + std::size_t(i)]) << (8 * i);
  return value;
}
std::uint32_t u16(Bytes bytes, std::size_t at) {
  return number(bytes, at, 2);
}
std::uint32_t u32(Bytes bytes, std::size_t at) {
  return number(bytes, at, 4);
}

std::string_view text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The last record that ends where the file ends.
std::size_t find_end(Bytes file) {
  if (file.size() < kEndBytes) refuse("it is cut off");
  const std::size_t last = file.size() - kEndBytes;
  for (std::size_t comment = 0; comment <= std::min(last, kMaxComment); ++comment) {
    const std::size_t at = last - comment;
    if (u32(file, at) == kEndMark && u16(file, at + 20) == comment) return at;
  }
  refuse("its directory is missing");
}

bool is_safe(std::string_view name) {
  if (name.empty() || name.size() > kMaxName || name.front() == '/') return false;
  if (name.size() > 1 && name[1] == ':') return false;  // a drive
  if (std::ranges::any_of(name, [](unsigned char c) { return c < ' ' || c == '\\' || c == 0x7f; }))
    return false;
  if (name.ends_with('/')) name.remove_suffix(1);
  for (;;) {
    const std::string_view segment = name.substr(0, name.find('/'));
    if (segment.empty() || segment == "." || segment == "..") return false;
    if (segment.size() == name.size()) return true;
    name.remove_prefix(segment.size() + 1);
  }
}

// Of the systems that write Unix modes into the attributes: neither link nor device.
bool is_plain(std::uint32_t made_by, std::uint32_t attributes) {
  constexpr std::uint32_t kUnix = 3, kDarwin = 19, kTypeMask = 0170000, kFile = 0100000, kFolder = 0040000;
  const std::uint32_t system = made_by >> 8, type = attributes >> 16 & kTypeMask;
  return (system != kUnix && system != kDarwin) || type == 0 || type == kFile || type == kFolder;
}

bool is_hidden(std::string_view name) {
  return name.starts_with('.') || name.find("/.") != name.npos || name.starts_with("__MACOSX/");
}

}  // namespace

bool is_zip(Bytes file) {
  if (file.size() < kEndBytes) return false;
  const std::uint32_t mark = u32(file, 0);
  return mark == kLocalMark || mark == kEndMark;
}

ZipReader::ZipReader(Blob archive, const ZipLimits& limits) : archive_(std::move(archive)) {
  const Bytes file = archive_.bytes();
  const std::size_t end = find_end(file);
  const std::size_t count = u16(file, end + 10), size = u32(file, end + 12), begin = u32(file, end + 16);
  if (u16(file, end + 4) != 0 || u16(file, end + 6) != 0 || u16(file, end + 8) != count)
    refuse("it is split into several files");
  if (count > std::size_t(limits.max_entries))
    fail(ErrorCode::kTooLarge, fmt::format("a ZIP archive may have {} entries", limits.max_entries));
  if (begin > end || size > end - begin) refuse("its directory lies outside of it, or it is in ZIP64");
  std::size_t at = begin;
  for (std::size_t i = 0; i < count; ++i) at = add_entry(at, begin + size);

  std::int64_t packed_sum = 0, sum = 0;
  for (const auto& [name, entry] : files_) {
    packed_sum += std::int64_t(entry.packed_bytes);
    sum += std::int64_t(entry.bytes);
  }
  if (packed_sum > std::int64_t(file.size())) refuse("its files overlap");
  const std::int64_t by_ratio = std::max(limits.free_bytes, limits.max_ratio * std::int64_t(file.size()));
  if (sum > std::min(limits.max_total_bytes, by_ratio)) {
    fail(ErrorCode::kTooLarge,
         fmt::format("the files of this ZIP archive may have {} bytes together; they have {}",
                     std::min(limits.max_total_bytes, by_ratio), sum));
  }
}

// Returns where the next one begins.
std::size_t ZipReader::add_entry(std::size_t at, std::size_t end) {
  const Bytes file = archive_.bytes();
  if (end - at < kEntryBytes || u32(file, at) != kEntryMark) refuse("its directory is broken");
  const std::size_t name_bytes = u16(file, at + 28);
  const std::size_t all = kEntryBytes + name_bytes + u16(file, at + 30) + u16(file, at + 32);
  if (end - at < all) refuse("its directory is broken");
  std::string name(text(file.subspan(at + kEntryBytes, name_bytes)));
  if (!is_safe(name)) refuse(fmt::format("\"{}\" is no relative path", readable_text(name)));
  const auto complain = [&](std::string_view what) {
    refuse(fmt::format("\"{}\" {}", readable_text(name), what));
  };
  Entry entry{u16(file, at + 10), u32(file, at + 16), u32(file, at + 20), u32(file, at + 24),
              u32(file, at + 42)};
  if ((u16(file, at + 8) & kRefusedFlags) != 0) complain("is encrypted or a patch");
  if (!is_plain(u16(file, at + 4), u32(file, at + 38))) complain("is a link or a device");
  if (entry.packed_bytes == kIs64 || entry.bytes == kIs64 || entry.offset == kIs64) complain("is in ZIP64");
  if (name.ends_with('/')) return at + all;
  if (entry.method != kStored && entry.method != kDeflated) complain("is packed in another way than deflate");
  if (!files_.emplace(name, entry).second) complain("is there twice");
  return at + all;
}

std::vector<std::string> ZipReader::names() const {
  std::vector<std::string> names;
  for (const auto& [name, entry] : files_) names.push_back(name);
  return names;
}

Bytes ZipReader::packed(const std::string& name, const Entry& entry) const {
  const Bytes file = archive_.bytes();
  const auto has = [&](std::size_t offset, std::size_t size) {
    return offset <= file.size() && size <= file.size() - offset;
  };
  if (has(entry.offset, kLocalBytes) && u32(file, entry.offset) == kLocalMark) {
    const std::size_t name_at = entry.offset + kLocalBytes, name_bytes = u16(file, entry.offset + 26);
    const std::size_t data_at = name_at + name_bytes + u16(file, entry.offset + 28);
    if (has(name_at, name_bytes) && text(file.subspan(name_at, name_bytes)) == name &&
        has(data_at, entry.packed_bytes))
      return file.subspan(data_at, entry.packed_bytes);
  }
  refuse(fmt::format("\"{}\" is not where the directory says", readable_text(name)));
}

std::optional<Blob> ZipReader::read(const std::string& name) const {
  const auto found = files_.find(name);
  if (found == files_.end()) return std::nullopt;
  const Entry& entry = found->second;
  const Bytes packed_bytes = packed(name, entry);
  Blob content;
  bool is_whole = false;
  if (entry.method == kStored) {
    content = Blob::slice(archive_, std::size_t(packed_bytes.data() - archive_.bytes().data()),
                          packed_bytes.size());
    is_whole = entry.bytes == entry.packed_bytes;
  } else {
    // As many bytes as the directory says, which was held against the limits; what inflates to more fails.
    std::string inflated(entry.bytes, '\0');
    const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflater(
        libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
    if (!inflater) fail(ErrorCode::kInternal, "out of memory");
    std::size_t size = 0;
    is_whole = libdeflate_deflate_decompress(inflater.get(), packed_bytes.data(), packed_bytes.size(),
                                             inflated.data(), inflated.size(), &size) == LIBDEFLATE_SUCCESS &&
               size == inflated.size();
    content = Blob(std::move(inflated));
  }
  if (!is_whole || libdeflate_crc32(0, content.bytes().data(), content.size()) != entry.crc)
    refuse(fmt::format("\"{}\" is damaged", readable_text(name)));
  return content;
}

std::string model_in(const ZipReader& archive) {
  std::vector<std::string> models;
  std::ptrdiff_t depth = 0;
  for (const std::string& name : archive.names()) {
    if (!is_model_name(name) || is_hidden(name)) continue;
    const std::ptrdiff_t its_depth = std::ranges::count(name, '/');
    if (models.empty() || its_depth < depth) {
      models.clear();
      depth = its_depth;
    }
    if (its_depth == depth) models.push_back(name);
  }
  if (models.empty()) refuse("there is no model in it");
  if (models.size() == 1) return models.front();
  const std::size_t count = models.size();
  models.resize(std::min(count, kMostListed));
  for (std::string& model : models) model = readable_text(model);
  refuse(fmt::format("there are {} models in it, name one behind the archive's reference and a slash: {}",
                     count, fmt::join(models, ", ")));
}

}  // namespace furnace
