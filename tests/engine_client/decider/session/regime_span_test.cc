#include "engine_client/decider/regime_span.h"

#include <gtest/gtest.h>

namespace sweepstake::decision {
namespace {

constexpr uint64_t kPeriod = 64;

// Observes the frames of a period and then its descriptor.
class Scene {
 public:
  void Play(DescriptorMatch match) {
    for (uint64_t i = 0; i < kPeriod; ++i) span.ObserveFrame(next_frame_++);
    span.ObserveDescriptor(match);
  }

  RegimeSpan span;

 private:
  uint64_t next_frame_ = 0;
};

TEST(RegimeSpan, HoldsAllFramesWithoutDescriptors) {
  const RegimeSpan span;
  EXPECT_TRUE(span.Contains(0));
  EXPECT_TRUE(span.Contains(1'000'000));
  EXPECT_FALSE(span.has_ended());
}

TEST(RegimeSpan, EndsBeforeThePeriodOfAnotherRegimesDescriptor) {
  Scene scene;
  scene.Play(DescriptorMatch::kPresent);
  scene.Play(DescriptorMatch::kOther);
  EXPECT_TRUE(scene.span.has_ended());
  EXPECT_TRUE(scene.span.Contains(kPeriod - 1));
  EXPECT_FALSE(scene.span.Contains(kPeriod));
  scene.Play(DescriptorMatch::kPresent);
  EXPECT_TRUE(scene.span.has_ended()) << "until the next regime begins";
  EXPECT_FALSE(scene.span.Contains(kPeriod));
}

TEST(RegimeSpan, BeginsTheNextRegimeAfterItsFirstDescriptor) {
  Scene scene;
  scene.Play(DescriptorMatch::kPresent);
  scene.Play(DescriptorMatch::kOther);
  scene.span.BeginNext();
  EXPECT_FALSE(scene.span.has_ended());
  EXPECT_FALSE(scene.span.Contains(2 * kPeriod - 1));
  EXPECT_TRUE(scene.span.Contains(2 * kPeriod));
}

TEST(RegimeSpan, AMixtureBeforeAKnownRegimeBelongsToNeither) {
  Scene scene;
  scene.Play(DescriptorMatch::kPresent);
  scene.Play(DescriptorMatch::kUnknown);
  EXPECT_FALSE(scene.span.has_ended());
  EXPECT_TRUE(scene.span.is_in_doubt());
  scene.Play(DescriptorMatch::kOther);
  EXPECT_TRUE(scene.span.has_ended());
  EXPECT_TRUE(scene.span.Contains(kPeriod - 1));
  EXPECT_FALSE(scene.span.Contains(kPeriod));
}

TEST(RegimeSpan, EndsAfterTwoUnknownDescriptors) {
  Scene scene;
  scene.Play(DescriptorMatch::kPresent);
  scene.Play(DescriptorMatch::kUnknown);
  scene.Play(DescriptorMatch::kUnknown);
  EXPECT_TRUE(scene.span.has_ended());
}

TEST(RegimeSpan, GoesOnAfterASingleUnknownDescriptor) {
  Scene scene;
  scene.Play(DescriptorMatch::kPresent);
  scene.Play(DescriptorMatch::kUnknown);
  scene.Play(DescriptorMatch::kPresent);
  EXPECT_FALSE(scene.span.has_ended());
  EXPECT_FALSE(scene.span.is_in_doubt());
  EXPECT_TRUE(scene.span.Contains(3 * kPeriod));
}

}  // namespace
}  // namespace sweepstake::decision
