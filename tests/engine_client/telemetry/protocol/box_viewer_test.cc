// Tests which boxes a game sends, when, and for how long. The daemon's side uses protobuf.
#include "engine_client/telemetry/protocol/box_viewer.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <utility>

#include "engine_client/scene/box_scenes.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {
namespace {

constexpr uint64_t kMs = 1'000'000;

uint32_t NumberAt(const std::string& bytes, size_t place) {
  return static_cast<uint8_t>(bytes[2 * place]) |
         static_cast<uint32_t>(static_cast<uint8_t>(bytes[2 * place + 1])) << 8;
}

std::set<std::pair<uint32_t, uint32_t>> PairsIn(const protocol::BoxView& view) {
  std::set<std::pair<uint32_t, uint32_t>> pairs;
  for (size_t i = 0; i < view.pairs.size() / 4; ++i)
    pairs.emplace(NumberAt(view.pairs, 2 * i), NumberAt(view.pairs, 2 * i + 1));
  return pairs;
}

ViewedFrame FrameOf(std::span<const Aabb> boxes) {
  return {.frame_index = 7, .object_count = 3 * boxes.size(), .stride = 3, .boxes = boxes};
}

TEST(BoxView, HasEachBoxToTheQuantizationStepAndEachPair) {
  const BoxScene scene("brownian", 400, 3);
  const std::span<const Aabb> boxes = scene.boxes();
  const protocol::BoxView view = ViewOf(FrameOf(boxes), BoxViewer::kMaxBytes);
  EXPECT_EQ(view.frame_index, 7U);
  EXPECT_EQ(view.object_count, 1200U);
  EXPECT_EQ(view.stride, 3U);
  ASSERT_EQ(view.boxes.size(), 12 * boxes.size());
  std::set<std::pair<uint32_t, uint32_t>> expected;
  for (uint32_t i = 0; i < boxes.size(); ++i) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const float step = (view.bounds[3 + axis] - view.bounds[axis]) / 65'535;
      const float low =
          view.bounds[axis] + static_cast<float>(NumberAt(view.boxes, 6 * i + axis)) * step;
      const float high =
          view.bounds[axis] + static_cast<float>(NumberAt(view.boxes, 6 * i + 3 + axis)) * step;
      EXPECT_NEAR(low, boxes[i].min[axis], 1.5F * step);
      EXPECT_NEAR(high, boxes[i].max[axis], 1.5F * step);
    }
    for (uint32_t j = i + 1; j < boxes.size(); ++j)
      if (Overlap(boxes[i], boxes[j])) expected.emplace(i, j);
  }
  EXPECT_FALSE(expected.empty());
  EXPECT_EQ(PairsIn(view), expected);
}

TEST(BoxView, StaysWithinItsBytesAndOmitsInvalidBoxes) {
  std::vector<Aabb> boxes(5000, Aabb{{0, 0, 0}, {1, 1, 1}});
  boxes[0].min[1] = std::numeric_limits<float>::quiet_NaN();
  boxes[1].max[0] = std::numeric_limits<float>::infinity();
  for (const uint32_t max_bytes : {64U, 1000U, BoxViewer::kMaxBytes}) {
    const protocol::BoxView view = ViewOf(FrameOf(boxes), max_bytes);
    EXPECT_LE(view.boxes.size() + view.pairs.size(), max_bytes);
    EXPECT_GT(view.pairs.size(), max_bytes / 8) << "all boxes overlap";
    EXPECT_EQ(view.bounds, (std::vector<float>{0, 0, 0, 1, 1, 1}));
    EXPECT_EQ(NumberAt(view.boxes, 3), 65'535U);
  }
  EXPECT_EQ(ViewOf(FrameOf(std::span(boxes).first(2)), 1000).boxes, "") << "no valid box";
  EXPECT_EQ(ViewOf(FrameOf({}), 1000).bounds.size(), 0U);
  const std::vector<Aabb> point(2, Aabb{{4, 4, 4}, {4, 4, 4}});
  EXPECT_EQ(ViewOf(FrameOf(point), 1000).boxes, std::string(24, '\0'))
      << "the bounds have no extent";
}

class BoxViewerTest : public ::testing::Test {
 protected:
  void Ask(uint32_t interval_ms, uint32_t max_bytes, uint32_t until_ms) {
    viewer_.OnRequest({.interval_ms = interval_ms, .max_bytes = max_bytes, .until_ms = until_ms},
                      now_ns_);
  }
  // Advances by milliseconds with one frame; returns whether a view was sent.
  bool Step(uint64_t ms = 1) {
    now_ns_ += ms * kMs;
    tap_.OnFrame(boxes_, ++frame_);
    if (!viewer_.Advance(now_ns_)) return false;
    EXPECT_TRUE(request_.ParseFromString(std::string(viewer_.message())));
    viewer_.MarkSent();
    return true;
  }
  int ViewsIn(int ms) {
    int count = 0;
    for (int i = 0; i < ms; ++i) count += Step() ? 1 : 0;
    return count;
  }

  ViewTap tap_;
  BoxViewer viewer_{tap_};
  const std::vector<Aabb> boxes_ = std::vector<Aabb>(10, Aabb{{0, 0, 0}, {1, 1, 1}});
  uint64_t now_ns_ = 5 * kMs;
  uint64_t frame_ = 0;
  v1::StreamTelemetryRequest request_;
};

TEST_F(BoxViewerTest, SendsNoViewWithoutARequest) { EXPECT_EQ(ViewsIn(1000), 0); }

TEST_F(BoxViewerTest, SendsViewsAtTheIntervalUntilTheTimeIsOver) {
  Ask(500, 10'000, 2'000);
  EXPECT_EQ(ViewsIn(5'000), 4);
  EXPECT_EQ(request_.sequence(), 0U);
  EXPECT_EQ(request_.box_view().object_count(), 10U);
  EXPECT_EQ(request_.box_view().stride(), 1U);
  EXPECT_EQ(request_.box_view().boxes().size(), 120U);
  EXPECT_EQ(request_.box_view().pairs().size(), 4U * 45);
  tap_.OnFrame(boxes_, 1);
  EXPECT_FALSE(tap_.has_frame()) << "the frame thread has no more requests";
}

TEST_F(BoxViewerTest, ContinuesAfterANewRequestAndStopsAfterAnEmptyOne) {
  Ask(250, 10'000, 1'000);
  EXPECT_EQ(ViewsIn(900), 4);
  Ask(250, 10'000, 1'000);
  EXPECT_EQ(ViewsIn(900), 4);
  Ask(0, 0, 0);
  EXPECT_EQ(ViewsIn(900), 0);
}

TEST_F(BoxViewerTest, LimitsTheRequestedValues) {
  Ask(1, 4'000'000, 4'000'000);
  EXPECT_EQ(ViewsIn(20'000), 40) << "every 250 ms for 10 s";
  Ask(1'000'000, 10'000, 5'000);
  EXPECT_EQ(ViewsIn(5'000), 3) << "every 2 s";
  Ask(250, 3, 5'000);
  EXPECT_EQ(ViewsIn(1'000), 0) << "no box fits";
}

TEST_F(BoxViewerTest, SendsNoViewWhileTheGameIsPaused) {
  Ask(250, 10'000, 5'000);
  for (int i = 0; i < 1'000; ++i) EXPECT_FALSE(viewer_.Advance(now_ns_ += kMs));
  EXPECT_TRUE(Step()) << "the first frame after the pause";
  EXPECT_EQ(ViewsIn(240), 0);
}

}  // namespace
}  // namespace sweepstake
