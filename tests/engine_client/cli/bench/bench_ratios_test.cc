// What a bench run concludes from its rows, on made-up times.
#include "engine_client/cli/bench/bench_report.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine_client/cli/io/statistics.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake::cli {
namespace {

// A report of one thread with cells and rows as the test adds them.
class Bench {
 public:
  Bench& Cell(const std::string& scene, uint32_t object_count) {
    report_.cells.push_back({scene, object_count, false});
    return *this;
  }
  Bench& Arm(const std::string& name, std::vector<double> step_ms, uint32_t threads = 1) {
    Add(ContestantKind::kArm, name, name, std::move(step_ms), threads);
    return *this;
  }
  Bench& Peer(const std::string& family, const std::string& name, std::vector<double> step_ms,
              uint32_t threads = 1) {
    Add(ContestantKind::kPeer, family, name, std::move(step_ms), threads);
    return *this;
  }
  // The first `count` steps of the latest row were warm-up.
  Bench& WarmUp(uint64_t count) {
    report_.rows.back().frame_count -= count;
    return *this;
  }
  Bench& Differs() {
    report_.rows.back().difference = "step 1";
    return *this;
  }
  Bench& Threads(std::vector<uint32_t> counts) {
    report_.options.thread_counts = std::move(counts);
    return *this;
  }

  std::vector<BenchSpeedup> Speedups() const { return SpeedupsOf(report_); }

  // The ratios of one kind.
  std::vector<BenchRatio> Ratios(RatioKind kind) const {
    std::vector<BenchRatio> ratios = RatiosOf(report_);
    std::erase_if(ratios, [&](const BenchRatio& ratio) { return ratio.kind != kind; });
    return ratios;
  }

 private:
  void Add(ContestantKind kind, const std::string& family, const std::string& name,
           std::vector<double> step_ms, uint32_t threads) {
    BenchRow row;
    row.cell = report_.cells.size() - 1;
    row.kind = kind;
    row.family = family;
    row.name = name;
    row.thread_count = threads;
    row.frame_count = step_ms.size();
    row.first_step = 1;
    const TimeSummary summary = Summarize(step_ms);
    row.ms_median = summary.ms_median;
    row.ms_p99 = summary.ms_p99;
    row.step_ms = std::move(step_ms);
    report_.rows.push_back(std::move(row));
  }

  BenchReport report_;
};

TEST(Ratios, CompareAnArmWithTheBestPeerOfItsFamilyOnly) {
  const auto ratios = Bench()
                          .Cell("suite-b", 500)
                          .Arm("Grid", {1, 1, 4})
                          .Peer("Grid", "Slow", {9, 9, 9})
                          .Peer("Grid", "Quick", {7, 7, 1})
                          .Peer("SAP", "Quickest", {2, 2, 2})
                          .Ratios(RatioKind::kFamily);
  ASSERT_EQ(ratios.size(), 1U);
  EXPECT_EQ(ratios[0].ours, "Grid");
  EXPECT_EQ(ratios[0].other, "Quick");
  EXPECT_DOUBLE_EQ(ratios[0].value, 7);
  EXPECT_DOUBLE_EQ(*ratios[0].value_mean, 2.5);
}

TEST(Ratios, CompareOurBestWithTheBestOfAllPeers) {
  const auto ratios = Bench()
                          .Cell("suite-b", 500)
                          .Arm("Grid", {2})
                          .Arm("SAP", {1})
                          .Peer("Grid", "Slow", {9})
                          .Peer("KDTree", "Quick", {4})
                          .Ratios(RatioKind::kOverall);
  ASSERT_EQ(ratios.size(), 1U);
  EXPECT_EQ(ratios[0].ours, "SAP");
  EXPECT_EQ(ratios[0].other, "Quick");
  EXPECT_DOUBLE_EQ(ratios[0].value, 4);
}

TEST(Ratios, CompareOnTheFramesThatAPeerMeasuredBeforeItsCap) {
  // The peer stopped after two steps, all of them within the warm-up of the arm.
  const auto ratios = Bench()
                          .Cell("suite-b", 500)
                          .Arm("Grid", {1, 1, 10, 10})
                          .WarmUp(2)
                          .Peer("Grid", "Capped", {8, 8})
                          .Ratios(RatioKind::kFamily);
  ASSERT_EQ(ratios.size(), 1U);
  EXPECT_DOUBLE_EQ(ratios[0].value, 8);
}

TEST(Ratios, LeaveOutTheWarmUp) {
  const auto ratios = Bench()
                          .Cell("suite-b", 500)
                          .Arm("Grid", {50, 1, 1})
                          .WarmUp(1)
                          .Peer("Grid", "Peer", {50, 3, 3})
                          .WarmUp(1)
                          .Ratios(RatioKind::kFamily);
  EXPECT_DOUBLE_EQ(ratios.at(0).value, 3);
  EXPECT_DOUBLE_EQ(ratios.at(0).value_mean.value(), 3);
}

TEST(Speedups, CompareEveryArmWithEveryPeerOfItsCellOverTheirCommonFrames) {
  const auto speedups = Bench()
                            .Cell("suite-b", 500)
                            .Arm("Grid", {1, 1, 10})
                            .Arm("Grid", {1}, 2)
                            .Peer("SAP", "Capped", {8})
                            .Peer("SAP", "Wrong", {8})
                            .Differs()
                            .Cell("suite-b", 600)
                            .Arm("SAP", {2})
                            .Peer("Grid", "Slow", {6})
                            .Speedups();
  ASSERT_EQ(speedups.size(), 2U);
  EXPECT_EQ(speedups[0].arm, "Grid");
  EXPECT_EQ(speedups[0].peer, "Capped");
  EXPECT_DOUBLE_EQ(speedups[0].median, 8);
  EXPECT_EQ(speedups[1].cell, 1U);
  EXPECT_DOUBLE_EQ(speedups[1].mean, 3);
}

TEST(Ratios, IgnoreAPeerWhosePairsAreWrong) {
  const auto bench = Bench()
                         .Cell("suite-b", 500)
                         .Arm("Grid", {1})
                         .Peer("Grid", "Wrong", {2})
                         .Differs()
                         .Peer("Grid", "Right", {5});
  EXPECT_EQ(bench.Ratios(RatioKind::kFamily).at(0).other, "Right");
  EXPECT_EQ(bench.Ratios(RatioKind::kOverall).at(0).other, "Right");
}

TEST(Ratios, CompareThreadsWithOneThreadAndPeersOfAsManyThreads) {
  const auto bench = Bench()
                         .Cell("suite-b", 10'000)
                         .Threads({1, 2})
                         .Arm("Grid", {4})
                         .Arm("Grid", {2}, 2)
                         .Peer("KDTree", "Embree", {8})
                         .Peer("KDTree", "Embree", {6}, 2);
  const auto threads = bench.Ratios(RatioKind::kThreads);
  ASSERT_EQ(threads.size(), 1U);
  EXPECT_DOUBLE_EQ(threads[0].value, 2);
  const auto overall = bench.Ratios(RatioKind::kOverall);
  ASSERT_EQ(overall.size(), 2U);
  EXPECT_DOUBLE_EQ(overall[0].value, 2);  // one thread against one
  EXPECT_EQ(overall[1].thread_count, 2U);
  EXPECT_DOUBLE_EQ(overall[1].value, 3);
}

TEST(Ratios, MeasureGrowthPerObjectBetweenTenThousandAndAMillion) {
  const auto ratios = Bench()
                          .Cell("suite-b", 10'000)
                          .Arm("Grid", {1})
                          .Arm("SAP", {1})
                          .Cell("suite-b", 1'000'000)
                          .Arm("Grid", {250})
                          .Arm("SAP", {250})
                          .Ratios(RatioKind::kGrowth);
  ASSERT_EQ(ratios.size(), 1U);
  EXPECT_EQ(ratios[0].ours, "Grid");
  EXPECT_DOUBLE_EQ(ratios[0].value, 2.5);
}

TEST(Ratios, CompareTheSlowestFramesOfTheKdTreeWithItsMedian) {
  std::vector<double> times(100, 1.0);
  times[50] = times[51] = 3;
  const auto spikes = Bench()
                          .Cell("suite-b", 100'000)
                          .Arm("KDTree", times)
                          .Arm("Grid", times)
                          .Ratios(RatioKind::kSpike);
  ASSERT_EQ(spikes.size(), 1U);
  EXPECT_DOUBLE_EQ(spikes[0].value, 3);
}

}  // namespace
}  // namespace sweepstake::cli
