// Batches as lists of requests.
#include "api/batch_request.hpp"

#include <random>

#include <gmock/gmock.h>

#include "renderer/base/error.hpp"
#include "api/document.hpp"

namespace furnace::api {
namespace {

using ::testing::SizeIs;

std::vector<BatchItem> parsed(std::string_view json, int most = 100) {
  return parse_batch(json, RequestLimits{}, most).items;
}

std::string refusal(std::string_view json, int most = 100) {
  try {
    parsed(json, most);
  } catch (const Error& error) {
    EXPECT_NE(error.code, ErrorCode::kInternal);
    return error.problems.empty() ? error.message : error.problems.front().pointer;
  }
  return "accepted";
}

TEST(Batch, ItemsInEveryCombinationOfValues) {
  const auto items = parsed(R"({
    "request": {"output": {"width": 10, "height": 20}},
    "items": [{"name": "front", "changes": {"/camera/orbit/azimuthDegrees": 0}}, {"name": "side"}],
    "vary": [{"pointer": "/output/width", "values": [1, 2]}, {"pointer": "/strict", "values": [true, false]}]})");
  ASSERT_THAT(items, SizeIs(8));
  EXPECT_EQ(items[0].name, "front_001_001");
  EXPECT_EQ(items[1].name, "front_001_002");
  EXPECT_EQ(items[7].name, "side_002_002");
  EXPECT_EQ(items[1].document,
            R"({"camera":{"orbit":{"azimuthDegrees":0}},"output":{"height":20,"width":1},"strict":false})");
  EXPECT_EQ(items[1].changes, R"({"/camera/orbit/azimuthDegrees":0,"/output/width":1,"/strict":false})");
  EXPECT_EQ(items[7].document, R"({"output":{"height":20,"width":2},"strict":false})");
}

TEST(Batch, NamesAndTheRequestMayBeLeftOut) {
  EXPECT_EQ(parsed(R"({"items":[{},{}]})")[1].name, "item_0002");
  const auto widths = parsed(R"({"vary":[{"pointer":"/output/width","values":[320,640]}]})");
  ASSERT_THAT(widths, SizeIs(2));
  EXPECT_EQ(widths[1].name, "002");
  EXPECT_EQ(widths[1].document, R"({"output":{"width":640}})");
}

TEST(Batch, FaultsHaveTheirPlaces) {
  EXPECT_EQ(refusal("{}"), "");
  EXPECT_EQ(refusal("[]"), "");
  EXPECT_EQ(refusal(R"({"items":[]})"), "/items");
  EXPECT_EQ(refusal(R"({"itms":[{}],"items":[{}]})"), "/itms");
  EXPECT_EQ(refusal(R"({"request":3,"items":[{}]})"), "/request");
  EXPECT_EQ(refusal(R"({"items":[{"name":"../a"}]})"), "/items/0/name");
  EXPECT_EQ(refusal(R"({"items":[{"name":".hidden"}]})"), "/items/0/name");
  EXPECT_EQ(refusal(R"({"items":[{"name":"a"},{"name":"a"}]})"), "/items/1");
  EXPECT_EQ(refusal(R"({"items":[{"changes":{"output":1}}]})"), "/items/0/changes/output");
  EXPECT_EQ(refusal(R"({"items":[{"changes":{"":1}}]})"), "/items/0/changes/");
  EXPECT_EQ(refusal(R"({"vary":[{"pointer":"/a~","values":[1]}]})"), "/vary/0/pointer");
  EXPECT_EQ(refusal(R"({"vary":[{"pointer":"/a","values":[]}]})"), "/vary/0/values");
  EXPECT_EQ(refusal(R"({"vary":[{"pointer":"/a"}]})"), "/vary/0/values");
}

TEST(Batch, ArraysAreNotGrownByIndex) {
  EXPECT_NE(
      refusal(R"({"request":{"scene":{"nodes":[]}},"items":[{"changes":{"/scene/nodes/9x/mesh":"a"}}]})"),
      "accepted");
  EXPECT_NE(refusal(R"({"request":{"strict":true},"items":[{"changes":{"/strict/deeper":1}}]})"), "accepted");
  // These would take all memory before anything is refused.
  for (const char* pointer : {"/scene/nodes/2", "/scene/nodes/3000000000/mesh",
                              "/scene/nodes/99999999999999999999", "/scene/lights/4000000000", "/a/1/2/3"}) {
    EXPECT_NE(refusal(R"({"request":{"scene":{"nodes":[{}]}},"items":[{"changes":{")" + std::string(pointer) +
                      R"(":{}}}]})"),
              "accepted")
        << pointer;
  }
  for (const char* pointer : {"/scene/nodes/0", "/scene/nodes/1", "/scene/nodes/-", "/scene/lights/0/type"})
    EXPECT_EQ(refusal(R"({"request":{"scene":{"nodes":[{}]}},"items":[{"changes":{")" + std::string(pointer) +
                      R"(":{}}}]})"),
              "accepted")
        << pointer;
}

TEST(Batch, PointersGoNoDeeperThanDocuments) {
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "/a";
  EXPECT_EQ(refusal(R"({"vary":[{"pointer":")" + deep + R"(","values":[1]}]})"), "/vary/0/pointer");
}

TEST(Batch, CountsAreBounded) {
  EXPECT_EQ(refusal(R"({"items":[{},{}]})", 2), "accepted");
  EXPECT_NE(refusal(R"({"items":[{},{},{}]})", 2), "accepted");
  std::string many = R"({"vary":[)";
  for (int i = 0; i < 30; ++i)
    many += (i ? "," : "") + std::string(R"({"pointer":"/output/width","values":[1,2,3,4,5,6,7,8,9,10]})");
  EXPECT_NE(refusal(many + "]}", 1'000'000), "accepted") << "ten to the thirtieth";
}

TEST(Batch, DamageEndsInAnError) {
  const std::string whole =
      R"({"request":{"output":{"width":10}},"items":[{"name":"a","changes":{"/strict":true}}],"vary":[{"pointer":"/output/width","values":[1,2]}]})";
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(refusal(whole.substr(0, size)), "accepted");
  std::mt19937 random(1);
  for (int round = 0; round < 3000; ++round) {
    std::string text = whole;
    for (int edits = 1 + int(random() % 3); edits > 0; --edits)
      text[random() % text.size()] = char(32 + random() % 95);
    refusal(text);
  }
}

TEST(Batch, TheIndexTellsOfEachItem) {
  const std::string text =
      batch_index_json({{{"a", "", R"({"/output/width":1})", "", 0}, "a.png", "", {{"code", "/p", "what"}}},
                        {{"b", "", "{}", "", 0}, "", R"({"status":422})", {}}},
                       0);
  const Document document = Document::parse(text, {});
  const Value items = document.root()["items"];
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items.at(0)["file"].text(), "a.png");
  EXPECT_EQ(items.at(0)["changes"]["/output/width"].integer(), 1);
  EXPECT_EQ(items.at(0)["notes"].at(0)["code"].text(), "code");
  EXPECT_FALSE(items.at(1)["file"]);
  EXPECT_EQ(items.at(1)["problem"]["status"].integer(), 422);
  EXPECT_FALSE(document.root()["contactSheet"]);
  EXPECT_FALSE(document.root()["srcsets"]);
}

TEST(Batch, WidthsOfASrcsetKeepTheAspectRatio) {
  const auto items = parsed(R"({
    "request": {"output": {"width": 1200, "height": 800}}, "items": [{"name": "chair"}, {"name": "tall", "changes": {"/output/height": 2400}}],
    "srcset": {"widths": [300, 600], "formats": ["webp", "png"]}})");
  ASSERT_THAT(items, SizeIs(8));
  EXPECT_EQ(items[0].name, "chair_300w");
  EXPECT_EQ(items[0].srcset, "chair");
  EXPECT_EQ(items[1].name, "chair_300w") << "the ending tells it apart";
  EXPECT_EQ(items[2].document, R"({"output":{"format":"webp","height":400,"width":600}})");
  EXPECT_EQ(items[7].document, R"({"output":{"format":"png","height":1200,"width":600}})");
  EXPECT_EQ(parsed(R"({"srcset":{"widths":[10]}})")[0].document, R"({"output":{"height":10,"width":10}})");
  EXPECT_EQ(parsed(R"({"request":{"output":{"width":1,"height":1e300}},"srcset":{"widths":[10]}})")[0].name,
            "10w");

  const std::string text = batch_index_json({{items[0], "chair_300w.webp", "", {}},
                                             {items[1], "chair_300w.png", "", {}},
                                             {items[2], "chair_600w.webp", "", {}},
                                             {items[3], "", "{}", {}}},
                                            3);
  const Document index = Document::parse(text, {});
  const Value sets = index.root()["srcsets"];
  ASSERT_EQ(sets.size(), 2u);
  EXPECT_EQ(sets.at(0)["srcset"].text(), "chair_300w.webp 300w, chair_600w.webp 600w");
  EXPECT_EQ(sets.at(1)["srcset"].text(), "chair_300w.png 300w");
  EXPECT_EQ(index.root()["items"].at(3)["cell"]["row"].integer(), 1);
  EXPECT_EQ(index.root()["contactSheet"].text(), "contact-sheet.png");
}

TEST(Batch, ATurntableIsASequenceOfEveryItem) {
  const auto items =
      parsed(R"({"items":[{"name":"a"},{"name":"b"}],"turntable":{"frames":8,"container":"archive"}})");
  ASSERT_THAT(items, SizeIs(2));
  EXPECT_EQ(items[1].name, "b");
  EXPECT_EQ(items[1].document,
            R"({"output":{"sequence":{"container":"archive","frames":8,"turntableDegrees":360}}})");
  EXPECT_EQ(parsed(R"({"turntable":{}})")[0].name, "turntable");
}

TEST(Batch, KindsTellTheirFaults) {
  EXPECT_EQ(refusal(R"({"contactSheet":{}})"), "") << "a sheet of what?";
  EXPECT_EQ(refusal(R"({"turntable":3})"), "/turntable");
  EXPECT_EQ(refusal(R"({"srcset":{}})"), "/srcset/widths");
  EXPECT_EQ(refusal(R"({"srcset":{"widths":[]}})"), "/srcset/widths");
  EXPECT_EQ(refusal(R"({"srcset":{"widths":[1.5]}})"), "/srcset/widths/0");
  EXPECT_EQ(refusal(R"({"srcset":{"widths":[0]}})"), "/srcset/widths/0");
  EXPECT_EQ(refusal(R"({"srcset":{"widths":[10,10]}})"), "/srcset/widths/1");
  EXPECT_EQ(refusal(R"({"srcset":{"widths":[10],"formats":["png","png"]}})"), "/srcset/formats/1");
  EXPECT_EQ(refusal(R"({"srcset":{"widths":[10],"density":2}})"), "/srcset/density");
  EXPECT_EQ(refusal(R"({"items":[{}],"contactSheet":{"columns":0}})"), "/contactSheet/columns");
  EXPECT_EQ(refusal(R"({"items":[{}],"contactSheet":{"cellPx":4000}})"), "/contactSheet/cellPx");
  EXPECT_EQ(parse_batch(R"({"items":[{}],"contactSheet":{"columns":3}})", RequestLimits{}, 9).sheet->columns,
            3);
}

}  // namespace
}  // namespace furnace::api
