// The paper's Table 4 against the real decision core, with few seeds that stay the same.
#include "tests/bench/paper_check/paper_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tests/bench/paper_check/paper_check_output.h"
#include "tests/bench/paper_check/paper_fit.h"

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

constexpr PaperCheckOptions kMany{.seed_count = 30, .thread_count = 2};
constexpr PaperCheckOptions kFew{.seed_count = 8, .thread_count = 2};
const auto kSilent = [](uint64_t) {};

const PaperCell& Cell(std::string_view scene, uint32_t object_count) {
  return *FindPaperCell(scene, object_count);
}

PaperCheckRow Check(const PaperCell& cell, const PaperCellFit& fit) {
  return CheckPaper({&cell, 1}, {&fit, 1}, kFew, kSilent)[0];
}

PaperCellFit FitOf(size_t cell) { return PaperFits()[cell]; }

TEST(PaperGame, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const PaperCellFit fit = FitOf(0);
  const PaperGame one = PlayPaperGame(fit, 3);
  const PaperGame two = PlayPaperGame(fit, 3);
  EXPECT_EQ(one.evidence, two.evidence);
  EXPECT_EQ(one.posterior_mean, two.posterior_mean);
  EXPECT_NE(one.evidence, PlayPaperGame(fit, 4).evidence);
}

TEST(PaperGame, ObservesOnceIn2SecondsOfActiveTimeButForTheSettling) {
  PaperCellFit fit{.arms = {}};
  fit.arms.fill({10, 1, 0.01});
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const PaperGame game = PlayPaperGame(fit, seed);
    const double active_s = game.active_percent * 9;
    // The prior, the exploration's windows, and a window less for each of the arm's activations.
    EXPECT_LE(game.evidence, 2 + 2 + active_s / 2 + 1);
    EXPECT_GE(game.evidence,
              2 + 1 + active_s / 2 - 2 * static_cast<double>(game.switch_count / 2 + 1));
    // A cooldown of 40 s that begins at a frame ends at the 21st tick.
    EXPECT_LE(game.switch_count, 22U);
  }
}

TEST(PaperGame, StallsTakeTimeAndTeachNothing) {
  PaperCellFit fit = FitOf(1);
  const PaperGame without = PlayPaperGame(fit, 1);
  fit.stall_ratio = 0.5;
  const PaperGame with = PlayPaperGame(fit, 1);
  EXPECT_LT(with.evidence / with.active_percent, 0.7 * without.evidence / without.active_percent);
}

TEST(PaperCheck, EveryCellOfTheTableMatchesWithItsFit) {
  for (const PaperCheckRow& row : CheckPaper(PaperCells(), PaperFits(), kMany, kSilent)) {
    EXPECT_TRUE(row.matches()) << row.cell.scene << ' ' << row.cell.object_count;
    EXPECT_GT(row.dominance_ratio, 0.4) << row.cell.scene << ' ' << row.cell.object_count;
  }
}

TEST(PaperCheck, OnlyTheCellsBelowTheStallLoseTime) {
  for (size_t cell = 0; cell < PaperCells().size(); ++cell) {
    const bool stalled = SecondsPerUpdate(PaperCells()[cell]) > 3;
    EXPECT_EQ(PaperFits()[cell].stall_ratio > 0, stalled) << cell;
  }
}

TEST(PaperCheck, AnotherCellsFitDoesNotMatch) {
  EXPECT_FALSE(Check(Cell("brownian", 1000), FitOf(7)).matches());
  EXPECT_FALSE(Check(Cell("hurricane", 2000), FitOf(0)).matches());
}

TEST(PaperCheck, EachFigureFailsForItself) {
  PaperCellFit fit = FitOf(7);
  for (PaperArmFit& arm : fit.arms) arm.detection_ms += 3;
  const PaperCheckRow slower = Check(Cell("hurricane", 2000), fit);
  EXPECT_FALSE(slower.figures[2].is_in);
  fit = FitOf(4);
  fit.stall_ratio = 0;
  const PaperCheckRow unstalled = Check(Cell("rotating-gravity", 2000), fit);
  EXPECT_FALSE(unstalled.figures[3].is_in);
}

TEST(PaperCheck, AggregatesAsTheTableDoes) {
  const PaperCell& cell = Cell("hurricane", 2000);
  const std::vector<PaperGame> games = {{.switch_count = 4,
                                         .dominant_arm = 3,
                                         .active_percent = 80,
                                         .posterior_mean = 0.9,
                                         .evidence = 300},
                                        {.switch_count = 8,
                                         .dominant_arm = 3,
                                         .active_percent = 90,
                                         .posterior_mean = 0.8,
                                         .evidence = 400},
                                        {.switch_count = 18,
                                         .dominant_arm = 6,
                                         .active_percent = 40,
                                         .posterior_mean = 0.1,
                                         .evidence = 100}};
  const PaperCheckRow row = JudgePaperGames(cell, {}, games);
  EXPECT_DOUBLE_EQ(row.figures[0].mean, 10);
  EXPECT_DOUBLE_EQ(row.figures[1].mean, 85);
  EXPECT_DOUBLE_EQ(row.figures[2].mean, 0.85);
  EXPECT_DOUBLE_EQ(row.figures[3].mean, 350);
  EXPECT_DOUBLE_EQ(row.dominance_ratio, 2.0 / 3);
  EXPECT_FALSE(row.matches());
  EXPECT_NEAR(row.figures[0].allowed.low, 6.6 - 3.4, 1e-9);
}

TEST(PaperCheck, ACellWhoseArmNeverDominatesDoesNotMatch) {
  const PaperGame game{.switch_count = 7, .dominant_arm = 0};
  EXPECT_FALSE(JudgePaperGames(Cell("hurricane", 2000), {}, {&game, 1}).matches());
}

TEST(PaperCheck, SaysHowLongAnObservationTook) {
  EXPECT_NEAR(SecondsPerUpdate(Cell("brownian", 1000)), 2.0, 0.05);
  EXPECT_NEAR(SecondsPerUpdate(Cell("rotating-gravity", 2000)), 3.3, 0.05);
  EXPECT_GT(SecondsPerUpdate(Cell("rotating-gravity", 3000)), kLongestFrameS);
  EXPECT_LT(MeanRewardBound(Cell("rotating-gravity", 2000)), 0.807 - 0.113);
}

TEST(PaperCheck, DoesNotDependOnTheNumberOfThreads) {
  const PaperCell& cell = Cell("brownian", 2000);
  const PaperCellFit fit = FitOf(1);
  const auto one = CheckPaper({&cell, 1}, {&fit, 1}, {.seed_count = 5, .thread_count = 1}, kSilent);
  const auto four =
      CheckPaper({&cell, 1}, {&fit, 1}, {.seed_count = 5, .thread_count = 4}, kSilent);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(one[0].figures[i].mean, four[0].figures[i].mean);
}

TEST(PaperFit, TheSecondArmIsTableThrees) {
  const PaperFitPoint point{.detection_ms = 1, .gap_ms = 5, .second_gap_ms = 2};
  const PaperCellFit mixed = ExpandFit(Cell("rotating-gravity", 1000), point);
  EXPECT_EQ(mixed.arms[2].detection_ms, 1);  // SAP
  EXPECT_EQ(mixed.arms[3].detection_ms, 3);  // AxisSweep
  EXPECT_EQ(mixed.arms[6].detection_ms, 6);
  EXPECT_EQ(mixed.arms[6].frame_ms, 18);
  const PaperCellFit clear = ExpandFit(Cell("brownian", 1000), point);
  EXPECT_EQ(clear.arms[3].detection_ms, 1);
  EXPECT_EQ(clear.arms[2].detection_ms, 6);
}

TEST(PaperFit, IsFoundAnewTheSame) {
  const PaperCell& cell = Cell("brownian", 2000);
  int tries = 0;
  const auto find = [&] {
    return ExpandFit(cell, FindFit(cell, {.seed_count = 3, .thread_count = 2}, [&] { ++tries; }));
  };
  const PaperCellFit fit = find();
  const int first_tries = tries;
  EXPECT_EQ(find(), fit);
  EXPECT_EQ(tries, 2 * first_tries);
  EXPECT_LT(FitLoss(Check(cell, fit)), 1);
}

TEST(PaperCheckOutput, NamesWhatIsOutAndWhyTimeWasLost) {
  const std::vector<PaperCell> cells = {Cell("brownian", 1000), Cell("rotating-gravity", 2000)};
  const std::vector<PaperCellFit> fits = {FitOf(7), FitOf(4)};
  const PaperCheckOptions options{.seed_count = 5};
  const auto rows = CheckPaper(cells, fits, options, kSilent);
  std::ostringstream text;
  PrintPaperCheckTable(rows, options, text);
  EXPECT_THAT(text.str(), HasSubstr("OUT: brownian 1000."));
  EXPECT_THAT(text.str(), HasSubstr("rotating-gravity 2000: n* has one observation per 3.3 s"));
  std::ostringstream document;
  PrintPaperCheckJson(rows, options, document);
  const auto json = nlohmann::json::parse(document.str());
  EXPECT_FALSE(json["matches"].get<bool>());
  EXPECT_EQ(json["rows"][0]["switches"]["paper_mean"], 20.2);
  EXPECT_FALSE(json["rows"][0]["switches"]["in"].get<bool>());
  EXPECT_EQ(json["rows"][1]["fit"]["arms"].size(), 7U);
}

}  // namespace
}  // namespace sweepstake::cli
