#include <gtest/gtest.h>

#include <thread>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {
namespace {

TEST(SwitchMailbox, IsEmptyAtFirst) {
  SwitchMailbox mailbox;
  EXPECT_FALSE(mailbox.Take().has_value());
}

TEST(SwitchMailbox, ReturnsACommandOnceAndComplete) {
  SwitchMailbox mailbox;
  mailbox.Post({.command_id = 0xFF'FFFF'FFFF,
                .arm = 31,
                .reason = SwitchReason::kManual,
                .trial_limit_percent = 120});
  const auto command = mailbox.Take();
  ASSERT_TRUE(command.has_value());
  EXPECT_EQ(command->command_id, 0xFF'FFFF'FFFF);
  EXPECT_EQ(command->arm, 31U);
  EXPECT_EQ(command->reason, SwitchReason::kManual);
  EXPECT_EQ(command->trial_limit_percent, 120U);
  EXPECT_FALSE(mailbox.Take().has_value());
}

TEST(SwitchMailbox, KeepsTheLatestCommand) {
  SwitchMailbox mailbox;
  mailbox.Post({.command_id = 1, .arm = 1});
  mailbox.Post({.command_id = 2, .arm = 0});
  EXPECT_EQ(mailbox.Take()->command_id, 2U);
}

TEST(SwitchMailbox, ClampsAnArmOrALimitThatDoesNotFit) {
  SwitchMailbox mailbox;
  mailbox.Post({.command_id = 1, .arm = 256 + 3, .trial_limit_percent = 256 + 3});
  const auto command = mailbox.Take();
  EXPECT_EQ(command->arm, 255U);
  EXPECT_EQ(command->trial_limit_percent, 255U);
}

TEST(SwitchMailbox, PassesCommandsBetweenThreadsInOrder) {
  constexpr uint64_t kCommandCount = 100'000;
  SwitchMailbox mailbox;
  std::thread poster([&mailbox] {
    for (uint64_t id = 1; id <= kCommandCount; ++id) {
      mailbox.Post({.command_id = id, .arm = static_cast<uint32_t>(id % 32)});
    }
  });
  uint64_t latest = 0;
  while (latest < kCommandCount) {
    const auto command = mailbox.Take();
    if (!command) continue;
    ASSERT_GT(command->command_id, latest);
    ASSERT_EQ(command->arm, command->command_id % 32);
    latest = command->command_id;
  }
  poster.join();
}

}  // namespace
}  // namespace sweepstake
