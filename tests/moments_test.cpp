#include "renderer/moments.hpp"

#include <gmock/gmock.h>

#include "renderer/scene/shutter.hpp"

namespace furnace {
namespace {

using ::testing::SizeIs;

SharedMesh mesh_of(double time_s) {
  Mesh mesh;
  mesh.positions.assign(1000, glm::vec3(float(time_s), 0, 0));
  mesh.normals.assign(1000, glm::vec3(0, 0, 1));
  mesh.indices.assign(3000, 0);
  mesh.key = HashBuilder().add("test").add(time_s).finish();
  return std::make_shared<const Mesh>(std::move(mesh));
}

// One mesh that stands still, one that is another at every time.
class Deforming {
 public:
  ImportAt import_at() {
    return [this](const std::vector<AnimationClip>& clips) {
      ++imports;
      Scene scene;
      scene.materials.push_back(default_material());
      scene.animations.push_back({"move", 10});
      scene.meshes = {mesh_of(-1), mesh_of(clips.at(0).time.seconds)};
      for (int i = 0; i < 2; ++i) scene.instances.push_back({i, 0, glm::mat4(1), "node"});
      return std::make_shared<const Scene>(std::move(scene));
    };
  }
  int imports = 0;
};

class Moments : public ::testing::Test {
 protected:
  Moments() {
    spec_.animations = {{0, {5, false}}};
    middle_ = compose_scene(spec_, model_.import_at()(spec_.animations).get());
    model_.imports = 0;
  }
  ComposedMoments compose(std::int64_t most_bytes) {
    return compose_moments(spec_, middle_, {16, 16, 2}, most_bytes, model_.import_at());
  }

  SceneSpec spec_;
  Deforming model_;
  ComposedScene middle_;
  const std::int64_t one_mesh_bytes_ = std::int64_t(mesh_of(0)->byte_size());
};

TEST_F(Moments, ShareWhatStandsStill) {
  const ComposedMoments moments = compose(kMostMomentBytes);
  ASSERT_THAT(moments.scenes, SizeIs(16));
  EXPECT_EQ(model_.imports, 16);
  EXPECT_EQ(moments.offsets_s, moment_offsets_s(16, 16, 2));
  for (const auto& composed : moments.scenes) {
    EXPECT_EQ(composed->scene.meshes[0], middle_.scene.meshes[0]);
    EXPECT_NE(composed->scene.meshes[1], middle_.scene.meshes[1]);
  }
  EXPECT_NEAR(moments.scenes[3]->scene.meshes[1]->positions[0].x, 5 + moments.offsets_s[3], 1e-6);
  // Seventeen meshes, not thirty-two.
  EXPECT_LT(std::int64_t(moments.byte_size()), 18 * one_mesh_bytes_ + 16 * 4096);
}

TEST_F(Moments, AreAsManyAsMayTakeMemory) {
  constexpr std::int64_t kLists = 2 * 512 + 4096;
  const ComposedMoments moments = compose(5 * (one_mesh_bytes_ + kLists) + 100);
  EXPECT_THAT(moments.scenes, SizeIs(5));
  EXPECT_EQ(moments.offsets_s, moment_offsets_s(16, 5, 2));
  EXPECT_EQ(model_.imports, 6 + 5);
  EXPECT_THAT(compose(1).scenes, SizeIs(1));
}

}  // namespace
}  // namespace furnace
