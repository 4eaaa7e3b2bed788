// Tests the outputs of `sweepstake-lab trace` for a trace with known numbers.
#include "tests/laboratory/trace/trace_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/laboratory/tests/trace/synthetic_trace.h"

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

// Returns a trace of 40 frames, in each of which SAP takes 1 ms and KDTree 2 ms.
CostTrace OneAndTwoMs() {
  SyntheticTrace synthetic;
  synthetic.arms = {"SAP", "KDTree"};
  synthetic.frame_count = 40;
  synthetic.detection_ns = [](uint32_t, uint32_t arm) { return (arm + 1) * uint64_t{1'000'000}; };
  return MakeTrace(synthetic);
}

TEST(TraceOutput, TheJsonRowHasTheTraceItsArmsAndTheControl) {
  const CostTrace trace = OneAndTwoMs();
  const auto row = TraceJson(trace, SummarizeTrace(trace), "traces/x.costs");
  EXPECT_EQ(row["scene"], "synthetic");
  EXPECT_EQ(row["file"], "traces/x.costs");
  EXPECT_EQ(row["frames"], 40);
  EXPECT_EQ(row["objects"], 1000);
  EXPECT_EQ(row["bursts"], 3);
  EXPECT_EQ(row["best_arm"], "SAP");
  ASSERT_EQ(row["arms"].size(), 2U);
  EXPECT_EQ(row["arms"][1]["arm"], "KDTree");
  EXPECT_DOUBLE_EQ(row["arms"][1]["ms_mean"].get<double>(), 2);
  EXPECT_EQ(row["arms"][0]["best_share"], 1);
  EXPECT_EQ(row["control"]["arm"], "SAP");
  EXPECT_EQ(row["control"]["ratio"], 1);
  EXPECT_TRUE(row["control"]["ci95"].is_null()) << "two windows that are equal have no width";
}

TEST(TraceOutput, TheTableNamesTheBestFixedArmAndTheControl) {
  const CostTrace trace = OneAndTwoMs();
  std::ostringstream text;
  PrintTrace(trace, SummarizeTrace(trace), "x.costs", text);
  EXPECT_THAT(text.str(),
              HasSubstr("x.costs: synthetic, 1000 objects, seed 0, 40 frames, 3 burst"));
  EXPECT_THAT(text.str(), HasSubstr("Best fixed arm: SAP."));
  EXPECT_THAT(text.str(), HasSubstr("a second SAP takes 1.0000 times as long as the first one"));
}

TEST(TraceOutput, FitsATerminalWithTheLongestNameAndShare) {
  SyntheticTrace synthetic;
  synthetic.arms = {"BruteForce", "KDTree"};
  synthetic.detection_ns = [](uint32_t frame, uint32_t arm) {
    return frame % 2 == arm ? uint64_t{1'000'000} : uint64_t{3'000'000};
  };
  const CostTrace trace = MakeTrace(synthetic);
  std::stringstream text;
  PrintTrace(trace, SummarizeTrace(trace), "x.costs", text);
  EXPECT_THAT(text.str(), HasSubstr("would save 50.0 % of its time"));
  for (std::string line; std::getline(text, line);) EXPECT_LE(line.size(), 80U) << line;
}

TEST(TraceOutput, WarnsOfAControlThatIsTooFarOffAndOfNoOther) {
  CostTrace trace = OneAndTwoMs();
  std::ostringstream fair;
  PrintControlWarning(trace, SummarizeTrace(trace), fair);
  EXPECT_EQ(fair.str(), "");
  for (uint64_t& ns : trace.control_ns) ns = 1'010'000;
  std::ostringstream unfair;
  PrintControlWarning(trace, SummarizeTrace(trace), unfair);
  EXPECT_THAT(unfair.str(), HasSubstr("two structures of SAP differ by 1.00 %, more than 0.5 %"));
}

}  // namespace
}  // namespace sweepstake::cli
