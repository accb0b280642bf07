// fuzz_seeds FOLDER: writes the seeds to FOLDER/TARGET/, and FOLDER/TARGET.dict for targets that read words.
// The working directory is the source root.
#include "tests/fuzz/seeds.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renderer/base/check.hpp"
#include "renderer/base/content_hash.hpp"

namespace furnace::fuzz {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

void write(const fs::path& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), std::streamsize(bytes.size()));
  FURNACE_CHECK(file.good(), "{}", path.string());
}

void collect_words(const Json& value, std::set<std::string>& words) {
  if (value.is_string()) words.insert(value.get<std::string>());
  if (!value.is_structured()) return;
  for (const auto& [key, member] : value.items()) {
    if (value.is_object()) words.insert(key);
    collect_words(member, words);
  }
}

// Keys and short texts of all seeds that begin with a JSON document.
std::string dictionary_of(const std::vector<std::string>& seeds) {
  constexpr std::size_t kMostWordBytes = 48;
  std::set<std::string> words;
  for (const std::string& seed : seeds) {
    const Json document = Json::parse(seed.substr(0, seed.find('\0')), nullptr, false);
    if (!document.is_discarded()) collect_words(document, words);
  }
  std::string text;
  for (const std::string& word : words) {
    if (word.empty() || word.size() > kMostWordBytes) continue;
    std::string escaped;
    for (const char c : word) escaped += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    text += fmt::format("\"{}\"\n", escaped);
  }
  return text;
}

void write_all(const fs::path& folder) {
  Seeds seeds;
  add_image_seeds(seeds);
  add_gltf_seeds(seeds);
  add_mesh_seeds(seeds);
  add_request_seeds(seeds);
  for (const auto& [target, inputs] : seeds) {
    fs::remove_all(folder / target);
    fs::create_directories(folder / target);
    for (std::size_t i = 0; i < inputs.size(); ++i)
      write(folder / target / fmt::format("{:04}", i), inputs[i]);
    const std::string words = dictionary_of(inputs);
    if (!words.empty()) write(folder / (target + ".dict"), words);
  }
}

}  // namespace

std::string file_text(std::string_view path) {
  std::ifstream file(fs::path(path), std::ios::binary);
  FURNACE_CHECK(file.good(), "{}", path);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace furnace::fuzz

int main(int argc, char** argv) {
  if (argc != 2) return EXIT_FAILURE;
  furnace::fuzz::write_all(argv[1]);
}
