// Tests the paper's Tables 3 and 4 with the real decision core and a few fixed seeds.
#include "tests/bench/paper_check/paper_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tests/bench/paper_check/paper_check_output.h"

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

constexpr uint32_t kAxisSweep = 3;
constexpr PaperCosts kClear{.detection_ms = 1, .gap_ms = 4};
const auto kSilent = [](uint64_t) {};

const PaperCell& Cell(std::string_view scene, uint32_t object_count) {
  return *FindPaperCell(scene, object_count);
}

TEST(PaperGame, DependsOnTheSeedOnly) {
  const PaperGame one = PlayPaperGame({}, kClear, kAxisSweep, 3);
  const PaperGame two = PlayPaperGame({}, kClear, kAxisSweep, 3);
  EXPECT_EQ(one.evidence, two.evidence);
  EXPECT_EQ(one.posterior_mean, two.posterior_mean);
  EXPECT_NE(one.evidence, PlayPaperGame({}, kClear, kAxisSweep, 4).evidence);
}

TEST(PaperGame, ObservesOncePer2SecondsOfActiveTimeWithoutSettling) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const PaperGame game = PlayPaperGame({}, {.detection_ms = 1}, kAxisSweep, seed);
    const double active_s = game.active_percent * 9;
    // n* is the sum of the prior, the exploration's windows and one window per two seconds of
    // active time. Each activation of the arm costs up to two windows.
    EXPECT_LE(game.evidence, 2 + 2 + active_s / 2 + 1);
    EXPECT_GE(game.evidence,
              2 + 1 + active_s / 2 - 2 * static_cast<double>(game.switch_count / 2 + 1));
    // A cooldown of 40 s begins at a frame between two ticks, so it ends only at the 21st tick.
    EXPECT_LE(game.switch_count, 22U);
  }
}

TEST(PaperGame, ContinuesAWindowUntilItHasEnoughSamples) {
  // 10 FPS give 20 samples in each interval.
  const PaperCosts slow{.detection_ms = 88, .gap_ms = 40};
  const PaperGame each = PlayPaperGame({}, slow, kAxisSweep, 1);
  const PaperGame enough =
      PlayPaperGame({.policy = "paper", .min_sample_count = 10}, slow, kAxisSweep, 1);
  EXPECT_EQ(enough.evidence, each.evidence);
  EXPECT_EQ(enough.switch_count, each.switch_count);
  const PaperGame waiting =
      PlayPaperGame({.policy = "paper", .min_sample_count = 50}, slow, kAxisSweep, 1);
  EXPECT_LT(waiting.evidence / waiting.active_percent, 0.5 * each.evidence / each.active_percent);
}

TEST(PaperGame, AFrameOverTheLimitIsABailOut) {
  // All other arms exceed the bail-out limit. After the first frame of the fast arm, no other arm
  // is chosen.
  const PaperGame game = PlayPaperGame({}, {.detection_ms = 1, .gap_ms = 5'500}, kAxisSweep, 1);
  EXPECT_EQ(game.dominant_arm, kAxisSweep);
  EXPECT_GT(game.active_percent, 90);
}

TEST(PaperGame, RandomPrefersNoArm) {
  uint32_t dominated = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const PaperGame game = PlayPaperGame({.policy = "random"}, kClear, kAxisSweep, seed);
    dominated += game.dominant_arm == kAxisSweep ? 1 : 0;
    EXPECT_LE(game.switch_count, 22U);
  }
  EXPECT_LT(dominated, 10U);
}

std::vector<PaperGame> ThreeGames() {
  return {{.switch_count = 4,
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
}

TEST(PaperCheck, AggregatesRunsLikeThePapersTables) {
  const auto figures = CompareWithPaper(Cell("hurricane", 2000), ThreeGames());
  EXPECT_DOUBLE_EQ(figures[kDominance].ours.mean, 2.0 / 3);
  EXPECT_DOUBLE_EQ(figures[kDominance].paper.mean, 1);
  EXPECT_DOUBLE_EQ(figures[kSwitches].ours.mean, 10);
  EXPECT_DOUBLE_EQ(figures[kActive].ours.mean, 85);
  EXPECT_DOUBLE_EQ(figures[kPosteriorMean].ours.mean, 0.85);
  EXPECT_DOUBLE_EQ(figures[kEvidence].ours.mean, 350);
  EXPECT_TRUE(figures[kActive].is_fitted && figures[kPosteriorMean].is_fitted);
  EXPECT_FALSE(figures[kSwitches].is_fitted || figures[kEvidence].is_fitted);
}

TEST(PaperCheck, UsesTheStandardErrorOfThePapersNumberOfRuns) {
  const std::vector<PaperGame> games = ThreeGames();
  const auto all = CompareWithPaper(Cell("hurricane", 2000), games);
  // The variance is the mean of ours (52, of 4, 8 and 18 switches) and the paper's (1.7²).
  const double error = std::sqrt((52.0 + 1.7 * 1.7) / 2 / 5);
  EXPECT_NEAR(all[kSwitches].standard_errors, (10 - 6.6) / error, 1e-12);
  EXPECT_TRUE(all[kSwitches].is_close());
  // KDTree dominated 3 of 5 runs in the paper, and dominates one of the two runs in `two`.
  const std::vector<PaperGame> two = {{.dominant_arm = 6, .evidence = 190},
                                      {.dominant_arm = 6, .evidence = 210}};
  const auto some = CompareWithPaper(Cell("brownian", 3000), two);
  EXPECT_NEAR(some[kEvidence].standard_errors, (200 - 203) / std::sqrt((200 + 35.5 * 35.5) / 2 / 3),
              1e-12);
  // Our dominance is 1 of 2. Its variance is computed with one more run of each kind.
  EXPECT_NEAR(some[kDominance].standard_errors, 0.4 / std::sqrt((0.25 * 4 - 0.25) / 3 / 5), 1e-12);
}

TEST(PaperCheck, ACellWhoseArmNeverDominatesHasInfiniteDistance) {
  const PaperGame game{.switch_count = 7, .dominant_arm = 0};
  const auto figures = CompareWithPaper(Cell("hurricane", 2000), {&game, 1});
  EXPECT_TRUE(std::isnan(figures[kEvidence].ours.mean));
  EXPECT_FALSE(figures[kEvidence].is_close());
}

TEST(PaperCheck, FitsTwoFiguresAndPredictsTheOthers) {
  const std::vector<PaperRules> rules = {{.policy = "paper"}};
  const std::vector<PaperCell> cells = {Cell("hurricane", 2000)};
  const auto predictions = CheckPaper(rules, cells, {.seed_count = 24, .thread_count = 2}, kSilent);
  for (const PaperResidual& figure : predictions[0].figures)
    EXPECT_TRUE(figure.is_close()) << figure.name << ' ' << figure.standard_errors;
}

TEST(PaperCheck, OrdersItsPredictionsByRulesAndThenByCells) {
  const std::vector<PaperRules> rules = {{.policy = "random"}, {.policy = "paper"}};
  const std::vector<PaperCell> cells = {Cell("hurricane", 2000), Cell("brownian", 3000)};
  const auto predictions = CheckPaper(rules, cells, {.seed_count = 1, .thread_count = 2}, kSilent);
  ASSERT_EQ(predictions.size(), 4U);
  for (size_t i = 0; i < predictions.size(); ++i) {
    EXPECT_EQ(predictions[i].rules, rules[i / 2]);
    EXPECT_EQ(predictions[i].cell.scene, cells[i % 2].scene);
  }
}

TEST(PaperCheck, DoesNotDependOnTheNumberOfThreads) {
  const std::vector<PaperRules> rules = {{.policy = "paper"}, {.policy = "random"}};
  const std::vector<PaperCell> cells = {Cell("brownian", 2000)};
  const auto one = CheckPaper(rules, cells, {.seed_count = 1, .thread_count = 1}, kSilent);
  const auto four = CheckPaper(rules, cells, {.seed_count = 1, .thread_count = 4}, kSilent);
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].costs, four[i].costs);
    EXPECT_EQ(one[i].figures[kSwitches].ours.mean, four[i].figures[kSwitches].ours.mean);
  }
}

TEST(PaperCheck, ReportsTheSecondsPerObservation) {
  EXPECT_NEAR(SecondsPerObservation(Cell("brownian", 1000)), 2.0, 0.05);
  EXPECT_NEAR(SecondsPerObservation(Cell("rotating-gravity", 2000)), 3.3, 0.05);
  EXPECT_NEAR(SecondsPerObservation(Cell("rotating-gravity", 3000)), 6.6, 0.1);
}

PaperPrediction PredictionOf(const PaperRules& rules, double errors) {
  PaperPrediction prediction{
      .rules = rules,
      .cell = Cell("rotating-gravity", 2000),
      .costs = kClear,
      .figures = CompareWithPaper(Cell("rotating-gravity", 2000), ThreeGames())};
  for (PaperResidual& figure : prediction.figures) figure.standard_errors = errors;
  return prediction;
}

TEST(PaperScore, CountsCloseFiguresAndLimitsLargeDistances) {
  const PaperScore close = ScoreOf(std::vector{PredictionOf({}, -2)});
  EXPECT_EQ(close.close_count, 3U);
  EXPECT_EQ(close.figure_count, 3U);
  EXPECT_DOUBLE_EQ(close.distance, 2);
  const PaperScore distant = ScoreOf(std::vector{PredictionOf({}, 2.1), PredictionOf({}, 1e9)});
  EXPECT_EQ(distant.close_count, 0U);
  EXPECT_NEAR(distant.distance, std::sqrt((2.1 * 2.1 + 100) / 2), 1e-12);
}

TEST(PaperCheckOutput, NamesMissedFiguresAndTheBestMinimumNumberOfSamples) {
  std::vector<PaperPrediction> predictions;
  for (const PaperRules& rules : PaperRulesToCheck()) {
    const double errors = rules.policy == "random" ? 9 : rules.min_sample_count == 20 ? 1 : 4;
    predictions.push_back(PredictionOf(rules, errors));
  }
  const PaperReport report = ReportOf(predictions);
  std::ostringstream text;
  PrintPaperCheckTable(report, {.seed_count = 3}, text);
  EXPECT_THAT(text.str(),
              HasSubstr("rotating-gravity 2000 evidence: 350.0, the paper's 164.4 (4.0); at least "
                        "20 samples: 350.0 (1.0); the paper's has one observation per 3.3 s"));
  EXPECT_THAT(text.str(), HasSubstr("paper 0 of 3, random 0 of 3; distance 4.00 and 9.00"));
  std::ostringstream document;
  PrintPaperCheckJson(report, {.seed_count = 3}, document);
  const auto json = nlohmann::json::parse(document.str());
  EXPECT_EQ(json["best_min_samples"], 20);
  EXPECT_EQ(json["scores"][1]["policy"], "random");
  EXPECT_EQ(json["rows"].size(), PaperRulesToCheck().size());
  EXPECT_EQ(json["rows"][0]["switches"]["paper_mean"], 9.8);
  EXPECT_EQ(json["rows"][0]["evidence"]["standard_errors"], 4);
}

}  // namespace
}  // namespace sweepstake::cli
