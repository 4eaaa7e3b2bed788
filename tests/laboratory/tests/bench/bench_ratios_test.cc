// Tests the ratios that a bench run computes from its rows, with synthetic times.
#include "tests/laboratory/bench/bench_report.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine_client/cli/io/statistics.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake::cli {
namespace {

// A report with one thread and one instruction set; the test adds cells and rows.
class Bench {
 public:
  Bench() { report_.options.simd = {simd_}; }

  Bench& Cell(const std::string& scene, uint32_t object_count) {
    report_.cells.push_back({scene, object_count});
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
  // Arms that are added from now on have this instruction set.
  Bench& Simd(const std::string& name) {
    simd_ = name;
    return *this;
  }
  Bench& Measured(std::vector<std::string> simd) {
    report_.options.simd = std::move(simd);
    return *this;
  }
  // Marks the first `count` steps of the latest row as warm-up.
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

  // Returns the ratios of one kind.
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
    if (kind == ContestantKind::kArm) row.simd = simd_;
    row.thread_count = threads;
    row.frame_count = step_ms.size();
    row.first_step = 1;
    static_cast<TimeSummary&>(row) = Summarize(step_ms);
    row.step_ms = std::move(step_ms);
    report_.rows.push_back(std::move(row));
  }

  std::string simd_ = "avx2";
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
  // The peer stopped after two steps, which are both within the arm's warm-up.
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
  EXPECT_DOUBLE_EQ(overall[0].value, 2);  // both with one thread
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

TEST(Ratios, CompareAnInstructionSetWithTheNextBetterOneThatWasMeasured) {
  const auto ratios = Bench()
                          .Measured({"avx512", "avx2", "sse4"})
                          .Cell("suite-b", 1000)
                          .Simd("sse4")
                          .Arm("Grid", {9, 9, 3})
                          .Arm("SAP", {8})
                          .Simd("avx2")
                          .Arm("Grid", {6, 6, 6})
                          .Arm("Grid", {2}, 2)
                          .Simd("avx512")
                          .Arm("Grid", {4, 4, 4})
                          .Arm("SAP", {1})
                          .Peer("Grid", "Peer", {7})
                          .Ratios(RatioKind::kSimd);
  ASSERT_EQ(ratios.size(), 2U) << "SAP has no better one beside SSE4, two threads none at all";
  EXPECT_EQ(ratios[0].ours, "Grid");
  EXPECT_EQ(ratios[0].simd, "sse4");
  EXPECT_EQ(ratios[0].other, "avx2");
  EXPECT_DOUBLE_EQ(ratios[0].value, 1.5);
  EXPECT_DOUBLE_EQ(*ratios[0].value_mean, 7.0 / 6);
  EXPECT_EQ(ratios[1].simd, "avx2");
  EXPECT_EQ(ratios[1].other, "avx512");
  EXPECT_DOUBLE_EQ(ratios[1].value, 1.5);
}

TEST(Ratios, CompareInstructionSetsOnTheFramesThatBothMeasured) {
  const auto ratios = Bench()
                          .Measured({"avx2", "sse4"})
                          .Cell("suite-b", 1000)
                          .Arm("Grid", {50, 1, 1})
                          .WarmUp(1)
                          .Simd("sse4")
                          .Arm("Grid", {1, 2, 2})
                          .WarmUp(1)
                          .Ratios(RatioKind::kSimd);
  ASSERT_EQ(ratios.size(), 1U);
  EXPECT_DOUBLE_EQ(ratios[0].value_mean.value(), 2);
}

// Returns a cell with Grid, SAP and one peer, measured with AVX2 and SSE4. SAP is faster than Grid
// only with SSE4.
Bench OfTwoSets() {
  return Bench()
      .Measured({"avx2", "sse4"})
      .Threads({1, 2})
      .Cell("suite-b", 10'000)
      .Arm("Grid", {2})
      .Arm("Grid", {1}, 2)
      .Arm("SAP", {3})
      .Simd("sse4")
      .Arm("Grid", {6})
      .Arm("Grid", {4}, 2)
      .Arm("SAP", {5})
      .Peer("Grid", "Peer", {30});
}

TEST(Ratios, CompareEachInstructionSetsBestArmWithThePeers) {
  const auto overall = OfTwoSets().Ratios(RatioKind::kOverall);
  ASSERT_EQ(overall.size(), 4U) << "one and two threads of each";
  EXPECT_EQ(overall[0].simd, "avx2");
  EXPECT_EQ(overall[0].ours, "Grid");
  EXPECT_DOUBLE_EQ(overall[0].value, 15);
  EXPECT_EQ(overall[2].simd, "sse4");
  EXPECT_EQ(overall[2].ours, "SAP");
  EXPECT_DOUBLE_EQ(overall[2].value, 6);
  EXPECT_EQ(overall[3].thread_count, 2U);
  EXPECT_DOUBLE_EQ(overall[3].value, 7.5);
}

TEST(Ratios, OfFamiliesAndThreadsAreOfOneInstructionSet) {
  const auto bench = OfTwoSets();
  const auto family = bench.Ratios(RatioKind::kFamily);
  ASSERT_EQ(family.size(), 2U);
  EXPECT_EQ(family[1].simd, "sse4");
  EXPECT_DOUBLE_EQ(family[1].value, 5);
  const auto threads = bench.Ratios(RatioKind::kThreads);
  ASSERT_EQ(threads.size(), 2U);
  EXPECT_DOUBLE_EQ(threads[0].value, 2);
  EXPECT_EQ(threads[1].simd, "sse4");
  EXPECT_DOUBLE_EQ(threads[1].value, 1.5);
}

TEST(Ratios, OfGrowthAreOfOneInstructionSet) {
  const auto growth = Bench()
                          .Measured({"avx2", "sse4"})
                          .Cell("suite-b", 10'000)
                          .Arm("Grid", {1})
                          .Simd("sse4")
                          .Arm("Grid", {2})
                          .Cell("suite-b", 1'000'000)
                          .Arm("Grid", {300})
                          .Ratios(RatioKind::kGrowth);
  ASSERT_EQ(growth.size(), 1U);
  EXPECT_EQ(growth[0].simd, "sse4");
  EXPECT_DOUBLE_EQ(growth[0].value, 1.5);
}

TEST(Speedups, AreThoseOfEachInstructionSet) {
  const auto speedups = OfTwoSets().Speedups();
  ASSERT_EQ(speedups.size(), 4U);
  EXPECT_EQ(speedups[0].simd, "avx2");
  EXPECT_DOUBLE_EQ(speedups[0].median, 15);
  EXPECT_EQ(speedups[2].simd, "sse4");
  EXPECT_DOUBLE_EQ(speedups[2].median, 5);
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
