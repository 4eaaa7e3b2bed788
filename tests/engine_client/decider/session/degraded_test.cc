// Tests the verdict `degraded`: even with the leading arm, detection makes the game miss the floor
// of the frame rate.
#include <gtest/gtest.h>

#include "engine_client/decider/session/safeguards.h"
#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

// Returns a window at this frame rate in which detection takes all of the time.
FrameRateFloor::Times AllDetection(double fps) { return {1e3 / fps, 1e3 / fps}; }

// Observes `count` such windows of arm 0, which is the leader by default.
void Observe(FrameRateFloor& floor, double fps, int count, uint32_t leader = 0) {
  for (int i = 0; i < count; ++i) floor.Observe(0, AllDetection(fps), leader);
}

// Returns whether a scene is degraded after windows with these times, with a floor of 30 FPS.
bool IsDegradedBy(double frame_ms, double detection_ms) {
  FrameRateFloor floor(30, 1);
  for (uint32_t i = 0; i < FrameRateFloor::kWindowCount; ++i)
    floor.Observe(0, {frame_ms, detection_ms}, 0);
  return floor.degraded();
}

TEST(FrameRateFloor, IsDegradedAfterThreeSlowWindowsInARow) {
  FrameRateFloor floor(30, 2);
  Observe(floor, 29, 2);
  Observe(floor, 31, 1);
  Observe(floor, 29, 2);
  EXPECT_FALSE(floor.degraded());
  Observe(floor, 29, 1);
  EXPECT_TRUE(floor.degraded());
}

TEST(FrameRateFloor, IsNotDegradedAfterThreeFastWindowsInARow) {
  FrameRateFloor floor(30, 2);
  Observe(floor, 10, 3);
  Observe(floor, 60, 2);
  Observe(floor, 10, 1);
  Observe(floor, 30, 2);
  EXPECT_TRUE(floor.degraded());
  Observe(floor, 30, 1);
  EXPECT_FALSE(floor.degraded());
}

TEST(FrameRateFloor, IgnoresASlowArmIfTheLeaderWasFastOrNeverRan) {
  FrameRateFloor floor(30, 2);
  Observe(floor, 10, 9, 1);
  EXPECT_FALSE(floor.degraded());
  floor.Observe(1, AllDetection(60), 1);
  Observe(floor, 10, 9, 1);
  EXPECT_FALSE(floor.degraded());
}

TEST(FrameRateFloor, CountsSlowWindowsOfAnyArmIfTheLeaderWasSlowToo) {
  FrameRateFloor floor(30, 2);
  floor.Observe(1, AllDetection(10), 1);
  Observe(floor, 10, 2, 1);
  EXPECT_TRUE(floor.degraded());
  Observe(floor, 60, 3, 1);
  EXPECT_FALSE(floor.degraded());
}

TEST(FrameRateFloor, OfZeroIsNeverMissed) {
  FrameRateFloor floor(0, 2);
  Observe(floor, 1e-3, 9);
  EXPECT_FALSE(floor.degraded());
}

TEST(FrameRateFloor, IsNotMissedByAGameThatIsSlowWithoutTheBroadPhase) {
  EXPECT_FALSE(IsDegradedBy(1e3 / 12, 5)) << "a cap at 12 FPS";
  EXPECT_FALSE(IsDegradedBy(50, 16));
  EXPECT_TRUE(IsDegradedBy(50, 17)) << "without the broad phase, a frame takes 33 ms";
  EXPECT_TRUE(IsDegradedBy(34, 1));
  EXPECT_FALSE(IsDegradedBy(33, 33)) << "the game reaches the floor";
}

TEST(FrameRateFloor, IsMissedIfDetectionTakesHalfOfASlowFrame) {
  EXPECT_FALSE(IsDegradedBy(100, 49));
  EXPECT_TRUE(IsDegradedBy(100, 50));
}

TEST(FrameRateFloor, IsReachedAgainWhenTheRestOfTheFrameIsTheCause) {
  FrameRateFloor floor(30, 1);
  Observe(floor, 10, 3);
  for (uint32_t i = 0; i < FrameRateFloor::kWindowCount; ++i) {
    EXPECT_TRUE(floor.degraded());
    floor.Observe(0, {100, 5}, 0);
  }
  EXPECT_FALSE(floor.degraded());
}

TEST(SteadyVerdict, ChangesAfterThreeTicksInARow) {
  SteadyVerdict steady;
  const auto observe = [&](Verdict verdict, int count) {
    for (int i = 1; i < count; ++i) steady.Observe(verdict);
    return steady.Observe(verdict);
  };
  EXPECT_EQ(observe(Verdict::kUnknown, 5), Verdict::kUnknown);
  EXPECT_EQ(observe(Verdict::kTie, 1), Verdict::kTie) << "the first verdict is published at once";
  EXPECT_EQ(observe(Verdict::kStable, 2), Verdict::kTie);
  EXPECT_EQ(observe(Verdict::kTie, 1), Verdict::kTie);
  EXPECT_EQ(observe(Verdict::kStable, 2), Verdict::kTie) << "the ticks were not in a row";
  EXPECT_EQ(observe(Verdict::kStable, 1), Verdict::kStable);
  EXPECT_EQ(observe(Verdict::kUnknown, 1), Verdict::kUnknown);
}

TEST(Verdict, IsUnknownUntilAWindowWasLearnt) {
  ScriptedClient client(PlainSetup(2));
  EXPECT_EQ(client.session.diagnosis().verdict, Verdict::kUnknown);
  client.Settle();
  client.RunTicks(2);
  EXPECT_NE(client.session.diagnosis().verdict, Verdict::kUnknown);
}

TEST(Verdict, IsDegradedWhileTheOnlyArmMissesTheFloor) {
  ScriptedClient client(PlainSetup(1));
  client.Settle();
  client.frame.frame_time_ns = 50 * kMillisecond;
  EXPECT_EQ(client.RunTicks(9).record.diagnosis.verdict, Verdict::kStable) << "detection is short";
  client.frame.detection_time_ns = 20 * kMillisecond;
  client.RunTicks(2);
  EXPECT_EQ(client.session.diagnosis().verdict, Verdict::kStable);
  EXPECT_EQ(client.RunTicks(2).record.diagnosis.verdict, Verdict::kDegraded);
  client.frame.frame_time_ns = 10 * kMillisecond;
  EXPECT_EQ(client.RunTicks(2).record.diagnosis.verdict, Verdict::kDegraded);
  EXPECT_EQ(client.RunTicks(2).record.diagnosis.verdict, Verdict::kStable);
}

// Frames without a search, as in a menu, do not depend on the arms.
TEST(Verdict, IgnoresFramesWithoutASearch) {
  SessionSetup setup = PlainSetup(1);
  setup.options.policy = "adaptive";
  ScriptedClient client(setup);
  client.Settle();
  client.RunToTick();
  client.frame.frame_time_ns = 50 * kMillisecond;
  client.frame.detection_time_ns = 0;
  EXPECT_EQ(client.RunTicks(5).record.diagnosis.verdict, Verdict::kStable);
}

TEST(Verdict, IsDegradedByBailOutsWithoutAWindow) {
  ScriptedClient client(PlainSetup(1));
  client.Settle();
  client.RunTicks(2);
  const FrameSample stall{.frame_time_ns = 6'000'000'000, .detection_time_ns = 5'900'000'000};
  client.session.ObserveBailOut(stall, client.now_ns);
  client.session.ObserveBailOut(stall, client.now_ns);
  EXPECT_EQ(client.session.diagnosis().verdict, Verdict::kStable);
  client.session.ObserveBailOut(stall, client.now_ns);
  EXPECT_EQ(client.session.diagnosis().verdict, Verdict::kDegraded);
}

}  // namespace
}  // namespace sweepstake::decision
