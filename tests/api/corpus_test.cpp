// Requests as files: accept_*.json are read, reject_*.json give exactly the problem document beside them.
#include <gtest/gtest.h>

#include "api/problem.hpp"
#include "tests/api/request_fixture.hpp"

namespace furnace::api {
namespace {

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder, std::string_view prefix) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(prefix) && name.ends_with(".json") && !name.ends_with(".problem.json"))
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

const std::filesystem::path kRequests = "tests/api/requests";

TEST(Requests, AcceptedFilesAreRead) {
  const auto files = files_in(kRequests, "accept_");
  ASSERT_GE(files.size(), 8u);
  for (const auto& file : files) {
    SCOPED_TRACE(file);
    try {
      parse(read_text(file));
    } catch (const Error& error) {
      ADD_FAILURE() << error.message;
    }
  }
}

TEST(Requests, RejectedFilesGiveTheirProblem) {
  const auto files = files_in(kRequests, "reject_");
  ASSERT_GE(files.size(), 12u);
  for (const auto& file : files) {
    SCOPED_TRACE(file);
    std::filesystem::path expected = file;
    EXPECT_EQ(problem_json(refusal(read_text(file)), "test") + "\n",
              read_text(expected.replace_extension(".problem.json")));
  }
}

// Seriot, "Parsing JSON is a minefield", 2016: y_ must be accepted, n_ refused, i_ may be either.
TEST(Requests, JsonTestSuite) {
  const std::filesystem::path folder = "../shared/data/malformed/json";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no JSONTestSuite at " << folder;
  const auto accepted = files_in(folder, "y_"), refused = files_in(folder, "n_"),
             either = files_in(folder, "i_");
  ASSERT_GE(accepted.size(), 60u);
  ASSERT_GE(refused.size(), 100u);
  for (const auto& file : accepted) {
    const std::string text = read_text(file), name = file.filename().string();
    const auto is = [&](const char* what) { return name.find(what) != std::string::npos; };
    // The suite calls duplicate keys and U+0000 valid; RFC 8259 (sections 4 and 9) leaves them to the reader, and here they are
    // mistakes.
    if (is("duplicated_key") || is("null_escape") || is("escaped_null"))
      EXPECT_THROW(Document::parse(text, {}), Error) << file;
    else
      EXPECT_NO_THROW(Document::parse(text, {})) << file;
  }
  for (const auto& file : refused) EXPECT_THROW(Document::parse(read_text(file), {}), Error) << file;
  for (const auto& file : either) {
    try {
      Document::parse(read_text(file), {});
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kInvalidRequest) << file;
    }
  }
}

}  // namespace
}  // namespace furnace::api
