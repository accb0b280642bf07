// Models through both decoders: equal values, and files that are damaged end in an error, never in more.
#include <chrono>
#include <cstring>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/decode/process_decoder.hpp"
#include "tests/support/model_files.hpp"

namespace furnace::decode {
namespace {

using namespace test;

struct ModelFile {
  ModelFormat format;
  std::string document, materials;
};

std::vector<ModelFile> model_files() {
  return {{ModelFormat::kObj, obj_corner(), mtl_corner()},
          {ModelFormat::kStl, binary_stl("COLOR=abcd", {1, 0x8000, 77}), ""},
          {ModelFormat::kStl, text_stl(), ""},
          {ModelFormat::kPly, ply_square(PlyForm::kText), ""},
          {ModelFormat::kPly, ply_square(PlyForm::kLittle), ""},
          {ModelFormat::kPly, ply_square(PlyForm::kBig), ""},
          {ModelFormat::kPly, ply_cloud(), ""}};
}

PoolConfig pool_config() {
  PoolConfig config;
  config.command.program = {FURNACE_HOSTILE_WORKER};
  config.processes = 1;
  return config;
}

ProcessDecoder& process_decoder() {
  static ProcessDecoder decoder(pool_config());
  return decoder;
}

// Some damage keeps the library busy for ever.
ProcessDecoder& impatient_decoder() {
  static ProcessDecoder decoder([] {
    PoolConfig config = pool_config();
    config.timeout = std::chrono::milliseconds(200);
    return config;
  }());
  return decoder;
}

PlainModelLimits small_limits() {
  PlainModelLimits limits;
  limits.max_bytes = 16 << 20;
  limits.max_materials = 100;
  return limits;
}

PlainModel decode(Decoder& decoder, const ModelFile& file) {
  return decoder.model(Blob(file.document), file.materials, file.format, small_limits(), Deadline());
}

template <class Value>
bool same(const std::vector<Value>& a, const std::vector<Value>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

TEST(ModelDecoders, AgreeOnEveryFormat) {
  for (const ModelFile& file : model_files()) {
    const PlainModel a = decode(in_process_decoder(), file), b = decode(process_decoder(), file);
    EXPECT_FALSE(a.parts.empty());
    EXPECT_TRUE(is_sound(a, small_limits()));
    EXPECT_TRUE(same(a.text, b.text) && same(a.materials, b.materials) && same(a.parts, b.parts));
    EXPECT_TRUE(same(a.positions, b.positions) && same(a.normals, b.normals) && same(a.uvs, b.uvs));
    EXPECT_TRUE(same(a.colors, b.colors) && same(a.indices, b.indices));
  }
}

TEST(ModelDecoders, AgreeOnErrors) {
  for (const ModelFormat format : {ModelFormat::kObj, ModelFormat::kStl, ModelFormat::kPly}) {
    for (const char* text : {"", "garbage", "ply\nformat ascii 1.0\nelement vertex 9999999999\nend_header\n",
                             "solid\nendsolid"}) {
      const auto error_of = [&](Decoder& decoder) {
        try {
          decode(decoder, {format, text, ""});
        } catch (const Error& error) {
          return error.message;
        }
        return std::string("none");
      };
      EXPECT_EQ(error_of(in_process_decoder()), error_of(process_decoder()));
      EXPECT_NE(error_of(in_process_decoder()), "none") << int(format) << " " << text;
    }
  }
}

// 1: a model came out, which `accepts` has judged already.
int survive(const ModelFile& file) {
  try {
    decode(impatient_decoder(), file);
    return 1;
  } catch (const Error& error) {
    EXPECT_TRUE(error.code == ErrorCode::kUnprocessable || error.code == ErrorCode::kTooLarge)
        << error.message;
    return 0;
  }
}

// On these the library crashes, and this decoder has no process of its own.
TEST(ModelDecoders, StatementsBeforeTheFirstMaterialAreOfNone) {
  const auto decode = [](const std::string& materials) {
    const std::string document = obj_corner();
    return in_process_decoder().model(std::as_bytes(std::span(document)), materials, ModelFormat::kObj,
                                      small_limits(), Deadline());
  };
  const PlainModel model = decode("Kd 1 0 0\nmap_Kd newmtl.png\n \t" + mtl_corner());
  ASSERT_EQ(model.materials.size(), decode(mtl_corner()).materials.size());
  for (const char* materials :
       {"Kd 1 0 0", "nwmtl full\nKd 0.5 0.25 1\nNs 9", "illum 2\nd 0.5\n", "newmt", "map_Kd newmtl"})
    EXPECT_FALSE(decode(materials).materials.empty()) << materials;
}

TEST(ModelDecoders, TruncationsEndWell) {
  for (const ModelFile& file : model_files()) {
    const std::size_t step = std::max<std::size_t>(1, file.document.size() / 4);
    for (std::size_t size = 0; size < file.document.size(); size += step)
      survive({file.format, file.document.substr(0, size), file.materials});
    survive({file.format, file.document, file.materials.substr(0, file.materials.size() / 2)});
  }
}

TEST(ModelDecoders, FlippedBitsEndWell) {
  std::mt19937 random(7);
  int models = 0, rounds = 0;
  for (const ModelFile& file : model_files()) {
    for (int round = 0; round < 10; ++round, ++rounds) {
      ModelFile damaged = file;
      std::string& bytes = file.materials.empty() || round % 2 == 0 ? damaged.document : damaged.materials;
      for (int i = 0; i < 1 + round % 3; ++i) bytes[random() % bytes.size()] ^= char(1u << (random() % 8));
      models += survive(damaged);
    }
  }
  EXPECT_GT(models, 0);
  EXPECT_LT(models, rounds);
}

}  // namespace
}  // namespace furnace::decode
