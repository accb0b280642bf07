// Eviction: by age, within the budget, never what the frame uses.
#include <gtest/gtest.h>

#include "renderer/residency/residency.hpp"
#include "tests/support/gl_fixture.hpp"

namespace furnace {
namespace {

PreparedTexture texture(const char* name, int side) {
  PreparedTexture texture;
  texture.key = HashBuilder().add(name).finish();
  texture.levels = std::make_shared<const std::vector<Image>>(
      1, make_image({side, side}, 4, SampleType::kUint8, ColorSpace::kNonColor));
  return texture;
}

class ResidencyGlTest : public test::GlTest {
 protected:
  std::shared_ptr<ResidentKeys> keys_ = std::make_shared<ResidentKeys>();
};

TEST_F(ResidencyGlTest, UploadsOnceAndRemembers) {
  Residency residency(context_, 1 << 20, keys_);
  residency.begin_frame();
  const PreparedTexture a = texture("a", 16);
  const GpuTexture* first = residency.texture(a);
  EXPECT_TRUE(residency.uploaded());
  EXPECT_TRUE(keys_->contains(a.key));
  residency.begin_frame();
  EXPECT_EQ(residency.texture(a), first);
  EXPECT_FALSE(residency.uploaded());
}

TEST_F(ResidencyGlTest, ATextureThatIsNeitherResidentNorDecodedIsNull) {
  Residency residency(context_, 1 << 20, keys_);
  residency.begin_frame();
  PreparedTexture missing = texture("missing", 4);
  missing.levels = nullptr;
  EXPECT_EQ(residency.texture(missing), nullptr);
}

TEST_F(ResidencyGlTest, EvictsTheOldestDownToTheBudgetBetweenFrames) {
  constexpr int kSide = 64;  // 21.8 kB with its chain
  Residency residency(context_, 50'000, keys_);
  const PreparedTexture a = texture("a", kSide), b = texture("b", kSide), c = texture("c", kSide);
  for (const PreparedTexture* used : {&a, &b, &c}) {
    residency.begin_frame();
    residency.texture(*used);
  }
  residency.begin_frame();
  EXPECT_FALSE(keys_->contains(a.key));
  EXPECT_TRUE(keys_->contains(b.key));
  EXPECT_TRUE(keys_->contains(c.key));
}

TEST_F(ResidencyGlTest, AFrameKeepsAllItUsesEvenOverTheBudget) {
  Residency residency(context_, 1, keys_);
  residency.begin_frame();
  const PreparedTexture a = texture("a", 64), b = texture("b", 64);
  const GpuTexture* first = residency.texture(a);
  residency.texture(b);
  EXPECT_EQ(residency.texture(a), first);
  residency.begin_frame();
  EXPECT_FALSE(keys_->contains(a.key));
  EXPECT_FALSE(keys_->contains(b.key));
}

TEST_F(ResidencyGlTest, DestructionForgetsTheKeys) {
  const PreparedTexture a = texture("a", 4);
  {
    Residency residency(context_, 1 << 20, keys_);
    residency.begin_frame();
    residency.texture(a);
    EXPECT_TRUE(keys_->contains(a.key));
  }
  EXPECT_FALSE(keys_->contains(a.key));
}

}  // namespace
}  // namespace furnace
