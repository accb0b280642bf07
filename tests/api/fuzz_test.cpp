// Seeded noise: whatever comes in, a spec or an Error comes out, and the judge and the explanation agree.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "api/problem.hpp"
#include "tests/api/request_fixture.hpp"

namespace furnace::api {
namespace {

std::size_t below(std::mt19937_64& random, std::size_t bound) {
  return random() % bound;
}

// A spec or an Error whose problem document is JSON; anything else fails the test or the process.
bool survives(const std::string& text) {
  try {
    parse(text);
    return true;
  } catch (const Error& error) {
    EXPECT_NE(error.code, ErrorCode::kInternal) << error.message;
    EXPECT_NO_THROW(Document::parse(problem_json(error, "fuzz"), {}));
    return false;
  }
}

std::vector<std::string> seeds() {
  std::vector<std::string> seeds;
  for (const FieldRow& row : field_rows()) seeds.push_back(with_value(row, row.one));
  for (const auto& entry : std::filesystem::directory_iterator("tests/api/requests"))
    if (!entry.path().string().ends_with(".problem.json")) seeds.push_back(read_text(entry.path()));
  std::sort(seeds.begin(), seeds.end());
  return seeds;
}

TEST(Fuzz, BitFlipsInsertionsAndDeletions) {
  std::mt19937_64 random(1);
  const std::vector<std::string> originals = seeds();
  int accepted = 0, refused = 0;
  for (int round = 0; round < 6000; ++round) {
    std::string text = originals[below(random, originals.size())];
    for (std::size_t edits = 1 + below(random, 3); edits > 0 && !text.empty(); --edits) {
      const std::size_t at = below(random, text.size());
      switch (below(random, 4)) {
        case 0:
          text[at] = static_cast<char>(text[at] ^ (1 << below(random, 8)));
          break;
        case 1:
          text.erase(at, 1 + below(random, 4));
          break;
        case 2:
          text.insert(at, 1, static_cast<char>(below(random, 256)));
          break;
        default:
          text.resize(at);
          break;
      }
    }
    ++(survives(text) ? accepted : refused);
  }
  EXPECT_GT(accepted, 10) << "edits inside strings and numbers leave some requests valid";
  EXPECT_GT(refused, 3000);
}

TEST(Fuzz, Garbage) {
  std::mt19937_64 random(2);
  constexpr std::string_view kLikely = "{}[]\",:0123456789.eE+-truefalsn\\u \n";
  for (int round = 0; round < 4000; ++round) {
    std::string text(below(random, 80), ' ');
    for (char& c : text)
      c = round % 2 == 0 ? kLikely[below(random, kLikely.size())] : static_cast<char>(below(random, 256));
    survives(text);
  }
}

// Replaces one value or key of a request by another JSON token.
std::string with_another_token(std::string text, std::mt19937_64& random) {
  constexpr std::array<std::string_view, 26> kTokens = {"0",
                                                        "1",
                                                        "-1",
                                                        "0.5",
                                                        "1e300",
                                                        "18446744073709551615",
                                                        "1.0",
                                                        "true",
                                                        "null",
                                                        "\"\"",
                                                        "\"gold\"",
                                                        "\"png\"",
                                                        "\"builtin:cube\"",
                                                        "\"builtin:x\"",
                                                        "[]",
                                                        "{}",
                                                        "[0,0,0]",
                                                        "[1,2,3,4]",
                                                        "[1,\"a\",3]",
                                                        "\"type\"",
                                                        "\"color\"",
                                                        "\"lookAt\"",
                                                        "\"gltf\"",
                                                        "\"samples\"",
                                                        "{\"color\":[1,1,1]}",
                                                        "[{}]"};
  std::vector<std::pair<std::size_t, std::size_t>> places;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::size_t end = i;
    if (text[i] == '"') {
      end = text.find('"', i + 1);
      if (end == text.npos) break;
      ++end;
    } else {
      while (end < text.size() &&
             std::string_view("0123456789.+-eEtruefalsn").find(text[end]) != std::string_view::npos)
        ++end;
    }
    if (end == i) continue;
    places.emplace_back(i, end - i);
    i = end - 1;
  }
  if (places.empty()) return text;
  const auto [at, size] = places[below(random, places.size())];
  return text.replace(at, size, kTokens[below(random, kTokens.size())]);
}

TEST(Fuzz, JudgeAndExplanationAgree) {
  std::mt19937_64 random(3);
  const std::vector<std::string> originals = seeds();
  int valid = 0, wrong = 0;
  for (int round = 0; round < 8000; ++round) {
    std::string text = originals[below(random, originals.size())];
    for (std::size_t edits = 1 + below(random, 2); edits > 0; --edits)
      text = with_another_token(text, random);
    std::optional<Document> document;
    try {
      document = Document::parse(text, {});
    } catch (const Error&) {
      continue;
    }
    const auto explained = explain(request_schema().document().root(), document->root());
    const bool judged_valid = request_schema().problems(*document).empty();
    EXPECT_EQ(explained.empty(), judged_valid) << text;
    ++(judged_valid ? valid : wrong);
    survives(text);
  }
  EXPECT_GT(valid, 200);
  EXPECT_GT(wrong, 2000);
}

}  // namespace
}  // namespace furnace::api
