// What a test of permissions needs where it is root's.
#pragma once

#include <sys/fsuid.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <filesystem>

#include <gtest/gtest.h>

namespace furnace::test {

// While it lives, this thread is nobody to the file system, and owns the folder; without effect if not root.
class Unprivileged {
 public:
  explicit Unprivileged(const std::filesystem::path& folder) {
    if (geteuid() != 0) return;
    EXPECT_EQ(chown(folder.c_str(), kNobody, gid_t(-1)), 0);
    setfsuid(kNobody);
  }
  Unprivileged(const Unprivileged&) = delete;
  Unprivileged& operator=(const Unprivileged&) = delete;
  ~Unprivileged() {
    setfsuid(geteuid());
    prctl(PR_SET_DUMPABLE, 1);  // lost with the change; LeakSanitizer needs it
  }

 private:
  static constexpr uid_t kNobody = 65534;
};

}  // namespace furnace::test
