// A file that is written piece by piece under a temporary name, and gets its name when it is whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "renderer/base/descriptor.hpp"

namespace furnace {

// While it is written its writer holds a lock on it, so that what a dead process left can be told from what a living one
// writes, in any container that shares the folder.
// Threads: one. Owns: the file, until it is published; what is not published is removed.
class UploadFile {
 public:
  UploadFile() = default;  // none
  // In `folder`, which is made when missing. Errors: kStorage.
  explicit UploadFile(const std::filesystem::path& folder);
  // The file of that name, which stays when it is not published, for whoever goes on; made, in its folder, when missing.
  // Not open when another writes it just now. Errors: kStorage.
  static UploadFile resume(const std::filesystem::path& path);
  ~UploadFile();
  UploadFile(UploadFile&& other) noexcept;
  UploadFile& operator=(UploadFile&& other) noexcept;

  bool is_open() const { return file_.is_open(); }
  int descriptor() const { return file_.get(); }
  std::int64_t size() const;            // Errors: kStorage
  void append(std::string_view bytes);  // Errors: kStorage
  // After a crash there is the whole file under this name, or what was there before. Makes its folder. Errors: kStorage.
  void publish(const std::filesystem::path& path);
  void remove();  // also of a file that would stay

  // Removes from `folder` what no living process writes.
  static void remove_abandoned(const std::filesystem::path& folder);

 private:
  std::filesystem::path path_;
  Descriptor file_;
  bool stays_ = false;
};

}  // namespace furnace
