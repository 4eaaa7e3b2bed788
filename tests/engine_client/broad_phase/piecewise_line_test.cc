// Tests the functions that spread boxes evenly along an axis: straight lines between sampled
// values, and the boxes that they stretch.
#include "engine_client/broad_phase/common/piecewise_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "engine_client/broad_phase/grid/axis_stretch.h"
#include "engine_client/scene/box_scenes.h"

namespace sweepstake {
namespace {

using Line = PiecewiseLine<8>;

float At(const Line& line, float x) {
  float sum = 0;
  for (size_t k = 0; k < line.count; ++k) {
    sum += std::min(std::max((x - line.begin[k]) * line.scale[k], 0.0F), line.rise[k]);
  }
  return sum;
}

TEST(PiecewiseLine, IsOneSegmentIfTheValuesAreEven) {
  std::vector<float> values;
  for (int k = 0; k <= 100; ++k) values.push_back(static_cast<float>(k) / 10);
  const Line line = Line::Fit(values, 1);
  EXPECT_EQ(line.count, 1U);
  EXPECT_NEAR(At(line, 5), 50, 0.1);
}

TEST(PiecewiseLine, RisesWhereTheValuesAre) {
  std::vector<float> values;
  for (int k = 0; k < 50; ++k) values.push_back(static_cast<float>(k));
  for (int k = 0; k < 50; ++k) values.push_back(static_cast<float>(10'000 + k));
  const Line line = Line::Fit(values, 1);
  EXPECT_LE(line.count, 4U);
  EXPECT_NEAR(At(line, 25), 25, 1);
  EXPECT_NEAR(At(line, 5000), 49.5, 1);
  EXPECT_NEAR(At(line, 10'025), 75, 1);
  EXPECT_EQ(At(line, -1e30F), 0);
  EXPECT_EQ(At(line, 1e30F), 99);
}

TEST(PiecewiseLine, JumpsWhereValuesAreEqual) {
  const std::vector<float> values = {1, 1, 1, 1, 1, 1, 1, 1, 9};
  const Line line = Line::Fit(values, 0.5F);
  EXPECT_EQ(At(line, 1), 0);
  EXPECT_NEAR(At(line, 1.001F), 7, 0.1);
  EXPECT_EQ(At(line, 9), 8);
}

TEST(PiecewiseLine, NeverFalls) {
  constexpr float kMax = 1e38F;
  std::vector<float> values = {-kMax, -1, -1, 0, 1e-38F, 1e-30F, 1, 1, 1.0000001F, 3, 1e10F, kMax};
  const Line line = Line::Fit(values, 0.1F);
  std::vector<float> at = values;
  for (const float value : values) {
    at.push_back(std::nextafter(value, kMax));
    at.push_back(std::nextafter(value, -kMax));
    at.push_back(value / 3);
  }
  std::sort(at.begin(), at.end());
  for (size_t k = 1; k < at.size(); ++k) {
    EXPECT_LE(At(line, at[k - 1]), At(line, at[k])) << at[k - 1] << " and " << at[k];
  }
  EXPECT_FALSE(std::isnan(At(line, std::numeric_limits<float>::infinity())));
}

TEST(AxisStretch, KeepsAllOverlaps) {
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    const auto scene = MakeDegenerateScene(name, 300, 3);
    const auto boxes = scene->aabbs();
    AxisStretch stretch;
    stretch.Fit(boxes);
    stretch.SetWeights({1, 0.25F, 1.0F / 1024});
    std::vector<Aabb> stretched(boxes.size());
    stretch.Apply(boxes, stretched.data());
    for (size_t a = 0; a < boxes.size(); ++a) {
      ASSERT_EQ(IsValid(stretched[a]), IsValid(boxes[a])) << name;
      for (size_t b = 0; b < a; ++b) {
        ASSERT_GE(Overlap(stretched[a], stretched[b]), Overlap(boxes[a], boxes[b])) << name;
      }
    }
  }
}

TEST(AxisStretch, SpreadsTheBoxesEvenly) {
  const BoxScene scene("exponential-spacing", 5000, 3);
  AxisStretch stretch;
  stretch.Fit(scene.boxes());
  std::vector<Aabb> stretched(5000);
  stretch.Apply(scene.boxes(), stretched.data());
  for (size_t i = 0; i < stretched.size(); ++i) {
    const float rank = static_cast<float>(i) / 5000 * AxisStretch::kSample;
    EXPECT_NEAR(stretched[i].min[0], rank, AxisStretch::kSample / 25.0);
  }
}

}  // namespace
}  // namespace sweepstake
