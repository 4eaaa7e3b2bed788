#include "engine_client/adaptive/switch_handover.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace sweepstake {
namespace {

using State = SwitchHandover::State;

TEST(SwitchHandoverTest, HandsOverAnOfferOfTheRequestedArm) {
  SwitchHandover handover;
  EXPECT_FALSE(handover.Take());
  handover.Want(3);
  EXPECT_EQ(handover.order().state, State::kWanted);
  EXPECT_EQ(handover.order().arm, 3U);
  EXPECT_FALSE(handover.Take());
  EXPECT_TRUE(handover.Offer(handover.order()));
  EXPECT_TRUE(handover.Take());
  EXPECT_EQ(handover.order().state, State::kTaken);
  EXPECT_FALSE(handover.Take());
  handover.Done();
  EXPECT_EQ(handover.order().state, State::kNone);
}

TEST(SwitchHandoverTest, IgnoresAnAnswerToACancelledRequest) {
  SwitchHandover handover;
  handover.Want(3);
  const SwitchHandover::Order first = handover.order();
  handover.Cancel();
  EXPECT_FALSE(handover.Offer(first));
  handover.Want(3);
  EXPECT_FALSE(handover.Decline(first));
  EXPECT_EQ(handover.order().state, State::kWanted);
  EXPECT_TRUE(handover.Decline(handover.order()));
  EXPECT_FALSE(handover.Take());
}

TEST(SwitchHandoverTest, ACancelWithdrawsAnOffer) {
  SwitchHandover handover;
  handover.Want(1);
  EXPECT_TRUE(handover.Offer(handover.order()));
  handover.Cancel();
  EXPECT_FALSE(handover.Take());
}

// The payload is not atomic, so that ThreadSanitizer reports if both sides access it at the same
// time.
TEST(SwitchHandoverTest, OnlyOneSideOwnsThePayload) {
  constexpr int kRounds = 2000;
  SwitchHandover handover;
  uint64_t payload = 0;
  std::atomic<bool> stop{false};
  std::thread lane([&] {
    while (!stop.load()) {
      const SwitchHandover::Order order = handover.order();
      if (order.state != State::kWanted) {
        std::this_thread::yield();
        continue;
      }
      ++payload;
      handover.Offer(order);
    }
  });
  uint64_t taken = 0;
  for (int round = 0; round < kRounds; ++round) {
    handover.Want(0);
    for (int look = 0; look < 1 + round % 3 * 1000; ++look) {
      if (handover.Take()) {
        ++payload;
        ++taken;
        handover.Done();
        break;
      }
      std::this_thread::yield();
    }
    handover.Cancel();
  }
  stop.store(true);
  lane.join();
  EXPECT_GE(payload, taken);
}

}  // namespace
}  // namespace sweepstake
