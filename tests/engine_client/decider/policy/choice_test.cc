#include "engine_client/decider/policy/policy.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/engine_client/decider/scripted_client.h"

namespace sweepstake::decision {
namespace {

constexpr int64_t kCooldown = 40 * kSecond;

ChoiceInput TickAt(int64_t now_ns, std::optional<int64_t> last_switch_ns) {
  ChoiceInput input;
  input.now_ns = now_ns;
  input.last_tick_ns = now_ns - 2 * kSecond;
  input.last_switch_ns = last_switch_ns;
  return input;
}

TEST(TimeToChoose, IsTheFirstTickAfterEachWholeCooldownSinceTheSwitch) {
  const int64_t switched = 7 * kSecond;
  std::vector<int64_t> times;
  for (int64_t now = 8 * kSecond; now < 140 * kSecond; now += 2 * kSecond) {
    if (IsTimeToChoose(TickAt(now, switched), kCooldown)) times.push_back(now / kSecond);
  }
  EXPECT_EQ(times, (std::vector<int64_t>{48, 88, 128}));
}

TEST(TimeToChoose, IsTheFirstTickAndEachWholeCooldownAfterTheStartUntilASwitch) {
  std::vector<int64_t> times;
  for (int64_t now = 2 * kSecond; now < 100 * kSecond; now += 2 * kSecond) {
    if (IsTimeToChoose(TickAt(now, std::nullopt), kCooldown)) times.push_back(now / kSecond);
  }
  EXPECT_EQ(times, (std::vector<int64_t>{2, 40, 80}));
}

TEST(TimeToChoose, IsOnlyOnceAfterALateTickThatSpansSeveralCooldowns) {
  ChoiceInput late = TickAt(200 * kSecond, 0);
  late.last_tick_ns = 30 * kSecond;
  EXPECT_TRUE(IsTimeToChoose(late, kCooldown));
  EXPECT_FALSE(IsTimeToChoose(TickAt(202 * kSecond, 0), kCooldown));
}

TEST(TimeToChoose, IsEveryBailOutAndEveryTickWithoutCooldown) {
  ChoiceInput input = TickAt(12 * kSecond, 0);
  EXPECT_FALSE(IsTimeToChoose(input, kCooldown));
  EXPECT_TRUE(IsTimeToChoose(input, 0));
  input.bailed_out = true;
  EXPECT_TRUE(IsTimeToChoose(input, kCooldown));
}

TEST(TimeToChoose, AcceptsTheLargestTimeDifferences) {
  ChoiceInput input = TickAt(std::numeric_limits<int64_t>::max(), std::nullopt);
  input.last_switch_ns = std::numeric_limits<int64_t>::min();
  input.last_tick_ns = 0;
  EXPECT_TRUE(IsTimeToChoose(input, kCooldown));
}

TEST(HighestOf, TakesTheFirstOfEqualArms) {
  const Choice choice = HighestOf({0.5, 0.75, 0.75, 0.1});
  EXPECT_EQ(choice.candidate, 1u);
  EXPECT_EQ(choice.draws.size(), 4u);
}

}  // namespace
}  // namespace sweepstake::decision
