#include "engine_client/telemetry/common/sample_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <thread>
#include <vector>

#include "tests/support/sanitizers/active.h"

namespace sweepstake {
namespace {

FrameSample FrameOf(uint64_t index) {
  FrameSample sample{};
  sample.frame_index = index;
  return sample;
}

// Returns a sample whose fields are functions of its index, so that a torn read is detected.
FrameSample PatternOf(uint64_t index) {
  const auto low = static_cast<uint32_t>(index);
  return {.frame_index = index,
          .frame_time_ns = index * 3,
          .detection_time_ns = ~index,
          .aabb_check_count = index ^ 0x5555,
          .native_bytes = index + 7,
          .pair_count = low,
          .object_count = ~low,
          .arm = low * 5,
          .switch_epoch = low + 1,
          .flags = low ^ 0xAAAA,
          .invalid_box_count = 0};
}

bool IsWhole(const FrameSample& sample) {
  const FrameSample expected = PatternOf(sample.frame_index);
  return std::memcmp(&sample, &expected, sizeof(sample)) == 0;
}

TEST(SampleQueue, ReturnsFramesInOrder) {
  SampleQueue queue(8);
  for (uint64_t i = 0; i < 5; ++i) queue.OnFrame(FrameOf(i));
  for (uint64_t i = 0; i < 5; ++i) EXPECT_EQ(std::get<FrameSample>(*queue.Pop()).frame_index, i);
  EXPECT_FALSE(queue.Pop().has_value());
  EXPECT_EQ(queue.dropped_frame_count(), 0U);
}

TEST(SampleQueue, DropsTheOldestFramesWhenFullAndCountsThem) {
  SampleQueue queue(4);
  for (uint64_t i = 0; i < 10; ++i) queue.OnFrame(FrameOf(i));
  EXPECT_EQ(queue.dropped_frame_count(), 6U);
  for (uint64_t i = 6; i < 10; ++i) EXPECT_EQ(std::get<FrameSample>(*queue.Pop()).frame_index, i);
  EXPECT_FALSE(queue.Pop().has_value());
  EXPECT_EQ(queue.dropped_frame_count(), 6U);
}

TEST(SampleQueue, KeepsTheOrderOfNotesAndFrames) {
  SampleQueue queue(8);
  queue.OnModeChange({.mode = Mode::kManual, .active_arm = 3});
  queue.OnFrame(FrameOf(0));
  SceneDescriptor descriptor;
  descriptor.object_count = 42;
  queue.OnDescriptor(descriptor);
  queue.OnSwitch({.command_id = 7, .arm = 1, .executed = 1});
  queue.OnFrame(FrameOf(1));
  EXPECT_EQ(std::get<ModeChange>(*queue.Pop()).active_arm, 3U);
  EXPECT_EQ(std::get<FrameSample>(*queue.Pop()).frame_index, 0U);
  EXPECT_EQ(std::get<SceneDescriptor>(*queue.Pop()).object_count, 42);
  EXPECT_EQ(std::get<SwitchOutcome>(*queue.Pop()).command_id, 7U);
  EXPECT_EQ(std::get<FrameSample>(*queue.Pop()).frame_index, 1U);
}

TEST(SampleQueue, KeepsSamplesOfTheShadowLaneInASeparateQueue) {
  SampleQueue queue(8);
  EXPECT_FALSE(queue.PopShadow().has_value());
  for (uint64_t i = 0; i < SampleQueue::kShadowCapacity + 3; ++i) {
    ShadowSample sample{};
    sample.first_frame_index = i;
    sample.arm = 2;
    queue.OnShadow(sample);
  }
  EXPECT_FALSE(queue.Pop().has_value());
  for (uint64_t i = 3; i < SampleQueue::kShadowCapacity + 3; ++i) {
    const std::optional<ShadowSample> sample = queue.PopShadow();
    ASSERT_TRUE(sample.has_value());
    EXPECT_EQ(sample->first_frame_index, i);
    EXPECT_EQ(sample->arm, 2U);
  }
  EXPECT_FALSE(queue.PopShadow().has_value());
}

TEST(SampleQueue, KeepsANoteIfTheFramesAroundItWereDropped) {
  SampleQueue queue(4);
  queue.OnFrame(FrameOf(0));
  queue.OnSwitch({.command_id = 7});
  for (uint64_t i = 1; i < 10; ++i) queue.OnFrame(FrameOf(i));
  int switch_count = 0;
  int frame_count = 0;
  while (const auto item = queue.Pop()) {
    ++(std::holds_alternative<SwitchOutcome>(*item) ? switch_count : frame_count);
  }
  EXPECT_EQ(switch_count, 1);
  EXPECT_EQ(frame_count, 4);
}

TEST(SampleQueue, DropsTheOldestNotesWhenThereAreTooMany) {
  SampleQueue queue(4);
  const uint64_t count = SampleQueue::kNoteCapacity + 10;
  for (uint64_t i = 0; i < count; ++i) queue.OnSwitch({.command_id = i});
  EXPECT_EQ(std::get<SwitchOutcome>(*queue.Pop()).command_id, 10U);
  EXPECT_EQ(queue.dropped_note_count(), 10U);
}

// A torn sample needs a reader that is interrupted within a sample until the producer has wrapped
// around. This is so rare that the test needs millions of frames. (lossy_ring_test.cc tests the
// same with large elements, where it is common.)
// With ThreadSanitizer a frame takes ten times as long.
constexpr uint64_t kFrameCount = SWEEPSTAKE_TSAN ? 300'000 : 4'000'000;

// The capacities range from a ring that always overflows to one that rarely does.
class SampleQueueStress : public ::testing::TestWithParam<uint32_t> {};

TEST_P(SampleQueueStress, ReturnsCompleteFramesInOrderAndCountsDroppedOnes) {
  SampleQueue queue(GetParam());
  std::atomic<bool> finished{false};
  std::thread producer([&] {
    for (uint64_t i = 0; i < kFrameCount; ++i) {
      queue.OnFrame(PatternOf(i));
      if (i % 1000 == 0) queue.OnSwitch({.command_id = i});
    }
    finished.store(true, std::memory_order_release);
  });

  uint64_t read_count = 0;
  uint64_t torn_count = 0;
  uint64_t disorder_count = 0;
  uint64_t next_index = 0;
  const auto drain = [&] {
    while (const auto item = queue.Pop()) {
      const auto* frame = std::get_if<FrameSample>(&*item);
      if (frame == nullptr) continue;
      ++read_count;
      torn_count += IsWhole(*frame) ? 0 : 1;
      disorder_count += frame->frame_index < next_index ? 1 : 0;
      next_index = frame->frame_index + 1;
    }
  };
  while (!finished.load(std::memory_order_acquire)) drain();
  drain();
  producer.join();

  EXPECT_EQ(torn_count, 0U);
  EXPECT_EQ(disorder_count, 0U);
  EXPECT_EQ(next_index, kFrameCount);
  EXPECT_EQ(read_count + queue.dropped_frame_count(), kFrameCount);
}

INSTANTIATE_TEST_SUITE_P(Capacities, SampleQueueStress, ::testing::Values(2, 8, 16, 32, 4096));

}  // namespace
}  // namespace sweepstake
