#include "server/zip_archive.hpp"

#include <memory>

#include <zip.h>

#include "renderer/base/error.hpp"

namespace furnace {

namespace {

constexpr zip_uint16_t kDosEpoch = (0 << 9) | (1 << 5) | 1;  // 1980-01-01: the same bytes at any time

[[noreturn]] void refuse(std::string detail) {
  fail(ErrorCode::kInternal, "the pictures could not be written as ZIP", {}, std::move(detail));
}

}  // namespace

std::string zip_archive(const std::vector<ArchiveFile>& files) {
  zip_error_t fault;
  zip_error_init(&fault);
  constexpr int kKeep = 0;
  zip_source_t* target = zip_source_buffer_create(nullptr, 0, kKeep, &fault);
  if (target == nullptr) refuse(zip_error_strerror(&fault));
  zip_source_keep(target);  // beyond the archive, to be read
  const std::unique_ptr<zip_source_t, decltype(&zip_source_free)> owner(target, zip_source_free);
  std::unique_ptr<zip_t, decltype(&zip_discard)> archive(zip_open_from_source(target, ZIP_TRUNCATE, &fault),
                                                         zip_discard);
  if (!archive) {
    zip_source_free(target);  // the archive would have
    refuse(zip_error_strerror(&fault));
  }
  for (const ArchiveFile& file : files) {
    zip_source_t* content = zip_source_buffer(archive.get(), file.bytes.data(), file.bytes.size(), kKeep);
    const zip_int64_t index = zip_file_add(archive.get(), file.name.c_str(), content, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      zip_source_free(content);
      refuse(zip_strerror(archive.get()));
    }
    if (zip_set_file_compression(archive.get(), zip_uint64_t(index), ZIP_CM_STORE, 0) != 0 ||
        zip_file_set_dostime(archive.get(), zip_uint64_t(index), 0, kDosEpoch, 0) != 0)
      refuse(zip_strerror(archive.get()));
  }
  if (zip_close(archive.get()) != 0) refuse(zip_strerror(archive.get()));
  (void)archive.release();  // closed

  zip_stat_t size;
  zip_stat_init(&size);
  if (zip_source_open(target) != 0 || zip_source_stat(target, &size) != 0)
    refuse(zip_error_strerror(zip_source_error(target)));
  std::string bytes(std::size_t(size.size), '\0');
  const bool whole = zip_source_read(target, bytes.data(), bytes.size()) == zip_int64_t(bytes.size());
  zip_source_close(target);
  if (!whole) refuse("what was written could not be read");
  return bytes;
}

}  // namespace furnace
