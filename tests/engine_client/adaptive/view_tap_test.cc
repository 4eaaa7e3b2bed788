#include "engine_client/adaptive/view_tap.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace sweepstake {
namespace {

// Returns boxes; box i begins at coordinate i.
std::vector<Aabb> Boxes(size_t count) {
  std::vector<Aabb> boxes;
  for (size_t i = 0; i < count; ++i) {
    const auto at = static_cast<float>(i);
    boxes.push_back({{at, at, at}, {at + 1, at + 1, at + 1}});
  }
  return boxes;
}

TEST(ViewTap, CopiesOnlyTheFrameAfterARequest) {
  ViewTap tap;
  tap.OnFrame(Boxes(3), 1);
  EXPECT_FALSE(tap.has_frame());
  tap.Request(10);
  EXPECT_FALSE(tap.has_frame());
  tap.OnFrame(Boxes(3), 2);
  tap.OnFrame(Boxes(5), 3);
  ASSERT_TRUE(tap.has_frame());
  EXPECT_EQ(tap.frame().frame_index, 2U);
  EXPECT_EQ(tap.frame().object_count, 3U);
  EXPECT_EQ(tap.frame().stride, 1U);
  const std::vector<Aabb> expected = Boxes(3);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), tap.frame().boxes.begin(),
                         tap.frame().boxes.end()));
}

TEST(ViewTap, CopiesEveryNthBoxIfNotAllFit) {
  ViewTap tap;
  for (const size_t count : {0U, 1U, 9U, 10U, 11U, 20U, 21U, 999U}) {
    tap.Request(10);
    tap.OnFrame(Boxes(count), 0);
    ASSERT_TRUE(tap.has_frame());
    const ViewedFrame frame = tap.frame();
    EXPECT_EQ(frame.object_count, count);
    EXPECT_EQ(frame.stride, std::max<size_t>(1, (count + 9) / 10));
    ASSERT_EQ(frame.boxes.size(), (count + frame.stride - 1) / frame.stride);
    for (size_t i = 0; i < frame.boxes.size(); ++i)
      EXPECT_EQ(frame.boxes[i].min[0], static_cast<float>(i * frame.stride));
  }
}

TEST(ViewTap, ReleaseCancelsARequest) {
  ViewTap tap;
  tap.Request(10);
  EXPECT_TRUE(tap.Release());
  tap.OnFrame(Boxes(3), 1);
  EXPECT_FALSE(tap.has_frame());
  tap.Request(4);
  tap.OnFrame(Boxes(3), 2);
  EXPECT_TRUE(tap.Release());
  EXPECT_FALSE(tap.has_frame());
}

TEST(ViewTap, GivesCompleteFramesWithTwoThreads) {
  ViewTap tap;
  std::atomic<bool> stopping{false};
  std::thread frames([&] {
    for (uint64_t index = 0; !stopping; ++index) tap.OnFrame(Boxes(50 + index % 7), index);
  });
  for (int i = 0; i < 300; ++i) {
    tap.Request(20);
    while (!tap.has_frame()) std::this_thread::yield();
    const ViewedFrame frame = tap.frame();
    EXPECT_EQ(frame.object_count, 50 + frame.frame_index % 7);
    EXPECT_EQ(frame.boxes.back().min[0],
              static_cast<float>((frame.boxes.size() - 1) * frame.stride));
    tap.Request(30);
    while (!tap.Release()) std::this_thread::yield();
  }
  stopping = true;
  frames.join();
}

}  // namespace
}  // namespace sweepstake
