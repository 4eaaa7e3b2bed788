#include "tests/laboratory/trace/cost_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using std::filesystem::path;
using testing::HasSubstr;

// Returns a trace with two arms, ten frames, a burst and a descriptor. All numbers differ.
CostTrace SmallTrace() {
  CostTrace trace;
  trace.scene = "suite-b";
  trace.seed = std::numeric_limits<uint64_t>::max();
  trace.machine = "linux-x86_64-2";
  trace.arms = {{"SAP", 3}, {"KDTree", 1}};
  trace.frame_count = 10;
  trace.repeat_count = 5;
  trace.control_arm = 1;
  trace.burst_frame_count = 4;
  for (uint32_t frame = 0; frame < trace.frame_count; ++frame) {
    trace.object_count.push_back(100 + frame);
    trace.pair_count.push_back(200 + frame);
    trace.step_ns.push_back(300 + frame);
    trace.control_ns.push_back(kMaxTracedNs - frame);
    for (uint32_t arm = 0; arm < 2; ++arm) {
      trace.detection_ns.push_back(1 + 2 * frame + arm);
      trace.aabb_check_count.push_back(5000 + 2 * frame + arm);
      trace.native_bytes.push_back((uint64_t{1} << 40) + 2 * frame + arm);
      trace.held.push_back(arm == 0 && frame % 3 == 1 ? 1 : 0);
    }
  }
  trace.bursts = {{2, {9, 8, 7, 6, 5, 4, 3, 2}}, {6, {19, 18, 17, 16, 15, 14, 13, 12}}};
  trace.descriptors = {{5, {.object_count = 105, .density_ratio = 0.5F, .static_ratio = 0}},
                       {10, SceneDescriptor{}}};
  return trace;
}

class CostsFile : public testing::Test {
 protected:
  path Place() const { return folder_.path() / "scene.costs"; }
  std::string Bytes(const CostTrace& trace) {
    EXPECT_TRUE(WriteCosts(Place(), trace).ok());
    return test_support::FileText(Place());
  }
  void ExpectBroken(const std::string& bytes, const std::string& said) {
    std::ofstream(Place(), std::ios::binary | std::ios::trunc) << bytes;
    const Status status = ReadCosts(Place()).status();
    ASSERT_EQ(status.code(), StatusCode::kDataLoss) << said;
    EXPECT_THAT(status.message(), HasSubstr(Place().string() + " is not a valid cost trace: "));
    EXPECT_THAT(status.message(), HasSubstr(said));
  }

 private:
  test_support::TemporaryDirectory folder_;
};

TEST_F(CostsFile, GivesBackEveryNumberThatWasWritten) {
  const CostTrace written = SmallTrace();
  const std::string bytes = Bytes(written);
  const auto read = ReadCosts(Place());
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->seed, written.seed);
  EXPECT_EQ(read->arms[0].name, "SAP");
  EXPECT_EQ(read->detection(3, 1), 8U);
  EXPECT_EQ(read->bursts[1].detection_ns, written.bursts[1].detection_ns);
  EXPECT_EQ(read->descriptors[0].descriptor.density_ratio, 0.5F);
  EXPECT_LT(read->descriptors[1].descriptor.object_count, 0) << "was not measured";
  EXPECT_EQ(Bytes(*read), bytes);
}

TEST_F(CostsFile, ReportsAMissingFileAndAFolder) {
  EXPECT_EQ(ReadCosts("/tmp").status().code(), StatusCode::kNotFound);
  const Status status = ReadCosts("/nonexistent/x.costs").status();
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), HasSubstr("/nonexistent/x.costs; `sweepstake-lab trace` makes"));
  EXPECT_EQ(WriteCosts("/nonexistent/x.costs", SmallTrace()).code(), StatusCode::kInvalidArgument);
}

TEST_F(CostsFile, RejectsEveryShorterFileAndALongerOne) {
  const std::string bytes = Bytes(SmallTrace());
  for (size_t size = 0; size < bytes.size(); ++size) ExpectBroken(bytes.substr(0, size), "");
  ExpectBroken(bytes + "x", "");
}

TEST_F(CostsFile, RejectsAnotherFormatAndAnInvalidTrace) {
  nlohmann::json document = nlohmann::json::from_cbor(Bytes(SmallTrace()));
  const auto broken = [&](const std::string& said) {
    const std::vector<uint8_t> bytes = nlohmann::json::to_cbor(document);
    ExpectBroken({bytes.begin(), bytes.end()}, said);
  };
  document["trace"]["held"][4] = 2;
  broken("held");
  document["trace"].erase("held");
  broken("held");
  document["version"] = 1;
  broken("its format or version is not supported");
}

TEST(CostTrace, IsInvalidIfANumberOrANameIsOutOfRange) {
  EXPECT_EQ(ErrorOf(SmallTrace()), "");
  constexpr uint32_t kHuge = std::numeric_limits<uint32_t>::max();
  void (*const changes[])(CostTrace&) = {
      [](CostTrace& t) { t.frame_count = kHuge; },
      [](CostTrace& t) { t.frame_count = 0; },
      [](CostTrace& t) { t.frame_count = 11; },
      [](CostTrace& t) { t.control_arm = 2; },
      [](CostTrace& t) { t.repeat_count = 0; },
      [](CostTrace& t) { t.burst_frame_count = kHuge; },
      [](CostTrace& t) { t.burst_frame_count = 5; },
      [](CostTrace& t) { t.arms.clear(); },
      [](CostTrace& t) { t.bursts.clear(); },
      [](CostTrace& t) { t.object_count.pop_back(); },
      [](CostTrace& t) { t.pair_count.pop_back(); },
      [](CostTrace& t) { t.step_ns.pop_back(); },
      [](CostTrace& t) { t.detection_ns.pop_back(); },
      [](CostTrace& t) { t.aabb_check_count.pop_back(); },
      [](CostTrace& t) { t.native_bytes.push_back(1); },
      [](CostTrace& t) { t.held = {1}; },
      [](CostTrace& t) { t.held[4] = 2; },
      [](CostTrace& t) { t.detection_ns[3] = 0; },
      [](CostTrace& t) { t.control_ns[3] = kMaxTracedNs + 1; },
      [](CostTrace& t) { t.arms[1].name = "SAP"; },
      [](CostTrace& t) { t.arms[1].name = "\x1b[2J"; },
      [](CostTrace& t) { t.scene = "a\nb"; },
      [](CostTrace& t) { t.machine = std::string(1001, 'x'); },
      [](CostTrace& t) { t.bursts[1].first_frame = 2; },
      [](CostTrace& t) { t.bursts[1].first_frame = 7; },
      [](CostTrace& t) { t.bursts[0].detection_ns[0] = 0; },
      [](CostTrace& t) { t.descriptors[0].frame = 11; },
      [](CostTrace& t) {
        t.descriptors[0].descriptor.speed_mean = std::numeric_limits<float>::infinity();
      },
  };
  for (size_t i = 0; i < std::size(changes); ++i) {
    CostTrace trace = SmallTrace();
    changes[i](trace);
    EXPECT_NE(ErrorOf(trace), "") << "change " << i;
  }
}

}  // namespace
}  // namespace sweepstake::cli
