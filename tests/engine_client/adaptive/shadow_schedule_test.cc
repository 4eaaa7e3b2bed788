#include "engine_client/adaptive/shadow_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/support/scripted_clock.h"

namespace sweepstake {
namespace {

using ::testing::ElementsAre;

using test_support::kMs;

// Runs sweeps of visits of eight frames with the costs in `cost_ns`.
class ShadowScheduleTest : public ::testing::Test {
 protected:
  std::vector<uint32_t> Sweep(uint32_t active_arm = 0, uint32_t object_count = 1000) {
    now_ns_ = std::max(now_ns_, schedule_.next_sweep_ns());
    schedule_.Begin(now_ns_, search_ns_, active_arm, object_count);
    std::vector<uint32_t> visited;
    while (const auto arm = schedule_.NextArm()) {
      visited.push_back(*arm);
      Visit(*arm);
    }
    return visited;
  }

  void Visit(uint32_t arm) {
    const std::vector<uint64_t> frames(kShadowBurstFrames, cost_ns_[arm]);
    ShadowVisit visit = SummarizeVisit(frames, options_.visit_cap_ns);
    visit.arm = arm;
    visit.native_bytes = bytes_[arm];
    now_ns_ += visit.busy_ns;
    busy_ns_ += visit.busy_ns;
    schedule_.OnVisit(visit);
  }

  // Returns the number of visits of each arm in `count` sweeps.
  std::map<uint32_t, int> CountVisits(int count, uint32_t active_arm = 0) {
    std::map<uint32_t, int> visits;
    for (int i = 0; i < count; ++i) {
      for (const uint32_t arm : Sweep(active_arm)) ++visits[arm];
    }
    return visits;
  }

  ShadowScheduleOptions options_{.memory_cap_bytes = 1000};
  std::vector<uint64_t> cost_ns_{1 * kMs, 1 * kMs, 1 * kMs};
  std::vector<uint64_t> bytes_{0, 0, 0};
  ShadowSchedule schedule_{options_, 3};
  uint64_t now_ns_ = 5 * kMs;
  uint64_t busy_ns_ = 0;
  uint64_t search_ns_ = 0;
};

TEST_F(ShadowScheduleTest, StartsAtOnceWithAllArmsActiveOneFirst) {
  cost_ns_[0] = 100 * kMs;
  EXPECT_EQ(schedule_.next_sweep_ns(), 0U);
  EXPECT_THAT(Sweep(2), ElementsAre(2, 0, 1));
}

TEST_F(ShadowScheduleTest, VisitsArmsInverselyToTheSquareOfTheirCost) {
  cost_ns_ = {1 * kMs, 14 * kMs / 10, 3 * kMs};
  Sweep();
  const std::map<uint32_t, int> visits = CountVisits(90);
  EXPECT_EQ(visits.at(0), 90);
  EXPECT_EQ(visits.at(1), 90);
  EXPECT_EQ(visits.at(2), 10);
}

TEST_F(ShadowScheduleTest, VisitsEvenTheSlowestArmOncePerMaximumPeriod) {
  cost_ns_[2] = 20 * kMs;
  Sweep();
  EXPECT_EQ(CountVisits(3 * ShadowSchedule::kMaxPeriod).at(2), 3);
}

TEST_F(ShadowScheduleTest, VisitsTheActiveArmInEverySweep) {
  cost_ns_[2] = 20 * kMs;
  Sweep(2);
  EXPECT_EQ(CountVisits(20, 2).at(2), 20);
}

TEST_F(ShadowScheduleTest, StaysWithinItsShareOfTheTime) {
  cost_ns_ = {30 * kMs, 40 * kMs, 90 * kMs};
  const uint64_t begun_ns = now_ns_;
  CountVisits(500);
  const double share =
      static_cast<double>(busy_ns_) / static_cast<double>(schedule_.next_sweep_ns() - begun_ns);
  EXPECT_LE(share, options_.duty_ratio + 1e-9);
  EXPECT_GT(share, options_.duty_ratio * 0.99);
}

TEST_F(ShadowScheduleTest, CountsOtherWorkOfItsThread) {
  Sweep();
  const uint64_t before_ns = schedule_.next_sweep_ns();
  schedule_.Spend(300 * kMs);
  EXPECT_GE(schedule_.next_sweep_ns(), before_ns + 1900 * kMs);
}

TEST_F(ShadowScheduleTest, StaysWithinItsShareOfTheFrameThreadsTime) {
  cost_ns_ = {3 * kMs, 4 * kMs, 9 * kMs};
  const uint64_t begun_ns = now_ns_ = 100'000 * kMs;
  const auto sweep = [&](double slowdown) {
    const uint64_t busy_before_ns = busy_ns_;
    Sweep();
    const double cost_ns = slowdown * static_cast<double>(busy_ns_ - busy_before_ns);
    schedule_.Charge(now_ns_, cost_ns);
    return cost_ns;
  };
  double cost_ns = 0;
  for (int k = 0; k < 500; ++k) cost_ns += sweep(0.5);
  const auto whole_ns = static_cast<double>(schedule_.next_sweep_ns() - begun_ns);
  const auto saved_ns = static_cast<double>(ShadowSchedule::kSavingsNs);
  EXPECT_NEAR(cost_ns / (whole_ns + saved_ns), ShadowSchedule::kMaxCostRatio, 1e-4);

  // In a scene that changes all the time the lane may use what it would have saved in a steady
  // scene, but no more.
  const uint64_t changing_ns = now_ns_;
  cost_ns = 0;
  for (int k = 0; k < 500; ++k) {
    cost_ns_[0] = 9 * kMs - cost_ns_[0];
    cost_ns += sweep(0.5);
  }
  const auto changed_ns = static_cast<double>(schedule_.next_sweep_ns() - changing_ns);
  EXPECT_LT(cost_ns / changed_ns, 2.2 * ShadowSchedule::kMaxCostRatio);
  EXPECT_GT(cost_ns / changed_ns, 1.3 * ShadowSchedule::kMaxCostRatio);
}

TEST_F(ShadowScheduleTest, CheapSweepsHaveAMinimumInterval) {
  cost_ns_ = {1000, 1000, 1000};
  const uint64_t begun_ns = now_ns_;
  Sweep();
  EXPECT_EQ(schedule_.next_sweep_ns(), begun_ns + options_.sweep_interval_min_ns);
}

TEST_F(ShadowScheduleTest, AlternatesTheOrderOfSweeps) {
  EXPECT_THAT(Sweep(1), ElementsAre(1, 0, 2));
  EXPECT_THAT(Sweep(1), ElementsAre(2, 0, 1));
  EXPECT_THAT(Sweep(1), ElementsAre(1, 0, 2));
}

TEST_F(ShadowScheduleTest, VisitsEveryArmIfTheActiveCostOrObjectCountChanges) {
  cost_ns_[2] = 20 * kMs;
  Sweep();
  EXPECT_THAT(Sweep(), ElementsAre(1, 0));
  cost_ns_[0] = 124 * kMs / 100;
  EXPECT_THAT(Sweep(), ElementsAre(0, 1));
  cost_ns_[0] = 126 * kMs / 100;
  EXPECT_THAT(Sweep(), ElementsAre(1, 0, 2)) << "an arm is visited once per sweep";
  EXPECT_THAT(Sweep(), ElementsAre(0, 1));
  EXPECT_THAT(Sweep(0, 1240), ElementsAre(1, 0));
  EXPECT_THAT(Sweep(0, 1260), ElementsAre(0, 1, 2));
  EXPECT_THAT(Sweep(0, 1260), ElementsAre(1, 0));
}

TEST_F(ShadowScheduleTest, WorksHalfTheSearchTimeAndAtTheMaximumSpacing) {
  EXPECT_TRUE(schedule_.IsDue(now_ns_, 0));
  Sweep();
  schedule_.Spend(ShadowSchedule::kWorkAheadNs);
  const uint64_t next_ns = schedule_.next_sweep_ns();
  EXPECT_FALSE(schedule_.IsDue(next_ns, busy_ns_));
  EXPECT_TRUE(schedule_.IsDue(next_ns, 2 * busy_ns_));
  EXPECT_FALSE(schedule_.IsDue(next_ns - 1, 2 * busy_ns_));
  EXPECT_TRUE(schedule_.IsDue(next_ns + ShadowSchedule::kMaxSpacingNs, 0));
}

// Ten minutes of searches without sweeps, as in manual mode, do not count as savings. Five minutes
// of work in a changing scene do not count as debt.
TEST_F(ShadowScheduleTest, LimitsSavingsAndDebtToTheWorkAhead) {
  for (const bool worked : {true, false}) {
    if (worked) {
      schedule_.Spend(300'000 * kMs);
    } else {
      search_ns_ += 600'000 * kMs;
    }
    now_ns_ += 3'000'000 * kMs;
    Sweep();
    const uint64_t ahead_ns = 2 * ShadowSchedule::kWorkAheadNs;
    schedule_.Spend(2 * ahead_ns);
    now_ns_ = schedule_.next_sweep_ns();
    EXPECT_FALSE(schedule_.IsDue(now_ns_, search_ns_)) << worked;
    EXPECT_TRUE(schedule_.IsDue(now_ns_, search_ns_ + 5 * ahead_ns)) << worked;
  }
}

TEST_F(ShadowScheduleTest, DetectsACostThatDriftsInSmallSteps) {
  cost_ns_[2] = 20 * kMs;
  Sweep();
  int full_sweeps = 0;
  for (int step = 0; step < 12; ++step) {
    cost_ns_[0] = cost_ns_[0] * 106 / 100;
    if (Sweep().size() == 3) ++full_sweeps;
  }
  EXPECT_EQ(full_sweeps, 3);
}

TEST_F(ShadowScheduleTest, BacksOffExponentiallyFromAnArmOverTheTimeCap) {
  cost_ns_[2] = options_.visit_cap_ns + 1;
  // Without the back-off, arm 2 would be in every 1.8² = 3rd sweep.
  cost_ns_[0] = cost_ns_[1] = options_.visit_cap_ns * 10 / 18;
  std::vector<int> sweeps_of_arm_2;
  for (int sweep = 1; sweep <= 160; ++sweep) {
    const std::vector<uint32_t> visited = Sweep();
    if (std::count(visited.begin(), visited.end(), 2U) > 0) sweeps_of_arm_2.push_back(sweep);
  }
  EXPECT_THAT(sweeps_of_arm_2, ElementsAre(1, 4, 8, 16, 32, 64, 128));
}

TEST_F(ShadowScheduleTest, ChangedCostsDoNotRepeatAVisitOverTheTimeCap) {
  cost_ns_[2] = options_.visit_cap_ns + 1;
  Sweep();
  std::ptrdiff_t visits = 0;
  for (int sweep = 0; sweep < 30; ++sweep) {
    cost_ns_[0] = cost_ns_[0] == 1 * kMs ? 2 * kMs : 1 * kMs;
    const std::vector<uint32_t> visited = Sweep();
    visits += std::count(visited.begin(), visited.end(), 2U);
  }
  EXPECT_EQ(visits, 0);
  EXPECT_THAT(Sweep(0, 100), ElementsAre(2, 1, 0));
}

TEST_F(ShadowScheduleTest, VisitsAllContendersIfAllExceedTheTimeCap) {
  cost_ns_ = {300 * kMs, 310 * kMs, 320 * kMs};
  CountVisits(5);
  EXPECT_THAT(Sweep(), ElementsAre(2, 1, 0));
}

TEST_F(ShadowScheduleTest, SkipsArmsOverTheMemoryCapEvenTheActiveOne) {
  bytes_[0] = 1001;
  Sweep();
  EXPECT_THAT(Sweep(), ElementsAre(2, 1));
  EXPECT_THAT(Sweep(), ElementsAre(0, 1, 2));
  EXPECT_THAT(Sweep(), ElementsAre(2, 1));
  EXPECT_THAT(Sweep(0, 100), ElementsAre(0, 1, 2));
}

TEST(SummarizeVisit, TakesTheMedianWithoutBuildAndWarmUp) {
  const std::vector<uint64_t> frames{90, 1, 2, 14, 13, 12, 11, 10};
  const ShadowVisit visit = SummarizeVisit(frames, 1000);
  EXPECT_EQ(visit.detection_ns, 12U);
  EXPECT_EQ(visit.build_ns, 90U);
  EXPECT_EQ(visit.busy_ns, 153U);
  EXPECT_EQ(visit.frame_count, 5U);
  EXPECT_FALSE(visit.capped);
}

TEST(SummarizeVisit, EndsWithTheFrameThatReachesTheCap) {
  const std::vector<uint64_t> frames{90, 5, 4, 14, 13, 12, 11, 10};
  ShadowVisit visit = SummarizeVisit(frames, 113);
  EXPECT_TRUE(visit.capped);
  EXPECT_EQ(visit.busy_ns, 113U);
  EXPECT_EQ(visit.frame_count, 1U);
  EXPECT_EQ(visit.detection_ns, 14U);
  visit = SummarizeVisit(frames, 95);
  EXPECT_TRUE(visit.capped);
  EXPECT_EQ(visit.frame_count, 0U);
  EXPECT_EQ(visit.detection_ns, 5U);
}

TEST(SummarizeVisit, IsNotCappedByItsLastFrame) {
  const std::vector<uint64_t> frames{1, 1, 1, 1, 1, 1, 1, 100};
  EXPECT_FALSE(SummarizeVisit(frames, 50).capped);
}

}  // namespace
}  // namespace sweepstake
