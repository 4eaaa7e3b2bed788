// When a session sends flight recordings to its daemon, and how they are ordered among its other
// messages.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engine_client/telemetry/common/validation.h"
#include "engine_client/telemetry/protocol/session_link.h"
#include "sweepstake/v1/telemetry.pb.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake {
namespace {

class RecordingLinkTest : public ::testing::Test {
 protected:
  // Connects to a daemon that forwards recordings.
  v1::Hello Connect(bool allow) {
    options_.allow_recording_download = allow;
    link_.emplace(options_, "the daemon", 7, queue_, *adaptive_, &recorder_);
    link_->Connected(kNowNs);
    const v1::Hello hello = Take().hello();
    v1::StreamTelemetryResponse response;
    response.mutable_welcome()->set_session_id("a");
    response.mutable_welcome()->set_protocol_version(2);
    response.mutable_welcome()->add_capabilities(v1::CAPABILITY_RECORDINGS);
    EXPECT_TRUE(link_->OnMessage(response.SerializeAsString(), kNowNs).ok());
    EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kNone) << "without a request";
    return hello;
  }
  void Ask(uint64_t request_id, uint64_t recording_id, uint64_t offset = 0,
           uint32_t max_bytes = 65'536, uint64_t now_ns = kNowNs) {
    v1::StreamTelemetryResponse response;
    v1::RecordingRequest& request = *response.mutable_recording_request();
    request.set_request_id(request_id);
    request.set_recording_id(recording_id);
    request.set_offset(offset);
    request.set_max_bytes(max_bytes);
    EXPECT_TRUE(link_->OnMessage(response.SerializeAsString(), now_ns).ok());
  }
  void Frame(uint64_t frame_ms) {
    adaptive_->BeginFrame();
    adaptive_->FindPairs(std::vector<Aabb>(3));
    adaptive_->EndFrame({.frame_time_ns = frame_ms * 1'000'000});
    recorder_.Step(*adaptive_);
  }
  v1::StreamTelemetryRequest Take() {
    v1::StreamTelemetryRequest request;
    EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kSend);
    EXPECT_TRUE(request.ParseFromString(link_->Take(kNowNs)));
    return request;
  }
  SessionOptions Options() const {
    SessionOptions options;
    options.batch_frames = 1;
    options.flight_recorder = {.memory_mb = 1, .directory = folder_.path().string()};
    return options;
  }

  static constexpr uint64_t kNowNs = 1'000'000'000;
  test_support::TemporaryDirectory folder_;
  SessionOptions options_ = Options();
  FlightRecorder recorder_{options_};
  SampleQueue queue_{64, &recorder_.ring()};
  std::unique_ptr<AdaptiveBroadPhase> adaptive_ =
      std::move(*AdaptiveBroadPhase::Create({.arms = {"BruteForce", "Grid"}}, &queue_));
  std::optional<SessionLink> link_;
};

TEST_F(RecordingLinkTest, NothingIsGivenUnlessTheGameAllowsIt) {
  EXPECT_EQ(Connect(/*allow=*/false).capabilities_size(), 0);
  Ask(1, 0);
  EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kNone);
}

TEST_F(RecordingLinkTest, OptionsThatAllowItNeedARecorder) {
  options_.allow_recording_download = true;
  EXPECT_TRUE(ValidateSessionOptions(options_).ok());
  options_.flight_recorder.memory_mb = 0;
  EXPECT_FALSE(ValidateSessionOptions(options_).ok());
}

TEST_F(RecordingLinkTest, ARecordingIsListedAndReadPartByPart) {
  EXPECT_EQ(Connect(/*allow=*/true).capabilities(0), v1::CAPABILITY_RECORDINGS);
  Ask(1, 0);
  const v1::StreamTelemetryRequest none = Take();
  EXPECT_EQ(none.recording_part().request_id(), 1U);
  EXPECT_EQ(none.recording_part().recordings_size(), 0);
  Frame(900);
  Frame(200);
  for (const uint64_t sequence : {1U, 2U}) EXPECT_EQ(Take().sequence(), sequence);
  ASSERT_EQ(recorder_.recordings().size(), 1U) << recorder_.error();
  const FlightRecording written = recorder_.recordings()[0];
  Ask(2, 0, 0, 0, written.recorded_ns + 3'999'999);
  const v1::RecordingPart list = Take().recording_part();
  ASSERT_EQ(list.recordings_size(), 1);
  const v1::Recording& recording = list.recordings(0);
  EXPECT_EQ(recording.worst_frame_ns(), 900'000'000U);
  EXPECT_EQ(recording.age_ms(), 3U);

  std::string file;
  uint64_t request_id = 3;
  while (file.size() < recording.size_bytes()) {
    Ask(request_id, recording.recording_id(), file.size(), 100);
    const v1::StreamTelemetryRequest part = Take();
    EXPECT_EQ(part.sequence(), 0U) << "no part is evidence";
    EXPECT_EQ(part.recording_part().request_id(), request_id++);
    ASSERT_FALSE(part.recording_part().data().empty());
    ASSERT_LE(part.recording_part().data().size(), 100U);
    file += part.recording_part().data();
  }
  std::ifstream stream(written.path, std::ios::binary);
  EXPECT_EQ(file, std::string(std::istreambuf_iterator<char>(stream), {}));
  for (const uint64_t unknown : {recording.recording_id() + 1, uint64_t{99}}) {
    Ask(request_id, unknown);
    EXPECT_EQ(Take().recording_part().data(), "");
  }
  Ask(request_id, recording.recording_id(), file.size());
  EXPECT_EQ(Take().recording_part().data(), "");
}

TEST_F(RecordingLinkTest, APartComesAfterTheEvidenceAndIsNotSentAgainOrWaitedForAtTheEnd) {
  Connect(/*allow=*/true);
  Frame(10);
  Ask(1, 0);
  EXPECT_EQ(Take().sequence(), 1U);
  EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kSend);
  link_->Goodbye(2 * kNowNs);
  EXPECT_TRUE(Take().has_goodbye());
}

}  // namespace
}  // namespace sweepstake
