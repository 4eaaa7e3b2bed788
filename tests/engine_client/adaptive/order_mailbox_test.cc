#include "engine_client/adaptive/order_mailbox.h"

#include <gtest/gtest.h>

namespace sweepstake {
namespace {

TEST(OrderMailbox, ReturnsAnOrderOnceAndComplete) {
  OrderMailbox mailbox;
  EXPECT_FALSE(mailbox.Take().has_value());
  mailbox.Post({.order_id = 0xFFFF'FFFF'FFFF, .mode = Mode::kManual, .arm = 31});
  const auto order = mailbox.Take();
  ASSERT_TRUE(order.has_value());
  EXPECT_EQ(order->order_id, 0xFFFF'FFFF'FFFF);
  EXPECT_EQ(order->mode, Mode::kManual);
  EXPECT_EQ(order->arm, 31U);
  EXPECT_FALSE(mailbox.Take().has_value());
}

TEST(OrderMailbox, KeepsOnlyTheLatestOrderAlsoWithoutAnArm) {
  OrderMailbox mailbox;
  mailbox.Post({.order_id = 1, .mode = Mode::kManual, .arm = 0});
  mailbox.Post({.order_id = 2, .mode = Mode::kAi, .arm = std::nullopt});
  const auto order = mailbox.Take();
  EXPECT_EQ(order->order_id, 2U);
  EXPECT_EQ(order->mode, Mode::kAi);
  EXPECT_EQ(order->arm, std::nullopt);
}

}  // namespace
}  // namespace sweepstake
