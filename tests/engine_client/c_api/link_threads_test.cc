// Tests a link that runs on another thread than the frame thread.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "sweepstake/c_api.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/wait_counter.h"

namespace {

using sweepstake::test_support::ThreadAllocationCount;
using sweepstake::test_support::WaitCounter;

// The welcome to session "a".
constexpr char kWelcome[] = "\x0a\x03\x0a\x01\x61";

// Sends the link's messages until it has none left after `stop`, and counts them.
uint64_t Drive(swp_link* link, const std::atomic<bool>& stop) {
  std::vector<char> buffer(1 << 16);
  uint64_t count = 0;
  EXPECT_EQ(swp_link_connected(link, 0), SWP_OK);
  while (true) {
    const bool is_last = stop;
    uint64_t size = 0;
    swp_link_action action = SWP_LINK_NONE;
    EXPECT_EQ(swp_link_next_message(link, 0, buffer.data(), buffer.size(), &size, &action), SWP_OK);
    if (action != SWP_LINK_SEND && is_last) break;
    if (action != SWP_LINK_SEND) continue;
    EXPECT_GT(size, 0U);
    if (count++ == 0) {
      EXPECT_EQ(swp_link_on_message(link, kWelcome, sizeof kWelcome - 1, 0), SWP_OK);
    }
  }
  return count;
}

TEST(LinkThreadsTest, TheFrameThreadNeitherBlocksNorAllocatesForALink) {
  swp_session_options options{};
  options.struct_size = sizeof options;
  ASSERT_EQ(swp_session_options_init(&options), SWP_OK);
  options.arms = "Grid";
  swp_session* session = nullptr;
  ASSERT_EQ(swp_session_create(&options, &session), SWP_OK);
  swp_link_options link_options{};
  link_options.struct_size = sizeof link_options;
  ASSERT_EQ(swp_link_options_init(&link_options), SWP_OK);
  link_options.batch_frames = 1;
  swp_link* link = nullptr;
  ASSERT_EQ(swp_link_create(session, &link_options, &link), SWP_OK);

  const std::vector<swp_aabb> boxes(100, {{0, 0, 0}, {1, 1, 1}});
  const auto frame = [&] {
    EXPECT_EQ(swp_session_begin_frame(session), SWP_OK);
    EXPECT_EQ(swp_session_find_pairs(session, boxes.data(), 100), SWP_OK);
    EXPECT_EQ(swp_session_end_frame(session, 1000, 0), SWP_OK);
  };
  for (int i = 0; i < 10; ++i) frame();
  std::atomic<bool> stop = false;
  uint64_t message_count = 0;
  std::thread transport([&] { message_count = Drive(link, stop); });
  {
    const WaitCounter waits;
    const uint64_t before = ThreadAllocationCount();
    for (int i = 0; i < 2000; ++i) frame();
    EXPECT_EQ(ThreadAllocationCount(), before);
    EXPECT_EQ(waits.count(), 0U) << waits.last_call();
  }
  stop = true;
  transport.join();
  swp_link_stats stats{};
  stats.struct_size = sizeof stats;
  EXPECT_EQ(swp_link_status(link, &stats), SWP_OK);
  // After the Hello, each frame is a message, until the limit of unacknowledged messages.
  EXPECT_EQ(stats.sent_frame_count, link_options.unacknowledged_messages);
  EXPECT_EQ(message_count, 1U + link_options.unacknowledged_messages);
  swp_link_destroy(link);
  swp_session_destroy(session);
}

// Returns the number of locks that the end of a session takes.
uint64_t LocksOfTheEnd(bool has_link) {
  swp_session_options options{};
  options.struct_size = sizeof options;
  EXPECT_EQ(swp_session_options_init(&options), SWP_OK);
  options.shadow = SWP_SHADOW_OFF;
  swp_session* session = nullptr;
  swp_link* link = nullptr;
  EXPECT_EQ(swp_session_create(&options, &session), SWP_OK);
  if (has_link) {
    EXPECT_EQ(swp_link_create(session, nullptr, &link), SWP_OK);
  }
  const WaitCounter waits;
  swp_session_destroy(session);
  const uint64_t count = waits.count();
  swp_link_destroy(link);
  return count;
}

TEST(LinkThreadsTest, TheEndOfASessionTakesTheLockOfItsLink) {
  if (!WaitCounter::Works()) GTEST_SKIP();
  EXPECT_GT(LocksOfTheEnd(true), LocksOfTheEnd(false));
}

// A sanitizer reports a call of the link that uses the session after its end.
TEST(LinkThreadsTest, TheEndOfASessionWaitsForTheCallOfItsLink) {
  for (int round = 0; round < 200; ++round) {
    swp_session* session = nullptr;
    swp_link* link = nullptr;
    ASSERT_EQ(swp_session_create(nullptr, &session), SWP_OK);
    ASSERT_EQ(swp_link_create(session, nullptr, &link), SWP_OK);
    std::atomic<int> call_count = 0;
    std::thread transport([&] {
      uint64_t size = 0;
      swp_link_action action = SWP_LINK_NONE;
      while (swp_link_next_message(link, 0, nullptr, 0, &size, &action) == SWP_OK) ++call_count;
    });
    while (call_count < 10) std::this_thread::yield();
    swp_session_destroy(session);
    transport.join();
    swp_link_destroy(link);
  }
}

}  // namespace
