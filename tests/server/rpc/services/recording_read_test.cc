// Operators read the flight recordings of a session: who may, what the game is asked for, and what
// is told of it.
#include <array>
#include <thread>
#include <vector>

#include "engine_client/decider/audit/rederive.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using Response = v1::StreamTelemetryResponse;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class RecordingReadTest : public RpcTest {
 protected:
  RecordingReadTest() {
    options_.tokens = &tokens_;
    tokens_.Add("all", auth::Role::kAdmin);
    tokens_.Add("reader", auth::Role::kWatch);
    tokens_.Add("other", auth::Role::kOperator, {"other"});
  }

  static v1::Hello Hello(bool gives) {
    v1::Hello hello = OneArmHello();
    if (gives) hello.add_capabilities(v1::CAPABILITY_RECORDINGS);
    return hello;
  }

  struct Outcome {
    grpc::Status status;
    v1::ReadRecordingResponse response;
  };
  Outcome Read(const std::string& session_id, uint64_t recording_id, uint64_t offset = 0,
               const std::string& token = "all-token") {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    v1::ReadRecordingRequest request;
    request.set_session_id(session_id);
    request.set_recording_id(recording_id);
    request.set_offset(offset);
    Outcome outcome;
    outcome.status =
        v1::SessionsService::NewStub(channel_)->ReadRecording(&context, request, &outcome.response);
    return outcome;
  }
  // The same, while the test plays the game.
  std::thread Reading(Outcome& outcome, const std::string& session_id, uint64_t recording_id,
                      uint64_t offset = 0) {
    return std::thread([this, &outcome, session_id, recording_id, offset] {
      outcome = Read(session_id, recording_id, offset);
    });
  }
  static v1::RecordingRequest Asked(TelemetryClient& game) {
    return game.Await(&Response::has_recording_request).recording_request();
  }
  static v1::StreamTelemetryRequest Part(uint64_t request_id, const std::string& data) {
    v1::StreamTelemetryRequest request;
    request.mutable_recording_part()->set_request_id(request_id);
    request.mutable_recording_part()->set_data(data);
    return request;
  }

  ScriptedTokens tokens_;
};

TEST_F(RecordingReadTest, TheGameIsAskedAndItsAnswerIsPassedOn) {
  TelemetryClient game(channel_, "all-token");
  const v1::Welcome welcome = game.Open(Hello(true));
  ASSERT_EQ(welcome.capabilities_size(), 1);
  EXPECT_EQ(welcome.capabilities(0), v1::CAPABILITY_RECORDINGS);
  Outcome list;
  std::thread listing = Reading(list, welcome.session_id(), 0);
  const v1::RecordingRequest asked = Asked(game);
  EXPECT_EQ(asked.recording_id(), 0u);
  v1::StreamTelemetryRequest answer = Part(asked.request_id(), "");
  v1::Recording& recording = *answer.mutable_recording_part()->add_recordings();
  recording.set_recording_id(3);
  recording.set_size_bytes(70'000);
  recording.set_worst_frame_ns(61'000'000);
  game.Send(answer);
  listing.join();
  ASSERT_TRUE(list.status.ok()) << list.status.error_message();
  ASSERT_EQ(list.response.recordings_size(), 1);
  EXPECT_EQ(list.response.recordings(0).SerializeAsString(), recording.SerializeAsString());

  Outcome part;
  std::thread reading = Reading(part, welcome.session_id(), 3, 65'536);
  const v1::RecordingRequest wanted = Asked(game);
  EXPECT_EQ(wanted.recording_id(), 3u);
  EXPECT_EQ(wanted.offset(), 65'536u);
  EXPECT_EQ(wanted.max_bytes(), 65'536u);
  game.Send(Part(asked.request_id(), "an older request's"));
  game.Send(Part(wanted.request_id(), "the rest"));
  reading.join();
  ASSERT_TRUE(part.status.ok()) << part.status.error_message();
  EXPECT_EQ(part.response.data(), "the rest");
  EXPECT_EQ(server_->counters().applied_message_count, 0u) << "no part is evidence";
}

TEST_F(RecordingReadTest, IsForOperatorsOfTheProject) {
  TelemetryClient game(channel_, "all-token");
  const std::string id = game.Open(Hello(true)).session_id();
  EXPECT_EQ(Read(id, 0, 0, "reader-token").status.error_code(),
            grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(Read(id, 0, 0, "other-token").status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Read("no such", 0).status.error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(RecordingReadTest, AGameThatGivesNoneIsNotAsked) {
  TelemetryClient game(channel_, "all-token");
  const v1::Welcome welcome = game.Open(Hello(false));
  EXPECT_EQ(welcome.capabilities_size(), 0);
  const Outcome refused = Read(welcome.session_id(), 1);
  EXPECT_EQ(refused.status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(refused.status.error_message(), HasSubstr("allow_recording_download"));
}

TEST_F(RecordingReadTest, TheAuditLogSaysOnceWhoReadsAFile) {
  TelemetryClient game(channel_, "all-token");
  const std::string id = game.Open(Hello(false)).session_id();
  Read(id, 0);
  Read(id, 7);
  Read(id, 7, 65'536);
  Read(id, 7, 131'072);
  // Who leaves out the first byte is told of, too.
  Read(id, 8, 1);
  ASSERT_TRUE(Eventually([&] { return AdminRows().size() >= 2; }));
  const auto row = [&](const std::string& recording) {
    return AllOf(HasSubstr("action=read-recording session=" + id + " recording=" + recording),
                 HasSubstr("operator=token all at "));
  };
  EXPECT_THAT(AdminRows(), ElementsAre(row("7"), row("8")));
}

TEST_F(RecordingReadTest, AGameIsAskedForOneCallAfterTheOtherOfWhichAFewMayWait) {
  TelemetryClient game(channel_, "all-token");
  const std::string id = game.Open(Hello(true)).session_id();
  std::array<Outcome, RecordingReads::kMaxWaiting + 1> outcomes;
  std::vector<std::thread> calls;
  for (Outcome& outcome : outcomes) calls.push_back(Reading(outcome, id, 1));
  v1::RecordingRequest asked = Asked(game);
  // One call is refused before the game has answered any.
  EXPECT_TRUE(Eventually(
      [&] { return server_->counters().error_counts.at(v1::ERROR_REASON_TOO_MANY_READS) == 1; }));
  for (size_t i = 0; i < RecordingReads::kMaxWaiting; ++i) {
    game.Send(Part(asked.request_id(), "part"));
    if (i + 1 < RecordingReads::kMaxWaiting) asked = Asked(game);
  }
  for (std::thread& each : calls) each.join();
  int refused_count = 0;
  for (const Outcome& outcome : outcomes) {
    if (outcome.status.ok()) {
      EXPECT_EQ(outcome.response.data(), "part");
      continue;
    }
    ++refused_count;
    EXPECT_EQ(outcome.status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  }
  EXPECT_EQ(refused_count, 1);
}

TEST_F(RecordingReadTest, APartThatWasAskedForIsNoFlood) {
  options_.max_messages_per_s = 1;
  server_->Adjust(options_);
  TelemetryClient game(channel_, "all-token");
  const std::string id = game.Open(Hello(true)).session_id();
  for (int i = 0; i < 20; ++i) {
    Outcome outcome;
    std::thread reading = Reading(outcome, id, 1);
    game.Send(Part(Asked(game).request_id(), "part"));
    reading.join();
    ASSERT_TRUE(outcome.status.ok()) << outcome.status.error_message();
  }
  for (int i = 0; i < 20; ++i) game.Send(Part(0, "unasked"));
  EXPECT_EQ(game.Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(RecordingReadTest, NobodyWaitsForALostGameOrForever) {
  auto game = std::make_unique<TelemetryClient>(channel_, "all-token");
  const std::string id = game->Open(Hello(true)).session_id();
  Outcome waiting;
  std::thread first = Reading(waiting, id, 1);
  Asked(*game);
  clock_.Advance(RecordingReads::kPatienceNs);
  first.join();
  EXPECT_EQ(waiting.status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(waiting.status.error_message(), HasSubstr("five seconds"));
  std::thread second = Reading(waiting, id, 1);
  Asked(*game);
  game.reset();
  second.join();
  EXPECT_EQ(waiting.status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(waiting.status.error_message(), HasSubstr("was lost"));
  EXPECT_EQ(Read(id, 1).status.error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(RecordingReadTest, APartThatBreaksItsBoundsEndsTheStream) {
  TelemetryClient game(channel_, "all-token");
  game.Open(Hello(true));
  game.Send(Part(1, std::string(65'537, 'x')));
  EXPECT_EQ(game.Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  TelemetryClient other(channel_, "all-token");
  other.Open(Hello(true));
  v1::StreamTelemetryRequest many = Part(1, "");
  for (uint64_t id = 1; id <= 9; ++id)
    many.mutable_recording_part()->add_recordings()->set_recording_id(id);
  other.Send(many);
  EXPECT_EQ(other.Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  TelemetryClient third(channel_, "all-token");
  third.Open(Hello(true));
  v1::StreamTelemetryRequest twice = Part(1, "");
  for (int i = 0; i < 2; ++i) twice.mutable_recording_part()->add_recordings()->set_recording_id(1);
  third.Send(twice);
  EXPECT_EQ(third.Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

}  // namespace
}  // namespace sweepstake::rpc
