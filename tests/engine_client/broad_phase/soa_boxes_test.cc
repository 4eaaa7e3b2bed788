#include "engine_client/broad_phase/common/soa_boxes.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/scene/box_scenes.h"

namespace sweepstake {
namespace {

Aabb At(const BoxLanes& lanes, size_t slot) {
  return {{lanes.min[0][slot], lanes.min[1][slot], lanes.min[2][slot]},
          {lanes.max[0][slot], lanes.max[1][slot], lanes.max[2][slot]}};
}

const Aabb kSentinel = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

TEST(SoaBoxes, KeepValidBoxesAndReplaceInvalidOnes) {
  SoaBoxes soa;
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    for (const uint32_t count : {0, 1, 15, 16, 17, 63, 64, 65, 200}) {
      const auto scene = MakeDegenerateScene(name, count, 8);
      const auto boxes = scene->aabbs();
      soa.Gather(boxes);
      const BoxLanes lanes = soa.Lanes();
      ASSERT_EQ(lanes.count, boxes.size());
      for (size_t i = 0; i < boxes.size(); ++i) {
        const Aabb& box = boxes[i];
        EXPECT_EQ(At(lanes, i), IsValid(box) ? box : kSentinel) << name << " " << i;
        EXPECT_EQ(lanes.id[i], i);
      }
    }
  }
}

TEST(SoaBoxes, ArePaddedWithOneRegisterOfSentinels) {
  SoaBoxes soa;
  for (const size_t count : {200, 0, 64, 63}) {
    const BoxScene scene("brownian", count, 8);
    soa.Gather(scene.boxes());
    for (size_t i = count; i < count + SoaBoxes::kPadding; ++i)
      EXPECT_EQ(At(soa.Lanes(), i), kSentinel);
  }
}

TEST(SoaBoxes, GatherInTheGivenOrder) {
  const BoxScene scene("brownian", 5, 8);
  const std::vector<uint32_t> order = {4, 0, 3};
  SoaBoxes soa;
  soa.Gather(scene.boxes(), order);
  ASSERT_EQ(soa.count(), 3U);
  for (size_t slot = 0; slot < 3; ++slot) {
    EXPECT_EQ(soa.Lanes().id[slot], order[slot]);
    EXPECT_EQ(At(soa.Lanes(), slot), scene.boxes()[order[slot]]);
  }
}

TEST(SoaBoxes, RotateTheAxesToTheRequestedOne) {
  const Aabb box = {{1, 2, 3}, {4, 5, 6}};
  SoaBoxes soa;
  soa.Gather({&box, 1});
  EXPECT_EQ(At(soa.Lanes(1), 0), (Aabb{{2, 3, 1}, {5, 6, 4}}));
  EXPECT_EQ(At(soa.Lanes(2), 0), (Aabb{{3, 1, 2}, {6, 4, 5}}));
}

}  // namespace
}  // namespace sweepstake
