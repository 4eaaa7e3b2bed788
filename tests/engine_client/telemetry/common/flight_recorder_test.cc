#include "engine_client/telemetry/common/flight_recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/telemetry/common/sample_queue.h"
#include "engine_client/telemetry/common/validation.h"
#include "sweepstake/scene.h"
#include "tests/support/scripted_broad_phase.h"

namespace sweepstake {
namespace {

namespace fs = std::filesystem;
using test_support::ArmScript;
using test_support::ScriptedBroadPhase;
using test_support::ScriptedClock;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// A game with two arms, a flight recorder of 1 MiB and a budget of 50 ms.
class FlightRecorderTest : public ::testing::Test {
 protected:
  FlightRecorderTest() {
    const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("sweepstake_flight_") + test.name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    options_.project = "asteroids";
    options_.scene = "level \"3\"";
    options_.build = "1.2";
    options_.flight_recorder = {.memory_mb = 1, .directory = folder_.string()};
    recorder_ = std::make_shared<FlightRecorder>(options_);
    queue_ = std::make_unique<SampleQueue>(
        256, std::shared_ptr<FlightRing>(recorder_, &recorder_->ring()));
    std::vector<std::unique_ptr<BroadPhase>> backends;
    for (const char* name : {"Slow", "Fast"}) {
      ArmScript script;
      script.name = name;
      script.find_ns = 1'000'000;
      script.pair_count = 2;
      backends.push_back(std::make_unique<ScriptedBroadPhase>(script, clock_));
    }
    adaptive_ = std::move(*AdaptiveFactory::Make({}, std::move(backends), queue_.get(), clock_));
  }
  ~FlightRecorderTest() override { fs::remove_all(folder_); }

  void Frame(uint64_t frame_ms) {
    adaptive_->BeginFrame();
    adaptive_->FindPairs(boxes_);
    adaptive_->EndFrame({.frame_time_ns = frame_ms * 1'000'000});
    recorder_->Step(*adaptive_);
    for (Aabb& box : boxes_) box.max[1] += 1;
  }

  void Frames(int count) {
    for (int i = 0; i < count; ++i) Frame(10);
  }

  size_t FileCount() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  ScriptedClock clock_;
  fs::path folder_;
  SessionOptions options_;
  std::shared_ptr<FlightRecorder> recorder_;
  std::unique_ptr<SampleQueue> queue_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
  std::vector<Aabb> boxes_{{{0, 0, 0}, {1, 1, 1}}, {{2, 0, 0}, {3, 1, 1}}};
};

TEST_F(FlightRecorderTest, WritesBoxesFramesAndDecisionsOfFiveSeconds) {
  LastDecision decision{.decision_id = 6,
                        .time_ns = 1,
                        .outcome = DecisionOutcome::kKept,
                        .arm_count = 2,
                        .best_probability = {0.25, 0.75}};
  adaptive_->SetLastDecision(decision);
  Frames(600);
  decision.decision_id = 7;
  decision.time_ns = 2;
  decision.outcome = DecisionOutcome::kSwitched;
  decision.candidate_arm = 1;
  decision.command = SwitchCommand{3, 1, SwitchReason::kPolicy};
  adaptive_->SetLastDecision(decision);
  adaptive_->mailbox().Post(*decision.command);
  Frame(10);
  Frame(61);
  Frames(5);
  const std::vector<FlightRecording> recordings = recorder_->recordings();
  ASSERT_EQ(recordings.size(), 1U) << recorder_->error();
  EXPECT_EQ(recordings[0].worst_frame_ns, 61'000'000U);
  EXPECT_EQ(recordings[0].bytes, fs::file_size(recordings[0].path));
  EXPECT_THAT(fs::path(recordings[0].path).filename().string(), StartsWith("flight-"));

  const auto notes = nlohmann::json::parse(*RecordedNotes(recordings[0].path));
  EXPECT_EQ(notes["flight_recording"], 1);
  EXPECT_EQ(notes["project"], "asteroids");
  EXPECT_EQ(notes["scene"], options_.scene);
  EXPECT_EQ(notes["build"], "1.2");
  EXPECT_EQ(notes["worst_frame"], 601);
  EXPECT_EQ(notes["arms"], (nlohmann::json{"Slow", "Fast"}));
  EXPECT_EQ(notes["recorded_unix_ms"], recordings[0].recorded_unix_ms);
  // The recorder keeps five seconds: 494 frames of 10 ms and one of 61 ms.
  ASSERT_EQ(notes["frames"].size(), 495U);
  EXPECT_EQ(notes["frames"].back(),
            (nlohmann::json{601, 61'000'000, 1'000'000, 2, 2, 0, 0, 1, 1, 0, 494}));
  EXPECT_EQ(notes["frames"][0][7], 0);
  ASSERT_EQ(notes["decisions"].size(), 1U);  // The first decision is older.
  EXPECT_EQ(notes["decisions"][0]["frame"], 600);
  EXPECT_EQ(notes["decisions"][0]["outcome"], "switched");
  EXPECT_EQ(notes["decisions"][0]["commanded_arm"], 1);
  EXPECT_EQ(notes["decisions"][0]["reason"], "policy");
  EXPECT_EQ(notes["decisions"][0]["best_probability"], (nlohmann::json{0.25, 0.75}));

  const auto scene = std::move(*MakeScene(recordings[0].path, {}));
  EXPECT_EQ(scene->aabbs()[0], (Aabb{{0, 0, 0}, {1, 108, 1}}));  // box of frame 107
  for (int step = 0; step < 494; ++step) scene->Step();
  EXPECT_EQ(scene->aabbs()[1], (Aabb{{2, 0, 0}, {3, 602, 1}}));
  EXPECT_EQ(scene->world().max[1], 602);
}

TEST_F(FlightRecorderTest, WritesABoxThatIsNotFiniteAsOneThatOverlapsNothing) {
  boxes_[0].min[2] = std::numeric_limits<float>::quiet_NaN();
  Frames(200);
  Frame(61);
  ASSERT_EQ(recorder_->recordings().size(), 1U) << recorder_->error();
  const auto scene = std::move(*MakeScene(recorder_->recordings()[0].path, {}));
  EXPECT_FALSE(IsValid(scene->aabbs()[0]));
  EXPECT_TRUE(IsValid(scene->aabbs()[1]));
}

TEST_F(FlightRecorderTest, KeepsTheNewestRecordingsAndRemovesOnlyOwnOnes) {
  std::ofstream(folder_ / "flight-20200101-000000-000.aabbs") << "another session's";
  std::string first;
  for (size_t i = 0; i < FlightRecorder::kMaxRecordings + 2; ++i) {
    Frames(3100);
    Frame(61);
    ASSERT_EQ(recorder_->recordings().size(), std::min(i + 1, FlightRecorder::kMaxRecordings));
    if (i == 0) first = recorder_->recordings()[0].path;
  }
  EXPECT_FALSE(fs::exists(first));
  EXPECT_EQ(FileCount(), FlightRecorder::kMaxRecordings + 1);
  EXPECT_TRUE(fs::exists(folder_ / "flight-20200101-000000-000.aabbs"));
  EXPECT_EQ(recorder_->error(), "");
}

TEST_F(FlightRecorderTest, ReportsWhyWritingFailedAndContinues) {
  fs::remove_all(folder_);
  Frames(200);
  Frame(61);
  EXPECT_TRUE(recorder_->recordings().empty());
  EXPECT_THAT(recorder_->error(), HasSubstr("create it first"));
  fs::create_directories(folder_);
  Frames(3100);
  Frame(61);
  EXPECT_EQ(recorder_->recordings().size(), 1U);
  EXPECT_EQ(recorder_->error(), "");
}

TEST_F(FlightRecorderTest, ReportsThatTwoFramesDoNotFitInItsMemory) {
  boxes_.resize(recorder_->ring().max_boxes() / 2 + 1);
  Frames(110);
  Frame(61);
  Frame(10);
  EXPECT_THAT(recorder_->error(), HasSubstr("flight_recorder.memory_mb"));
  EXPECT_EQ(FileCount(), 0U);
}

TEST_F(FlightRecorderTest, ErrorsOfOptionsNameTheirBounds) {
  const auto message_of = [this](const FlightRecorderOptions& flight) {
    SessionOptions options = options_;
    options.flight_recorder = flight;
    return ValidateSessionOptions(options).message();
  };
  const std::string folder = folder_.string();
  EXPECT_EQ(message_of({.memory_mb = 64, .directory = folder}), "");
  EXPECT_EQ(message_of({.memory_mb = 0, .frame_budget_ms = -1}), "");
  EXPECT_THAT(message_of({.memory_mb = 1025, .directory = folder}), HasSubstr("0 to 1024"));
  for (const double budget_ms : {0.0, std::nan(""), 60'001.0}) {
    EXPECT_THAT(message_of({.memory_mb = 1, .frame_budget_ms = budget_ms, .directory = folder}),
                HasSubstr("frame_budget_ms must be over 0"));
  }
  EXPECT_THAT(message_of({.memory_mb = 1}), HasSubstr("flight_recorder.directory"));
  EXPECT_THAT(message_of({.memory_mb = 1, .directory = folder + "/none"}),
              HasSubstr("create it first"));
}

}  // namespace
}  // namespace sweepstake
