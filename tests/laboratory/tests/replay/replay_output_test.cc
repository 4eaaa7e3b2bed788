// Tests the outputs of `sweepstake-lab replay` for a study with synthetic numbers.
#include "tests/laboratory/replay/replay_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/laboratory/tests/replay/replay_fixtures.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class ReplayOutput : public testing::Test {
 protected:
  ReplayOutput() {
    scenes_.push_back({"a.costs", SceneOf(TwiceAsSlow(), {.pass_ns = 60'000'000'000})});
    options_.players =
        *ReplayPlayers(std::vector<std::string>{"paper", "oracle"}, scenes_[0].scene.arms());
    options_.seed_count = 2;
    rows_ = {PaperRow(), OracleRow()};
  }

  static StudyRow PaperRow() {
    StudyRow row;
    row.games = {{.regret_best_fixed = 0.5}, {.regret_best_fixed = 0.25}};
    row.regret_best_fixed = 0.375;
    row.ci95 = {0.25, 0.5};
    row.regret_after_start_up = -0.00001;
    row.headroom = 0.1;
    row.headroom_captured = -3.75;
    row.switches = 1.5;
    row.active_share = 0.75;
    row.bail_outs = 0.5;
    row.verdict_shares = {0, 0.25, 0.75, 0, 0};
    row.first_best_s = 12.5;
    row.first_right = 0.5;
    row.opening_regret = 0.25;
    row.against_paper = PairedComparison{};
    row.ms = {.detection = 0.75, .best = 0.5, .median = 1, .worst = 2, .lane = 0.0625};
    row.paper_ms = 0.75;
    row.reliability.Add(0.85, 0);
    row.reliability.Add(0.875, 0.004);
    row.reliability.Add(0.825, 0.1);
    row.reliability.Add(1, 0);
    return row;
  }
  static StudyRow OracleRow() {
    StudyRow row;
    row.player = 1;
    row.dominant_arm = 1;
    row.games.resize(2);
    return row;
  }

  ReplayReport Report() const { return {scenes_, options_, rows_}; }
  json Document() const {
    std::ostringstream text;
    PrintReplayJson(Report(), text);
    return json::parse(text.str());
  }
  std::string Table() const {
    std::ostringstream text;
    PrintReplayTable(Report(), text);
    return text.str();
  }

  std::vector<StudyScene> scenes_;
  StudyOptions options_;
  std::vector<StudyRow> rows_;
};

TEST_F(ReplayOutput, JsonHasARowForEachSceneAndPlayer) {
  const json document = Document();
  ASSERT_EQ(document["rows"].size(), 2U);
  const json& row = document["rows"][0];
  EXPECT_EQ(row["costs"], "a.costs");
  EXPECT_EQ(row["policy"], "paper");
  EXPECT_EQ(row["priors"], "none");
  EXPECT_EQ(row["pass_ns"], 60'000'000'000);
  EXPECT_EQ(row["regret_best_fixed"], 0.375);
  EXPECT_EQ(row["regrets"], json({0.5, 0.25}));
  EXPECT_EQ(row["ci95"], json({0.25, 0.5}));
  EXPECT_EQ(row["headroom_captured"], -3.75);
  EXPECT_EQ(row["dominant"], "AxisSweep");
  EXPECT_EQ(row["verdicts"]["tie"], 0.75);
  EXPECT_EQ(row["against_paper"]["wilcoxon_p"], 1);
  EXPECT_EQ(row["seeds"], 2);
  EXPECT_EQ(row["first_right"], 0.5);
  EXPECT_EQ(row["regret_first_10_s"], 0.25);
}

TEST_F(ReplayOutput, JsonSaysNullWhereThereIsNothing) {
  const json oracle = Document()["rows"][1];
  EXPECT_TRUE(oracle["bail_outs"].is_null());
  EXPECT_TRUE(oracle["headroom_captured"].is_null());
  EXPECT_TRUE(oracle["regret_after_start"].is_null());
  EXPECT_TRUE(oracle["regret_after_start_ci95"].is_null());
  EXPECT_TRUE(oracle["first_best_s"].is_null());
  EXPECT_TRUE(oracle["first_right"].is_null());
  EXPECT_TRUE(oracle["regret_first_10_s"].is_null());
  EXPECT_TRUE(oracle["verdicts"].empty());
  EXPECT_FALSE(oracle.contains("against_paper"));
  EXPECT_EQ(oracle["dominant"], "KDTree");
}

TEST_F(ReplayOutput, JsonDescribesTheGameOfEachScene) {
  const json scene = Document()["scenes"][0];
  EXPECT_EQ(scene["arms"], json({"AxisSweep", "KDTree"}));
  EXPECT_EQ(scene["frames"], 90'000);
  EXPECT_EQ(scene["trace_frames"], 64);
  EXPECT_EQ(scene["run_ns"], 900'000'000'000);
  EXPECT_EQ(scene["control_regret"], 0);
}

TEST_F(ReplayOutput, JsonNamesThePriors) {
  options_.priors = ReplayPriors::kWrong;
  EXPECT_EQ(Document()["rows"][0]["priors"], "wrong");
}

TEST_F(ReplayOutput, TheTableShowsRatiosInPercentAndNoNegativeZero) {
  const std::string table = Table();
  EXPECT_THAT(table, HasSubstr("a.costs: noise floor +0.00%, headroom +10.00% including switches"));
  EXPECT_THAT(table, HasSubstr("+37.50%"));
  EXPECT_THAT(table, HasSubstr("+25.00% to +50.00%"));
  EXPECT_THAT(table, HasSubstr("-375%"));
  EXPECT_THAT(table, Not(HasSubstr("-0.00%")));
  EXPECT_THAT(table, HasSubstr("mean of\n2 seeds"));
}

TEST_F(ReplayOutput, RegretIsAlsoAShareOfDetectionAndOfAFrameAndInMilliseconds) {
  const json document = Document();
  const json& row = document["rows"][0];
  EXPECT_EQ(row["regret_detection"], 0.5);
  EXPECT_DOUBLE_EQ(row["regret_60hz"], 0.25 * 60 / 1000);
  EXPECT_EQ(row["ms_per_frame"], json::parse(R"({"detection": 0.75, "best": 0.5, "median": 1.0,
      "worst": 2.0, "paper": 0.75, "regret": 0.25, "lane": 0.0625})"));
  EXPECT_TRUE(document["rows"][1]["ms_per_frame"]["paper"].is_null());
  EXPECT_EQ(document["scenes"][0]["objects"], 1000);
}

TEST_F(ReplayOutput, ProbabilitiesAreComparedWithHowOftenTheyAreRight) {
  const json document = Document();
  const json& bins = document["rows"][0]["reliability"];
  ASSERT_EQ(bins.size(), 2U);
  EXPECT_EQ(bins[0]["low"], 0.8);
  EXPECT_EQ(bins[0]["high"], 0.9);
  EXPECT_EQ(bins[0]["decisions"], 3);
  EXPECT_DOUBLE_EQ(bins[0]["predicted"], 0.85);
  EXPECT_DOUBLE_EQ(bins[0]["best"], 1.0 / 3);
  EXPECT_DOUBLE_EQ(bins[0]["best_or_tie"], 2.0 / 3);
  EXPECT_EQ(bins[1]["high"], 1);
  EXPECT_TRUE(document["rows"][1]["reliability"].empty());
  ASSERT_EQ(document["calibration"].size(), 1U);
  EXPECT_EQ(document["calibration"][0]["policy"], "paper");
  EXPECT_EQ(document["calibration"][0]["bins"], bins);
  EXPECT_NEAR(document["calibration"][0]["error"].get<double>(), 0.387, 0.001);
}

}  // namespace
}  // namespace sweepstake::cli
