#include "renderer/base/file.hpp"

#include "renderer/base/error.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <thread>
#include <vector>

namespace furnace {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class FileTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "furnace_file_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  template <class Body>
  Error error_of(Body&& body) {
    try {
      body();
    } catch (const Error& error) {
      return error;
    }
    ADD_FAILURE() << "nothing was thrown";
    return {};
  }

  fs::path folder_;
};

TEST_F(FileTest, ReadsBackWhatItWrote) {
  const std::string bytes("a\0b\n\xff", 5);
  write_file_atomically(folder_ / "x", bytes);
  EXPECT_EQ(read_file(folder_ / "x", 100), bytes);
  write_file_atomically(folder_ / "x", "");
  EXPECT_EQ(read_file(folder_ / "x", 100), "");
}

TEST_F(FileTest, LeavesNothingBesideTheFile) {
  write_file_atomically(folder_ / "x", "1");
  write_file_atomically(folder_ / "x", "2");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(FileTest, HonoursTheLimitToTheByte) {
  write_file_atomically(folder_ / "x", "12345");
  EXPECT_EQ(read_file(folder_ / "x", 5), "12345");
  EXPECT_EQ(error_of([&] { read_file(folder_ / "x", 4); }).code, ErrorCode::kTooLarge);
}

// /proc files have a size of 0 and content all the same.
TEST_F(FileTest, ReadsFilesLongerThanTheyClaim) {
  EXPECT_THAT(read_file("/proc/self/status", 1 << 20), HasSubstr("Name:"));
  EXPECT_EQ(error_of([&] { read_file("/proc/self/status", 10); }).code, ErrorCode::kTooLarge);
}

TEST_F(FileTest, SaysWhatIsMissingWithoutItsFolder) {
  const Error error = error_of([&] { read_file(folder_ / "absent.hdr", 100); });
  EXPECT_EQ(error.code, ErrorCode::kNotFound);
  EXPECT_THAT(error.message, HasSubstr("absent.hdr"));
  EXPECT_THAT(error.message, Not(HasSubstr(folder_.string())));
  EXPECT_THAT(error.detail, HasSubstr(folder_.string()));
}

TEST_F(FileTest, RefusesWhatIsNotAFileWithoutWaiting) {
  EXPECT_EQ(error_of([&] { read_file(folder_, 100); }).code, ErrorCode::kNotFound);
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(error_of([&] { read_file(folder_ / "pipe", 100); }).code, ErrorCode::kNotFound);
  EXPECT_FALSE(file_identity(folder_ / "pipe"));
  EXPECT_FALSE(file_identity(folder_ / "absent"));
}

TEST_F(FileTest, SaysThatItCannotWrite) {
  const Error error = error_of([&] { write_file_atomically(folder_ / "no" / "x", "1"); });
  EXPECT_EQ(error.code, ErrorCode::kStorage);
  fs::create_directory(folder_ / "taken");
  fs::create_directory(folder_ / "taken" / "full");
  EXPECT_EQ(error_of([&] { write_file_atomically(folder_ / "taken", "1"); }).code, ErrorCode::kStorage);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "the temporary file is left behind";
}

TEST_F(FileTest, WritesThroughWhatIsNoRegularFile) {
  const fs::path pipe = folder_ / "pipe", link = folder_ / "link";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] {
    std::ifstream file(pipe);
    got.assign(std::istreambuf_iterator<char>(file), {});
  });
  write_file_atomically(pipe, "through");
  reader.join();
  EXPECT_EQ(got, "through");
  EXPECT_TRUE(fs::is_fifo(pipe));

  write_file_atomically(folder_ / "x", "longer than that");
  fs::create_symlink("x", link);
  write_file_atomically(link, "short");
  EXPECT_EQ(read_file(folder_ / "x", 100), "short");
  EXPECT_TRUE(fs::is_symlink(link));

  fs::create_symlink("/dev/null", folder_ / "null");
  write_file_atomically(folder_ / "null", "gone");
  EXPECT_TRUE(fs::is_symlink(folder_ / "null"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  fs::create_symlink("absent", folder_ / "dangling");
  EXPECT_EQ(error_of([&] { write_file_atomically(folder_ / "dangling", "1"); }).code, ErrorCode::kStorage);
  EXPECT_FALSE(fs::exists(folder_ / "absent"));
}

TEST_F(FileTest, IdentityChangesWithTheFile) {
  write_file_atomically(folder_ / "x", "1");
  const auto first = file_identity(folder_ / "x");
  ASSERT_TRUE(first);
  EXPECT_EQ(first->size_bytes, 1);
  EXPECT_EQ(file_identity(folder_ / "x"), first);
  fs::create_symlink("x", folder_ / "link");
  EXPECT_EQ(file_identity(folder_ / "link"), first);
  write_file_atomically(folder_ / "x", "2");
  EXPECT_NE(file_identity(folder_ / "x"), first);
}

// What a killed process left, or another container's process of the same id.
TEST_F(FileTest, PassesOverTemporaryNamesThatAreTaken) {
  for (int serial = 1; serial <= 200; ++serial) {
    std::ofstream(folder_ / fmt::format(".x.{}.{}.tmp", ::getpid(), serial));
  }
  write_file_atomically(folder_ / "x", "1");
  EXPECT_EQ(read_file(folder_ / "x", 10), "1");
}

// A reader sees one whole version or another, never a mixture.
TEST_F(FileTest, IsReplacedAtOnce) {
  write_file_atomically(folder_ / "x", std::string(10'000, 'a'));
  std::jthread writer([&] {
    for (char c : {'b', 'c', 'd', 'e'}) write_file_atomically(folder_ / "x", std::string(10'000, c));
  });
  for (int i = 0; i < 100; ++i) {
    const std::string bytes = read_file(folder_ / "x", 20'000);
    ASSERT_EQ(bytes, std::string(10'000, bytes.at(0)));
  }
}

}  // namespace
}  // namespace furnace
