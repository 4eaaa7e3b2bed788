#include "tests/laboratory/bench/scene_timing.h"

#include <gtest/gtest.h>

#include <sstream>

#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/io/text_table.h"
#include "sweepstake/simd.h"

namespace sweepstake::cli {
namespace {

std::vector<Contestant> ContestantsOf(std::initializer_list<std::string_view> arms) {
  std::vector<Contestant> contestants;
  for (const std::string_view arm : arms) {
    contestants.push_back({.broad_phase = std::move(*MakeBroadPhase(arm))});
  }
  return contestants;
}

double MeanOfPairs(const ContestantTiming& timing) {
  double sum = 0;
  for (const auto& pairs : std::span(timing.step_pairs).last(timing.measured_count)) {
    sum += static_cast<double>(pairs.count);
  }
  return sum / static_cast<double>(timing.measured_count);
}

TEST(TimeScene, MeasuresTheFramesAfterTheWarmUpAndTheirPairs) {
  const auto scene = std::move(*OpenScene({"suite-b", 1000, 1}));
  const auto contestants = ContestantsOf({"BruteForce", "SAP"});
  uint64_t steps[2] = {0, 0};
  const auto timings = TimeScene(*scene, contestants, {.warmup = 20, .frames = 120},
                                 [&](size_t index, uint64_t step) { steps[index] = step; });
  EXPECT_EQ(scene->frame_index(), 140U);
  ASSERT_EQ(timings.size(), 2U);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(steps[i], 140U);
    EXPECT_EQ(timings[i].step_ms.size(), 140U);
    EXPECT_EQ(timings[i].measured_count, 120U);
    // The reference suite's table has this mean number of pairs for frames 21 to 140 of scene B
    // with 1,000 objects.
    EXPECT_NEAR(MeanOfPairs(timings[i]), 1379, 0.5);
    EXPECT_GT(timings[i].aabb_checks_mean, 0);
    EXPECT_GT(timings[i].bytes, 0U);
    EXPECT_GE(timings[i].bytes_with_pairs, timings[i].bytes + 1379 * sizeof(OverlapPair));
    EXPECT_FALSE(timings[i].capped);
  }
  EXPECT_EQ(timings[0].step_pairs, timings[1].step_pairs);
}

TEST(TimeScene, FindsTheSameWithColdCaches) {
  const auto timings = [](bool cold) {
    const auto scene = std::move(*OpenScene({"suite-b", 300, 1}));
    return TimeScene(*scene, ContestantsOf({"KDTree", "SAP"}), {.frames = 5, .cold = cold},
                     [](size_t, uint64_t) {});
  };
  const auto warm = timings(false), cold = timings(true);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(cold[i].step_pairs, warm[i].step_pairs);
    EXPECT_EQ(cold[i].step_ms.size(), 5U);
  }
}

TEST(TimeScene, StopsAContestantAtItsCapAndMeasuresWhatItDid) {
  const auto scene = std::move(*OpenScene({"suite-b", 300, 1}));
  auto contestants = ContestantsOf({"SAP", "SAP"});
  contestants[1].cap_s = 0;
  const auto timings =
      TimeScene(*scene, contestants, {.warmup = 5, .frames = 5}, [](size_t, uint64_t) {});
  EXPECT_FALSE(timings[0].capped);
  EXPECT_EQ(timings[0].measured_count, 5U);
  EXPECT_TRUE(timings[1].capped);
  EXPECT_EQ(timings[1].step_ms.size(), 1U);
  EXPECT_EQ(timings[1].measured_count, 1U);
  EXPECT_EQ(timings[1].step_pairs[0], timings[0].step_pairs[0]);
}

// A broad phase that records the instruction sets it was called with and finds no pairs.
class Witness : public BroadPhase {
 public:
  explicit Witness(std::vector<std::string>& seen) : seen_(seen) {}

  std::string_view name() const override { return "Witness"; }
  uint32_t version() const override { return 1; }
  void DoBuild(std::span<const Aabb>) override { seen_.emplace_back(SimdTarget()); }
  void DoUpdate(std::span<const Aabb>) override { seen_.emplace_back(SimdTarget()); }
  void DoFindPairs(PairBuffer&) override { seen_.emplace_back(SimdTarget()); }
  uint64_t aabb_check_count() const override { return 0; }
  size_t native_bytes() const override { return 0; }

 private:
  std::vector<std::string>& seen_;
};

TEST(TimeScene, RunsEachContestantWithItsOwnInstructionSet) {
  const std::string before(SimdTarget());
  std::vector<std::vector<std::string>> seen(SimdTargets().size() + 1);
  std::vector<Contestant> contestants;
  for (size_t i = 0; i < seen.size(); ++i) {
    contestants.push_back({.broad_phase = std::make_unique<Witness>(seen[i])});
    if (i < SimdTargets().size()) contestants.back().simd = SimdTargets()[i];
  }
  const auto scene = std::move(*OpenScene({"suite-b", 100, 1}));
  // 45 frames are more than two blocks, so every contestant has several turns.
  TimeScene(*scene, contestants, {.frames = 45}, [](size_t, uint64_t) {});
  for (size_t i = 0; i < seen.size(); ++i) {
    const std::string own = i < SimdTargets().size() ? std::string(SimdTargets()[i]) : before;
    EXPECT_EQ(seen[i], std::vector<std::string>(2 * 46, own));
  }
  EXPECT_EQ(SimdTarget(), before);
}

TEST(TimeScene, HidesBrokenBoxesFromThoseWhoCannotTakeThemAndRestoresTheIds) {
  const auto scene = std::move(*OpenScene({"broken-boxes", 300, 1}));
  auto contestants = ContestantsOf({"SAP", "SAP"});
  contestants[1].valid_boxes_only = true;
  const auto timings = TimeScene(*scene, contestants, {.frames = 30}, [](size_t, uint64_t) {});
  EXPECT_GT(timings[0].step_pairs.back().count, 0U);
  EXPECT_EQ(timings[0].step_pairs, timings[1].step_pairs);
  EXPECT_GT(timings[0].aabb_checks_mean, 0);
}

TEST(PairFingerprint, IsThatOfTheSetWhateverTheOrder) {
  const std::vector<OverlapPair> pairs = {{1, 2}, {3, 4}, {1, 4}};
  const std::vector<OverlapPair> shuffled = {{1, 4}, {1, 2}, {3, 4}};
  EXPECT_EQ(FingerprintOf(pairs), FingerprintOf(shuffled));
}

TEST(PairFingerprint, TellsOtherPairsApartThoughTheirCountIsTheSame) {
  const std::vector<OverlapPair> pairs = {{1, 2}, {3, 4}};
  const std::vector<std::vector<OverlapPair>> others = {
      {{1, 2}}, {{1, 4}, {3, 2}}, {{2, 1}, {3, 4}}, {{1, 2}, {1, 2}}, {{1, 2}, {3, 4}, {3, 4}}};
  for (const auto& other : others) EXPECT_NE(FingerprintOf(pairs), FingerprintOf(other));
}

TEST(TextTable, AlignsNumbersToTheRightAndWordsToTheLeft) {
  TextTable table({"arm", "ms"});
  table.AddRow({"SAP", "1.25"});
  table.AddRow({"AxisSweep", "10.50"});
  std::ostringstream out;
  table.Print(out);
  EXPECT_EQ(out.str(), "arm           ms\nSAP         1.25\nAxisSweep  10.50\n");
}

TEST(TextTable, SetsATitleApartWithoutWideningAColumn) {
  TextTable table({"arm", "ms"});
  table.AddTitle("a long title");
  table.AddRow({"SAP", "1.25"});
  std::ostringstream out;
  table.Print(out);
  EXPECT_EQ(out.str(), "arm    ms\n\na long title\nSAP  1.25\n");
}

}  // namespace
}  // namespace sweepstake::cli
