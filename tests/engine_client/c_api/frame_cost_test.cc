// Tests the costs of the C ABI per frame other than time: no call allocates, locks or blocks.
#include <gtest/gtest.h>

#include <vector>

#include "sweepstake/c_api.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/malloc_counter.h"
#include "tests/support/wait_counter.h"

namespace {

using sweepstake::test_support::ThreadAllocationCount;
using sweepstake::test_support::ThreadMallocCount;
using sweepstake::test_support::WaitCounter;

constexpr uint32_t kCount = 500;
constexpr int kWarmUpFrames = 100;
constexpr int kMeasuredFrames = 100;

uint64_t AllocationCount() { return ThreadAllocationCount() + ThreadMallocCount(); }

// A set of proxies that a session searches, and the memory of its queries.
class CFrameCost : public ::testing::Test {
 protected:
  CFrameCost() {
    swp_session_options options{};
    options.struct_size = sizeof options;
    EXPECT_EQ(swp_session_options_init(&options), SWP_OK);
    options.sorted_pairs = 1;
    EXPECT_EQ(swp_session_create(&options, &session_), SWP_OK);
    swp_proxies_options events{};
    events.struct_size = sizeof events;
    EXPECT_EQ(swp_proxies_options_init(&events), SWP_OK);
    events.pair_events = 1;
    EXPECT_EQ(swp_proxies_create(&events, &proxies_), SWP_OK);
    MoveBoxes(0);
    EXPECT_EQ(swp_proxies_add_many(proxies_, boxes_.data(), nullptr, kCount, handles_.data()),
              SWP_OK);
  }
  ~CFrameCost() override {
    swp_session_destroy(session_);
    swp_proxies_destroy(proxies_);
  }

  // Moves a row of boxes to and fro; each box touches its neighbours.
  void MoveBoxes(int frame) {
    const float y = frame % 2 == 0 ? 0.0F : 0.25F;
    for (uint32_t i = 0; i < kCount; ++i) {
      const auto x = static_cast<float>(i);
      boxes_[i] = {{x, y, 0}, {x + 1, y + 1, 1}};
      rays_[i] = {{x + 0.5F, -1, 0.5F}, {0, 1, 0}, 10};
    }
  }

  void RunFrame(int frame) {
    const swp_aabb* moving = nullptr;
    const swp_pair* pairs = nullptr;
    const swp_proxy_pair* added = nullptr;
    uint32_t count = 0;
    uint64_t pair_count = 0;
    uint64_t added_count = 0;
    MoveBoxes(frame);
    ASSERT_EQ(swp_proxies_set_boxes(proxies_, handles_.data(), boxes_.data(), kCount), SWP_OK);
    ASSERT_EQ(swp_proxies_moving_boxes(proxies_, &moving, &count), SWP_OK);
    ASSERT_EQ(swp_session_begin_frame(session_), SWP_OK);
    ASSERT_EQ(swp_session_find_pairs(session_, moving, count), SWP_OK);
    ASSERT_EQ(swp_session_pairs(session_, &pairs, &pair_count), SWP_OK);
    ASSERT_EQ(swp_proxies_resolve(proxies_, pairs, pair_count), SWP_OK);
    ASSERT_EQ(swp_proxies_pairs(proxies_, &pairs, &pair_count), SWP_OK);
    ASSERT_EQ(pair_count, kCount - 1);
    ASSERT_EQ(swp_proxies_added(proxies_, &added, &added_count), SWP_OK);
    ASSERT_EQ(swp_proxies_prepare_queries(proxies_), SWP_OK);
    ASSERT_EQ(swp_proxies_query_boxes(proxies_, boxes_.data(), kCount, nullptr, found_.data(),
                                      found_.size(), ends_.data()),
              SWP_OK);
    ASSERT_EQ(swp_proxies_cast_rays(proxies_, rays_.data(), kCount, nullptr, hits_.data()), SWP_OK);
    ASSERT_EQ(swp_session_end_frame(session_, 5000000, 0), SWP_OK);
    // A call that fails does not allocate or block either.
    ASSERT_EQ(swp_session_end_frame(session_, 5000000, 0), SWP_FAILED_PRECONDITION);
  }

  swp_session* session_ = nullptr;
  swp_proxies* proxies_ = nullptr;
  std::vector<swp_aabb> boxes_ = std::vector<swp_aabb>(kCount);
  std::vector<swp_ray> rays_ = std::vector<swp_ray>(kCount);
  std::vector<swp_proxy> handles_ = std::vector<swp_proxy>(kCount);
  std::vector<swp_proxy> found_ = std::vector<swp_proxy>(4 * kCount);
  std::vector<uint64_t> ends_ = std::vector<uint64_t>(kCount);
  std::vector<swp_ray_hit> hits_ = std::vector<swp_ray_hit>(kCount);
};

TEST_F(CFrameCost, AllocatesNothingAndNeverBlocksAfterWarmUp) {
  for (int frame = 0; frame < kWarmUpFrames; ++frame) RunFrame(frame);
  for (int frame = 0; frame < kMeasuredFrames; ++frame) {
    const uint64_t before = AllocationCount();
    const WaitCounter waits;
    RunFrame(frame);
    ASSERT_EQ(AllocationCount(), before) << "frame " << frame;
    ASSERT_EQ(waits.count(), 0U) << waits.last_call();
  }
}

}  // namespace
