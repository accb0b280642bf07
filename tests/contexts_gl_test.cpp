// Several contexts, and contexts made anew, draw what one draws.
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "renderer/base/error.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/renderer.hpp"

namespace furnace {
namespace {

RenderSpec picture_of(const std::string& mesh) {
  RenderSpec spec;
  NodeSpec node;
  node.mesh = mesh;
  spec.scene.nodes = {node};
  spec.output.width = 48;
  spec.output.height = 32;
  return spec;
}

const std::vector<std::string> kMeshes = {"sphere", "cube", "torus", "cylinder"};

std::vector<std::vector<std::byte>> pictures(Renderer& renderer) {
  std::vector<std::vector<std::byte>> out;
  for (const std::string& mesh : kMeshes) {
    const Film film = renderer.render(picture_of(mesh), Deadline{});
    out.emplace_back(film.image.pixels.begin(), film.image.pixels.end());
  }
  return out;
}

struct Contexts : testing::Test {
  WorkerPool pool{2};
};

TEST_F(Contexts, DrawAlikeAtOnce) {
  Renderer one({}, pool, decode::in_process_decoder());
  const auto expected = pictures(one);

  RendererConfig config;
  config.contexts = 3;
  Renderer three(config, pool, decode::in_process_decoder());
  EXPECT_EQ(three.fingerprint().text(), one.fingerprint().text());
  EXPECT_TRUE(three.probe(Deadline{}));
  std::atomic<int> wrong = 0;
  std::vector<std::thread> callers;
  for (int i = 0; i < 6; ++i) callers.emplace_back([&] { wrong += pictures(three) != expected; });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, 0);
  const ContextPoolStats stats = three.stats().contexts;
  EXPECT_EQ(stats.callers, std::vector<int>(3, 0)) << "every place was given back";
  EXPECT_TRUE(three.stats().probes_are_alike);
  std::int64_t gpu_bytes = 0;
  for (const std::int64_t bytes : stats.gpu_bytes) gpu_bytes += bytes;
  EXPECT_GT(gpu_bytes, 10'000) << "four meshes and an environment at least";
}

TEST_F(Contexts, OutliveEachOther) {
  RendererConfig config;
  auto first = std::make_unique<Renderer>(config, pool, decode::in_process_decoder());
  const auto expected = pictures(*first);
  Renderer second(config, pool, decode::in_process_decoder());
  first.reset();
  EXPECT_EQ(pictures(second), expected) << "the display of both was terminated by one";
}

TEST_F(Contexts, AreMadeAnewAfterSoManyPictures) {
  RendererConfig config;
  Renderer untouched(config, pool, decode::in_process_decoder());
  const auto expected = pictures(untouched);
  config.context_life.renders = 3;
  Renderer renewed(config, pool, decode::in_process_decoder());
  EXPECT_EQ(pictures(renewed), expected);
  EXPECT_EQ(pictures(renewed), expected);
  EXPECT_EQ(pictures(renewed), expected);
  const auto renewals = renewed.stats().contexts.renewals;
  EXPECT_EQ(renewals[std::size_t(RenewalReason::kRenders)], 3)
      << "before the 4th, the 7th and the 10th of 12";
}

TEST_F(Contexts, OfADeviceThatIsNotThereFailAtOnce) {
  RendererConfig config;
  config.gl.device = "auto,0000:ff:1f.7";
  try {
    const Renderer renderer(config, pool, decode::in_process_decoder());
    FAIL() << "there is no such device";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kGpuUnavailable);
    EXPECT_NE(error.message.find("0000:ff:1f.7"), std::string::npos) << error.message;
  }
}

}  // namespace
}  // namespace furnace
