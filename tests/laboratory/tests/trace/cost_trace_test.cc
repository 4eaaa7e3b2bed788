#include "tests/laboratory/trace/cost_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>

#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using std::filesystem::path;
using testing::HasSubstr;

// Two arms, ten frames, a burst and a descriptor; all numbers are different.
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

std::string Content(const path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class CostsFile : public testing::Test {
 protected:
  path Place() const { return folder_.path() / "scene.costs"; }
  std::string Bytes(const CostTrace& trace) {
    EXPECT_TRUE(WriteCosts(Place(), trace).ok());
    return Content(Place());
  }
  Status ReadOf(const std::string& bytes) {
    std::ofstream(Place(), std::ios::binary | std::ios::trunc) << bytes;
    return ReadCosts(Place()).status();
  }
  void ExpectBroken(const std::string& bytes, const std::string& said) {
    const Status status = ReadOf(bytes);
    EXPECT_EQ(status.code(), StatusCode::kDataLoss) << said;
    EXPECT_THAT(status.message(), HasSubstr(Place().string()));
    EXPECT_THAT(status.message(), HasSubstr(said));
    EXPECT_THAT(status.message(), HasSubstr("sweepstake-lab trace"));
    EXPECT_EQ(status.message().find('\n'), std::string::npos);
  }
  static void ExpectError(const std::function<void(CostTrace&)>& change, const std::string& said) {
    CostTrace trace = SmallTrace();
    change(trace);
    EXPECT_THAT(ErrorOf(trace), HasSubstr(said));
  }

 private:
  test_support::TemporaryDirectory folder_;
};

TEST_F(CostsFile, GivesBackEveryNumberThatWasWritten) {
  const CostTrace written = SmallTrace();
  Bytes(written);
  const auto read = ReadCosts(Place());
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->scene, written.scene);
  EXPECT_EQ(read->seed, written.seed);
  EXPECT_EQ(read->machine, written.machine);
  ASSERT_EQ(read->arms.size(), 2U);
  EXPECT_EQ(read->arms[0].name, "SAP");
  EXPECT_EQ(read->arms[0].version, 3U);
  EXPECT_EQ(read->frame_count, written.frame_count);
  EXPECT_EQ(read->repeat_count, written.repeat_count);
  EXPECT_EQ(read->control_arm, written.control_arm);
  EXPECT_EQ(read->burst_frame_count, written.burst_frame_count);
  EXPECT_EQ(read->object_count, written.object_count);
  EXPECT_EQ(read->pair_count, written.pair_count);
  EXPECT_EQ(read->step_ns, written.step_ns);
  EXPECT_EQ(read->control_ns, written.control_ns);
  EXPECT_EQ(read->detection_ns, written.detection_ns);
  EXPECT_EQ(read->aabb_check_count, written.aabb_check_count);
  EXPECT_EQ(read->native_bytes, written.native_bytes);
  EXPECT_EQ(read->held, written.held);
  EXPECT_EQ(read->detection(3, 1), 8U);
}

TEST_F(CostsFile, GivesBackBurstsAndWhatWasMeasuredOfTheDescriptors) {
  Bytes(SmallTrace());
  const auto read = ReadCosts(Place());
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read->bursts.size(), 2U);
  EXPECT_EQ(read->bursts[1].first_frame, 6U);
  EXPECT_EQ(read->bursts[1].detection_ns, SmallTrace().bursts[1].detection_ns);
  ASSERT_EQ(read->descriptors.size(), 2U);
  EXPECT_EQ(read->descriptors[0].frame, 5U);
  EXPECT_EQ(read->descriptors[0].descriptor.density_ratio, 0.5F);
  EXPECT_EQ(read->descriptors[0].descriptor.static_ratio, 0);
  EXPECT_LT(read->descriptors[0].descriptor.speed_mean, 0) << "was not measured";
  EXPECT_LT(read->descriptors[1].descriptor.object_count, 0) << "was not measured";
}

TEST_F(CostsFile, IsTheSameBytesForTheSameTrace) {
  EXPECT_EQ(Bytes(SmallTrace()), Bytes(SmallTrace()));
}

TEST_F(CostsFile, RefusesAFileThatIsNotThereAndAFolder) {
  EXPECT_EQ(ReadCosts("/nonexistent/x.costs").status().code(), StatusCode::kNotFound);
  EXPECT_EQ(ReadCosts("/tmp").status().code(), StatusCode::kNotFound);
  EXPECT_THAT(ReadCosts("/nonexistent/x.costs").status().message(),
              HasSubstr("/nonexistent/x.costs"));
}

TEST_F(CostsFile, RefusesEveryShorterFileAndALongerOne) {
  const std::string bytes = Bytes(SmallTrace());
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_EQ(ReadOf(bytes.substr(0, size)).code(), StatusCode::kDataLoss) << size;
  }
  ExpectBroken(bytes.substr(0, bytes.size() - 1), "is truncated or has extra bytes");
  ExpectBroken(bytes + "x", "is truncated or has extra bytes");
  ExpectBroken("", "is not a cost trace");
}

TEST_F(CostsFile, RefusesAFileInWhichAnyByteWasFlipped) {
  const std::string bytes = Bytes(SmallTrace());
  for (size_t at = 0; at < bytes.size(); ++at) {
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    ASSERT_EQ(ReadOf(flipped).code(), StatusCode::kDataLoss) << at;
  }
  std::string last = bytes;
  last.back() = static_cast<char>(last.back() ^ 1);
  ExpectBroken(last, "its checksum does not match");
}

TEST_F(CostsFile, NamesAVersionThatItDoesNotRead) {
  std::string bytes = Bytes(SmallTrace());
  bytes[8] = 2;
  ExpectBroken(bytes, "has version 2, and this program reads 1");
}

TEST_F(CostsFile, RefusesAFileBeyondTheLargestWithoutReadingIt) {
  Bytes(SmallTrace());
  std::filesystem::resize_file(Place(),
                               kMaxCostsBytes + 1000);  // a sparse file
  const Status status = ReadCosts(Place()).status();
  EXPECT_EQ(status.code(), StatusCode::kDataLoss);
  EXPECT_THAT(status.message(), HasSubstr("exceeds the maximum size of a cost trace"));
}

TEST_F(CostsFile, RefusesCountsThatDoNotFitTheColumns) {
  constexpr uint32_t kHuge = std::numeric_limits<uint32_t>::max();
  ExpectError([](CostTrace& t) { t.frame_count = kHuge; }, "has 4294967295 frames");
  ExpectError([](CostTrace& t) { t.frame_count = 0; }, "has 0 frames");
  ExpectError([](CostTrace& t) { t.frame_count = 11; },
              "column object_count with the wrong length");
  ExpectError([](CostTrace& t) { t.control_arm = 2; }, "a control arm with an index out of range");
  ExpectError([](CostTrace& t) { t.repeat_count = 0; }, "was measured in 0 runs");
  ExpectError([](CostTrace& t) { t.burst_frame_count = kHuge; }, "has bursts of 4294967295");
  ExpectError([](CostTrace& t) { t.burst_frame_count = 5; }, "of a burst with the wrong length");
  ExpectError([](CostTrace& t) { t.arms.clear(); }, "has 0 arms");
  ExpectError([](CostTrace& t) { t.bursts.clear(); }, "has no burst");
  ExpectError([](CostTrace& t) { t.detection_ns.pop_back(); }, "column detection_ns");
  ExpectError([](CostTrace& t) { t.native_bytes.push_back(1); }, "column native_bytes");
  ExpectError([](CostTrace& t) { t.held = {1}; }, "column held with the wrong length");
}

TEST_F(CostsFile, RefusesNumbersAndNamesThatNoTraceHas) {
  ExpectError([](CostTrace& t) { t.detection_ns[3] = 0; }, "a time of nothing");
  ExpectError([](CostTrace& t) { t.control_ns[3] = kMaxTracedNs + 1; }, "more than an hour");
  ExpectError([](CostTrace& t) { t.held[4] = 2; }, "other values than 0 and 1");
  ExpectError([](CostTrace& t) { t.arms[1].name = "SAP"; }, "has the arm SAP twice");
  ExpectError([](CostTrace& t) { t.arms[1].name = "\x1b[2J"; }, "without a name");
  ExpectError([](CostTrace& t) { t.scene = "a\nb"; }, "name that is not one line");
  ExpectError([](CostTrace& t) { t.bursts[1].first_frame = 2; }, "burst out of order");
  ExpectError([](CostTrace& t) { t.bursts[1].first_frame = 7; }, "burst out of order");
  ExpectError([](CostTrace& t) { t.descriptors[0].frame = 11; }, "descriptor out of");
  ExpectError(
      [](CostTrace& t) {
        t.descriptors[0].descriptor.speed_mean = std::numeric_limits<float>::infinity();
      },
      "not finite");
}

TEST_F(CostsFile, RefusesAFlawedTraceInASoundFile) {
  CostTrace trace = SmallTrace();
  std::string bytes = Bytes(trace);
  // An empty payload, which is a message without frames, with the right size and checksum in the
  // header.
  bytes.resize(32);
  bytes.replace(16, 8, std::string(8, '\0'));
  const unsigned char fnv_of_nothing[] = {0x25, 0x23, 0x22, 0x84, 0xE4, 0x9C, 0xF2, 0xCB};
  bytes.replace(24, 8, std::string(std::begin(fnv_of_nothing), std::end(fnv_of_nothing)));
  ExpectBroken(bytes, "has 0 arms");
}

TEST_F(CostsFile, CannotBeWrittenWhereThereIsNoFolder) {
  const Status status = WriteCosts("/nonexistent/x.costs", SmallTrace());
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("/nonexistent/x.costs"));
}

}  // namespace
}  // namespace sweepstake::cli
