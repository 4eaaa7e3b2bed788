#include "engine_client/decider/policy/regime_bucket.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace sweepstake::decision {
namespace {

RegimeFeatures Features(float object_count, float speed_mean, float static_ratio) {
  SceneDescriptor descriptor;
  descriptor.object_count = object_count;
  descriptor.speed_mean = speed_mean;
  descriptor.static_ratio = static_ratio;
  return FeaturesOf(descriptor);
}

TEST(RegimeBucket, NamesTheCellOfADescriptor) {
  EXPECT_EQ(BucketOf(Features(10'000, 0.02F, 0)), "13/-4/0");
  EXPECT_EQ(BucketOf(Features(10'000, 0, 1)), "13/-14/3");
  EXPECT_EQ(BucketOf(Features(0, -1, -1)), "0/-/-");
  EXPECT_EQ(BucketOf(Features(-1, -1, 0.5F)), "-/-/1");
  EXPECT_EQ(BucketOf(Features(-1, -1, -1)), "");
  EXPECT_EQ(BucketOf(Features(3e38F, 3e38F, 3e38F)), "100/88/3");
}

TEST(RegimeBucket, IsReadBackAsTheMiddleOfItsCell) {
  for (const RegimeFeatures& features :
       {Features(10'000, 0.02F, 0), Features(1, -1, 1), Features(-1, -1, -1)}) {
    const std::string bucket = BucketOf(features);
    ASSERT_TRUE(MiddleOf(bucket)) << bucket;
    EXPECT_LE(DistanceOf(*MiddleOf(bucket), features), 0.5) << bucket;
    EXPECT_EQ(BucketOf(*MiddleOf(bucket)), bucket);
  }
}

TEST(RegimeBucket, HasOneSpelling) {
  for (const char* wrong :
       {"13", "13/-4", "13/-4/0/", "13/-4/0/1", "13/-4/x", "13/-4/00", "/-4/0", "13//0", "+13/-4/0",
        "13/-4/ 0", "13/-0/0", "-/-/-", "13/-4/101", "13/-4/99999999999999999999", "fast"})
    EXPECT_FALSE(MiddleOf(wrong)) << wrong;
}

TEST(RegimeBucket, FindsTheNearestOne) {
  constexpr double kNoLimit = std::numeric_limits<double>::infinity();
  const std::vector<std::string> buckets = {"13/-4/0", "13/-2/0", "-/-2/0"};
  EXPECT_EQ(NearestOf(buckets, Features(10'000, 0.02F, 0), 1), 0u);
  EXPECT_EQ(NearestOf(buckets, Features(10'000, 0.3F, 0), 1), 1u);
  EXPECT_EQ(NearestOf(buckets, Features(-1, 0.2F, 0), 1), 2u);
  EXPECT_EQ(NearestOf(buckets, Features(10'000, 5, 0), 1), std::nullopt);
  EXPECT_EQ(NearestOf(buckets, Features(10'000, 5, 0), kNoLimit), 1u);
  EXPECT_EQ(NearestOf({}, Features(10'000, 5, 0), kNoLimit), std::nullopt);
}

}  // namespace
}  // namespace sweepstake::decision
