// tests/scene/corpus: accept_NAME.gltf with the codes of its notes in NAME.expect ("none" for none),
// reject_NAME.gltf with the error's code and pointer. The files are read by hand as well: each shows one
// thing.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

const std::filesystem::path kCorpus = "tests/scene/corpus";

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string outcome_of(const std::string& document) {
  ModelBundle bundle;
  bundle.document = Blob(document);
  bundle.seal();
  try {
    const Scene scene = import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline());
    std::string codes;
    for (const Note& note : scene.notes) codes += (codes.empty() ? "" : " ") + note.code;
    return codes.empty() ? "none" : codes;
  } catch (const Error& error) {
    return std::string(error_code_name(error.code)) + " " + (error.pointer.empty() ? "\"\"" : error.pointer);
  }
}

TEST(Corpus, EveryFileEndsAsExpected) {
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(kCorpus)) {
    if (entry.path().extension() == ".gltf") files.insert(entry.path());
  }
  EXPECT_GT(files.size(), 40u);
  for (const auto& file : files) {
    std::string expected = text_of(std::filesystem::path(file).replace_extension(".expect"));
    expected.erase(std::find(expected.begin(), expected.end(), '\n'), expected.end());
    EXPECT_EQ(outcome_of(text_of(file)), expected) << file;
    const bool refused = expected.find('/') != std::string::npos || expected.find('"') != std::string::npos;
    EXPECT_EQ(file.filename().string().starts_with("reject_"), refused) << file;
  }
}

}  // namespace
}  // namespace furnace::testing
