#include "engine_client/decider/window.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace sweepstake::decision {
namespace {

constexpr uint64_t kHuge = ~uint64_t{0};

TEST(Window, FpsIsFramesOverUnscaledTime) {
  Window window;
  window.Add({.frame_time_ns = 10'000'000});
  window.Add({.frame_time_ns = 30'000'000});
  EXPECT_DOUBLE_EQ(window.Metrics().fps, 50);  // not the mean of 100 and 33.3
}

TEST(Window, DetectionAndChecksAreMeansAndMemoryIsThePeak) {
  Window window;
  window.Add({.frame_time_ns = 1'000'000,
              .detection_time_ns = 2'000'000,
              .aabb_check_count = 1'000,
              .native_bytes = 3 << 20,
              .object_count = 101});
  window.Add({.frame_time_ns = 1'000'000,
              .detection_time_ns = 4'000'000,
              .aabb_check_count = 3'040,
              .native_bytes = 2 << 20,
              .object_count = 101});
  const WindowMetrics metrics = window.Metrics();
  EXPECT_DOUBLE_EQ(metrics.detection_ms, 3);
  EXPECT_DOUBLE_EQ(metrics.native_mib, 3);
  EXPECT_DOUBLE_EQ(metrics.check_ratio, 2'020.0 / 5'050);
}

// Adds `count` frames with this detection time.
void AddFrames(Window& window, int count, uint64_t detection_time_ns) {
  for (int i = 0; i < count; ++i)
    window.Add({.frame_time_ns = 16'000'000, .detection_time_ns = detection_time_ns});
}

TEST(Window, CalmTimeLimitsAnInterruptedFrameToTwiceTheTypicalTime) {
  Window window;
  for (int i = 0; i < 10; ++i) {
    AddFrames(window, 9, 1'000'000);
    AddFrames(window, 1, 50'000'000);
  }
  EXPECT_DOUBLE_EQ(window.Metrics().detection_ms, 5.9);
  EXPECT_NEAR(window.Metrics().calm_detection_ms, 1.1, 0.02);
}

TEST(Window, TheTypicalTimeIsKeptAcrossWindows) {
  Window window;
  AddFrames(window, 100, 1'000'000);
  window.Clear();
  EXPECT_TRUE(window.empty());
  AddFrames(window, 1, 50'000'000);
  AddFrames(window, 9, 1'000'000);
  EXPECT_NEAR(window.Metrics().calm_detection_ms, 1.1, 0.02);
}

TEST(Window, FramesThatStayLongCountHoweverFewFramesAWindowHas) {
  Window window;
  AddFrames(window, 100, 1'000'000);
  window.Clear();
  AddFrames(window, 2, 10'000'000);
  EXPECT_DOUBLE_EQ(window.Metrics().calm_detection_ms, 10);
  AddFrames(window, 1000, 1'000'000);
  window.Clear();
  AddFrames(window, 9, 1'000'000);
  AddFrames(window, 1, 50'000'000);
  EXPECT_NEAR(window.Metrics().calm_detection_ms, 1.1, 0.02);
}

// Returns the metrics of windows in which three frames of `others_ns` precede each frame of 4 ms.
WindowMetrics WithThreeOthers(uint64_t others_ns) {
  Window window;
  for (int i = 0; i < 200; ++i) {
    if (i == 100) window.Clear();
    AddFrames(window, 3, others_ns);
    AddFrames(window, 1, 4'000'000);
  }
  return window.Metrics();
}

// Every fourth frame is expensive, as with substeps.
TEST(Window, AQuarterOfTheFramesDoesNotCountAsInterrupted) {
  const WindowMetrics metrics = WithThreeOthers(20'000);
  EXPECT_NEAR(metrics.calm_detection_ms, metrics.detection_ms, 0.001);
}

// The physics step runs only in every fourth frame.
TEST(Window, CalmTimeIgnoresFramesWithoutASearch) {
  const WindowMetrics metrics = WithThreeOthers(0);
  EXPECT_DOUBLE_EQ(metrics.detection_ms, 1);
  EXPECT_DOUBLE_EQ(metrics.calm_detection_ms, 4);
}

TEST(Window, MeasuresTheCostOnceAFrameSearched) {
  Window window;
  AddFrames(window, 10, 0);
  EXPECT_FALSE(window.shows_cost());
  AddFrames(window, 1, 1);
  EXPECT_TRUE(window.shows_cost());
  window.Clear();
  EXPECT_FALSE(window.shows_cost());
}

// If only some frames rebuild and the others have no search, the time of a rebuild is neither the
// typical cost of a search nor that of a rebuild.
TEST(Window, MeasuresTheCostOfRebuildsOnlyIfAllFramesRebuild) {
  Window window;
  window.Add({.frame_time_ns = 1, .detection_time_ns = 1, .flags = kFrameRebuild});
  EXPECT_TRUE(window.shows_cost());
  AddFrames(window, 1, 0);
  EXPECT_FALSE(window.shows_cost());
}

TEST(Window, RebuildFramesAreOmittedOnlyFromTheDetectionMean) {
  Window window;
  window.Add({.frame_time_ns = 1'000'000, .detection_time_ns = 2'000'000});
  window.Add({.frame_time_ns = 3'000'000,
              .detection_time_ns = 900'000'000,
              .native_bytes = 1 << 20,
              .flags = kFrameRebuild});
  const WindowMetrics metrics = window.Metrics();
  EXPECT_DOUBLE_EQ(metrics.detection_ms, 2);
  EXPECT_DOUBLE_EQ(metrics.calm_detection_ms, 2);
  EXPECT_DOUBLE_EQ(metrics.native_mib, 1);
  EXPECT_DOUBLE_EQ(metrics.fps, 500);
}

TEST(Window, OnlyRebuildFramesMakeTheDetectionMeanIfThereAreNoOthers) {
  Window window;
  window.Add({.frame_time_ns = 1, .detection_time_ns = 2'000'000, .flags = kFrameRebuild});
  window.Add({.frame_time_ns = 1, .detection_time_ns = 6'000'000, .flags = kFrameRebuild});
  EXPECT_DOUBLE_EQ(window.Metrics().detection_ms, 4);
  EXPECT_DOUBLE_EQ(window.Metrics().calm_detection_ms, 4);
}

TEST(Window, ChecksAreComparedWithAllPairsOfEachFramesObjects) {
  Window window;
  window.Add({.frame_time_ns = 1, .aabb_check_count = 10, .object_count = 5});    // of 10
  window.Add({.frame_time_ns = 1, .aabb_check_count = 135, .object_count = 20});  // of 190
  EXPECT_DOUBLE_EQ(window.Metrics().check_ratio, 145.0 / 200);
}

TEST(Window, WithoutPairsOfObjectsAnyCheckIsBad) {
  for (const uint32_t n : {0u, 1u}) {
    Window window;
    window.Add({.frame_time_ns = 1, .object_count = n});
    EXPECT_EQ(window.Metrics().check_ratio, 0);
    window.Add({.frame_time_ns = 1, .aabb_check_count = 1, .object_count = n});
    EXPECT_EQ(window.Metrics().check_ratio, 1);
  }
}

TEST(Window, AbsurdFramesGiveFiniteMetrics) {
  Window window;
  for (int i = 0; i < 1'000; ++i) {
    window.Add({.frame_time_ns = kHuge,
                .detection_time_ns = kHuge,
                .aabb_check_count = kHuge,
                .native_bytes = kHuge,
                .object_count = ~0u});
  }
  EXPECT_TRUE(window.Metrics().IsFinite());
  EXPECT_NEAR(window.Metrics().fps, 1e9 / 0x1p64, 1e-15);
}

TEST(Window, FramesWithoutTimeHaveNoFiniteFps) {
  Window window;
  window.Add({.frame_time_ns = 0});
  EXPECT_FALSE(window.Metrics().IsFinite());
}

TEST(Window, IsEmptyAgainAfterClear) {
  Window window;
  EXPECT_TRUE(window.empty());
  window.Add({.frame_time_ns = 1'000});
  EXPECT_FALSE(window.empty());
  window.Clear();
  EXPECT_TRUE(window.empty());
}

}  // namespace
}  // namespace sweepstake::decision
