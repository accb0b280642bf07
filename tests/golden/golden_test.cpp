// Cases are data: see FORMAT.md.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "api/render_request.hpp"
#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"
#include "server/render_service.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(FURNACE_SOURCE_DIR) / "tests" / "golden";
constexpr std::size_t kMaxBytes = 16u << 20;

// One way to run the same request; all must give the same bytes.
struct Configuration {
  const char* name;
  int max_tile_px;
  std::int64_t cache_bytes;
};
constexpr Configuration kWhole{"whole", 1024, 256ll << 20};
constexpr Configuration kTiled{"tiled", 64, 256ll << 20};
constexpr Configuration kUncached{"uncached", 1024, 0};

class Door {
 public:
  explicit Door(const Configuration& configuration)
      : renderer_(config_of(configuration), pool_, decode::in_process_decoder()),
        service_(painter_of(renderer_), admission_, pool_, none_) {}

  std::string render(const std::string& request) {
    const AssetResolver assets(files_, {}, {});
    return service_.render(api::parse_render_request(request, assets, {}), Deadline()).image->bytes;
  }

 private:
  static RendererConfig config_of(const Configuration& configuration) {
    gl::apply_determinism(gl::Determinism::kExact);
    RendererConfig config;
    config.gl = {"software", gl::Determinism::kExact};
    config.max_tile_px = configuration.max_tile_px;
    config.scene_cache_bytes = config.bake_cache_bytes = config.gpu_cache_bytes = configuration.cache_bytes;
    return config;
  }

  WorkerPool pool_{2};
  Admission admission_{1, 0};
  FileAssets files_{{}, 0, 0};
  Renderer renderer_;
  RenderCache none_{{0, {}, 0}};  // each is drawn
  RenderService service_;
};

Door& door(const Configuration& configuration) {
  static std::map<std::string, std::unique_ptr<Door>> doors;
  auto& entry = doors[configuration.name];
  if (!entry) entry = std::make_unique<Door>(configuration);
  return *entry;
}

// EXR cases are 2:1, so the environments' reader serves; what it would repair is a fault here.
Image read_exr(const std::string& file) {
  DecodedEnvironment decoded = decode_environment(Blob(file), {});
  const RepairReport& repairs = decoded.repairs;
  EXPECT_EQ(repairs.nan_samples + repairs.infinite_samples + repairs.negative_samples, 0);
  return std::move(decoded.equirect);
}

// Samples as numbers: 0..255 for PNG, radiance for EXR.
std::vector<double> samples_of(const std::string& file, bool exr, Extent& extent, int& channels) {
  std::vector<double> values;
  const Image image = exr ? read_exr(file) : decode_texture(Blob(file), ColorSpace::kSrgb, {}).levels[0];
  extent = image.extent;
  channels = image.channels;
  if (image.type == SampleType::kUint8) {
    for (const std::uint8_t v : image.samples<std::uint8_t>()) values.push_back(v);
  } else {
    for (const float v : image.samples<float>()) values.push_back(double(v));
  }
  return values;
}

struct Comparison {
  double largest = 0;
  double fraction = 0;  // of the pixels over the tolerance
  bool comparable = false;
};

Comparison compare(const std::string& actual, const std::string& expected, bool exr, double max_difference) {
  Extent size_a, size_b;
  int channels_a = 0, channels_b = 0;
  const auto a = samples_of(actual, exr, size_a, channels_a),
             b = samples_of(expected, exr, size_b, channels_b);
  Comparison result;
  if (size_a != size_b || channels_a != channels_b) return result;
  result.comparable = true;
  std::size_t over = 0;
  for (std::size_t pixel = 0; pixel < a.size(); pixel += std::size_t(channels_a)) {
    bool pixel_over = false;
    for (std::size_t i = pixel; i < pixel + std::size_t(channels_a); ++i) {
      const double difference = exr ? std::abs(a[i] - b[i]) / (1 + std::abs(b[i])) : std::abs(a[i] - b[i]);
      result.largest = std::max(result.largest, difference);
      // A NaN compares false with everything: it must count as over.
      pixel_over = pixel_over || !(difference <= max_difference);
    }
    over += pixel_over ? 1 : 0;
  }
  result.fraction = double(over) / double(a.size() / std::size_t(channels_a));
  return result;
}

void expect_finite(const std::string& file, bool exr) {
  Extent extent;
  int channels = 0;
  for (const double value : samples_of(file, exr, extent, channels)) ASSERT_TRUE(std::isfinite(value));
}

std::vector<std::string> case_names() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(kFolder / "cases"))
    names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

class Golden : public testing::TestWithParam<std::string> {};

void check_case(const std::string& name) {
  const fs::path case_path = kFolder / "cases" / (name + ".json");
  const nlohmann::json document = nlohmann::json::parse(read_file(case_path.string(), kMaxBytes));
  const std::string request = document.at("request").dump();
  const bool exr =
      document["request"].contains("output") && document["request"]["output"].value("format", "png") == "exr";
  const fs::path expected_path = kFolder / "expected" / (name + (exr ? ".exr" : ".png"));

  const std::string actual = door(kWhole).render(request);
  expect_finite(actual, exr);
  EXPECT_TRUE(door(kWhole).render(request) == actual) << "warm caches draw another picture than cold ones";
  EXPECT_TRUE(door(kUncached).render(request) == actual) << "without caches another picture is drawn";
  // Interpolants are evaluated from the tile's corner: their last bits differ, which moves a channel by a step where a
  // reflection is steep.
  const Comparison tiled = compare(door(kTiled).render(request), actual, exr, exr ? 1e-4 : 1);
  EXPECT_LE(tiled.fraction, 2e-3) << "tiles show: largest difference " << tiled.largest;

  if (std::getenv("FURNACE_UPDATE_GOLDENS") != nullptr) {
    write_file_atomically(expected_path.string(), actual);
    return;
  }
  const double max_difference = document["tolerance"]["maxDifference"],
               max_fraction = document["tolerance"]["maxFraction"];
  const Comparison result =
      compare(actual, read_file(expected_path.string(), kMaxBytes), exr, max_difference);
  EXPECT_TRUE(result.comparable) << "another size or number of channels";
  EXPECT_LE(result.fraction, max_fraction) << "largest difference " << result.largest;
  if (testing::Test::HasFailure()) {
    const fs::path left = fs::path(testing::TempDir()) / (name + (exr ? ".actual.exr" : ".actual.png"));
    write_file_atomically(left.string(), actual);
    ADD_FAILURE() << fmt::format(
        "{}\nactual: {}\nreplay: jq .request {} | build/furnace render --determinism exact - -o out{}",
        document.value("description", ""), left.string(), case_path.string(), exr ? ".exr" : ".png");
  }
}

TEST_P(Golden, LooksAsExpectedInEveryConfiguration) {
  try {
    check_case(GetParam());
  } catch (const Error& error) {
    ADD_FAILURE() << error.message << " " << error.pointer << " " << error.detail;
    for (const Problem& problem : error.problems) ADD_FAILURE() << problem.pointer << ": " << problem.message;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, Golden, testing::ValuesIn(case_names()),
                         [](const testing::TestParamInfo<std::string>& info) { return info.param; });

}  // namespace
}  // namespace furnace
