// Games and daemons of different protocol versions, over the real stream.
#include <gmock/gmock.h>
#include <google/protobuf/unknown_field_set.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"
#include "tests/end_to_end/scripted_game.h"
#include "tests/support/daemon_process.h"
#include "tests/support/fake_daemon.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;
using Request = v1::StreamTelemetryRequest;
using Response = v1::StreamTelemetryResponse;

// Returns a recorded message of version 1. If today's protocol moved a field, its value would be
// unknown, and the message would serialize to other bytes.
template <typename Message>
Message Recorded(const std::string& name) {
  std::ifstream file(VERSION_1_MESSAGES);
  std::string line;
  while (std::getline(file, line)) {
    Message message;
    if (line.rfind(name + " ", 0) != 0) continue;
    EXPECT_TRUE(message.ParseFromString(absl::HexStringToBytes(line.substr(name.size() + 1))));
    return message;
  }
  ADD_FAILURE() << "no message '" << name << "' in " << VERSION_1_MESSAGES;
  return {};
}

// Adds an unknown field to the message and to every message in it, like a newer version.
void AddNewerFields(google::protobuf::Message& message) {
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const auto* field : fields) {
    if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) AddNewerFields(*reflection.MutableMessage(&message, field));
    for (int i = 0; field->is_repeated() && i < reflection.FieldSize(message, field); ++i)
      AddNewerFields(*reflection.MutableRepeatedMessage(&message, field, i));
  }
  reflection.MutableUnknownFields(&message)->AddLengthDelimited(500, "newer");
}

template <typename Message>
Message Newer(const std::string& name) {
  Message message = Recorded<Message>(name);
  AddNewerFields(message);
  return message;
}

// A message's fields by their numbers, which are all that an old program uses.
class Fields {
 public:
  explicit Fields(const std::string& message = "") {
    EXPECT_TRUE(fields_->ParseFromString(message));
  }

  int count() const { return fields_->field_count(); }
  bool Has(int number) const { return Find(number) != nullptr; }
  uint64_t Number(int number) const { return Has(number) ? Find(number)->varint() : 0; }
  std::string Bytes(int number) const {
    return Has(number) ? Find(number)->length_delimited() : "";
  }

 private:
  const google::protobuf::UnknownField* Find(int number) const {
    for (int i = 0; i < fields_->field_count(); ++i) {
      if (fields_->field(i).number() == number) return &fields_->field(i);
    }
    return nullptr;
  }

  // Shared, because an UnknownFieldSet cannot be copied.
  std::shared_ptr<google::protobuf::UnknownFieldSet> fields_ =
      std::make_shared<google::protobuf::UnknownFieldSet>();
};

// The field numbers of version 1.
enum ResponseField { kWelcome = 1, kSwitchCommand = 2, kAcknowledgement = 3 };

// A game's stream that sends what the test sets, and reads responses by field number.
class ScriptedStream {
 public:
  explicit ScriptedStream(const DaemonProcess& daemon)
      : stub_(v1::TelemetryService::NewStub(
            grpc::CreateChannel(daemon.address(), grpc::InsecureChannelCredentials()))),
        stream_(stub_->StreamTelemetry(&context_)) {}
  ~ScriptedStream() { context_.TryCancel(); }

  void Send(const Request& request) { EXPECT_TRUE(stream_->Write(request)); }
  // Reads until the condition holds; fails the test if the stream ends before.
  void ReadUntil(const std::function<bool()>& condition) {
    while (!condition()) {
      if (!Read()) return Fail();
    }
  }
  void AwaitAcknowledgement(uint64_t sequence) {
    ReadUntil([&] { return latest(kAcknowledgement).Number(1) >= sequence; });
  }
  Fields Open(const Request& hello) {
    Send(hello);
    ReadUntil([&] { return !latest(kWelcome).Bytes(1).empty(); });
    return latest(kWelcome);
  }
  grpc::Status Finish() {
    while (Read()) {
    }
    return stream_->Finish();
  }
  // Returns the latest response of a kind.
  const Fields& latest(ResponseField kind) { return latest_[kind]; }

 private:
  bool Read() {
    Response response;
    if (!stream_->Read(&response)) return false;
    const Fields fields(response.SerializeAsString());
    EXPECT_TRUE(fields.count() == 1 || latest_[kWelcome].Number(20) > 1)
        << "a game of version 1 reads only the last one";
    for (const ResponseField kind : {kWelcome, kSwitchCommand, kAcknowledgement}) {
      if (fields.Has(kind)) latest_[kind] = Fields(fields.Bytes(kind));
    }
    return true;
  }
  void Fail() { FAIL() << "the stream ended: " << stream_->Finish().error_message(); }

  grpc::ClientContext context_;
  std::unique_ptr<v1::TelemetryService::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<Request, Response>> stream_;
  std::map<ResponseField, Fields> latest_;
};

TEST(VersionTest, AGameOfVersion1PlaysWithThisDaemon) {
  const TemporaryDirectory data;
  const DaemonProcess daemon(data.path());
  Request hello = Recorded<Request>("hello");
  {
    ScriptedStream stream(daemon);
    const Fields welcome = stream.Open(hello);
    EXPECT_FALSE(welcome.Has(2)) << "resumed";
    EXPECT_EQ(welcome.Number(7), 10u) << "decision_interval_ms";
    EXPECT_EQ(welcome.Bytes(14), "paper");
    EXPECT_THAT(welcome.Bytes(18), SizeIs(32)) << "resume_token";
    stream.Send(Recorded<Request>("frames"));
    stream.Send(Recorded<Request>("bail_out"));
    stream.AwaitAcknowledgement(2);
    stream.ReadUntil([&] { return stream.latest(kSwitchCommand).Number(1) > 0; });
    Request outcome = Recorded<Request>("switch_outcome");
    const Fields& command = stream.latest(kSwitchCommand);
    outcome.mutable_switch_outcome()->set_command_id(command.Number(1));
    outcome.mutable_switch_outcome()->set_arm(static_cast<uint32_t>(command.Number(2)));
    stream.Send(outcome);
    stream.AwaitAcknowledgement(3);
    hello.mutable_hello()->set_session_id(welcome.Bytes(1));
    hello.mutable_hello()->set_resume_token(welcome.Bytes(18));
  }
  ScriptedStream stream(daemon);
  const Fields welcome = stream.Open(hello);
  EXPECT_TRUE(welcome.Has(2)) << "resumed";
  EXPECT_EQ(welcome.Number(3), 3u) << "acknowledged_sequence";
  stream.Send(Recorded<Request>("mode_change"));
  stream.Send(Recorded<Request>("goodbye"));
  const grpc::Status status = stream.Finish();
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(stream.latest(kAcknowledgement).Number(1), 4u);
}

TEST(VersionTest, ANewerGameThatSupportsAnOldVersionPlaysWithThisDaemon) {
  const TemporaryDirectory data;
  const DaemonProcess daemon(data.path(), "127.0.0.1:0", {"--http", "127.0.0.1:0"});
  Request hello = Newer<Request>("hello");
  hello.mutable_hello()->set_protocol_version(1'000);
  hello.mutable_hello()->set_min_protocol_version(1);
  hello.mutable_hello()->add_capabilities(static_cast<v1::Capability>(99));
  ScriptedStream stream(daemon);
  const Fields welcome = stream.Open(hello);
  EXPECT_EQ(welcome.Number(20), 2u) << "protocol_version";
  EXPECT_FALSE(welcome.Has(21)) << "capabilities";
  stream.Send(Newer<Request>("frames"));
  Request newer;
  newer.set_sequence(2);
  AddNewerFields(newer);
  stream.Send(newer);
  Request outcome = Newer<Request>("switch_outcome");
  outcome.mutable_switch_outcome()->set_reason(static_cast<v1::SwitchReason>(99));
  stream.Send(outcome);
  Request mode = Recorded<Request>("mode_change");
  mode.mutable_mode_change()->set_mode(static_cast<v1::Mode>(99));
  uint64_t sequence = 5;
  stream.Send(mode);
  for (const char* name : {"bail_out", "switch_outcome", "mode_change"}) {
    Request known = Newer<Request>(name);
    known.set_sequence(sequence++);
    stream.Send(known);
  }
  Request refusal;
  refusal.set_sequence(sequence++);
  refusal.mutable_order_refusal()->set_order_id(1);
  refusal.mutable_order_refusal()->set_reason(static_cast<v1::OrderRefusalReason>(99));
  AddNewerFields(refusal);
  stream.Send(refusal);
  stream.Send(Newer<Request>("goodbye"));
  const grpc::Status status = stream.Finish();
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(stream.latest(kAcknowledgement).Number(1), 8u);
  const std::string metrics = Get(daemon.http_port(), "/metrics").body;
  EXPECT_THAT(metrics, HasSubstr("\nsweepstake_unknown_messages_total 3\n"));
  EXPECT_THAT(metrics, HasSubstr("\nsweepstake_accepted_frames_total 30\n"));
}

class GameTest : public ::testing::Test {
 protected:
  GameTest() {
    daemon_.SetScript([](FakeDaemon::Script& script) {
      script.welcome = Recorded<Response>("welcome").welcome();
      AddNewerFields(script.welcome);
    });
    daemon_.Start();
  }
  // Whether the game has reported the outcome of a command.
  bool HasOutcomeOf(uint64_t command_id) {
    const std::vector<Request> evidence = daemon_.Evidence();
    return std::any_of(evidence.begin(), evidence.end(), [&](const Request& request) {
      return request.switch_outcome().command_id() == command_id &&
             request.switch_outcome().executed();
    });
  }
  void ExpectObeys(ScriptedGame& game, const Response& response) {
    const v1::SwitchCommand& command = response.switch_command();
    ASSERT_TRUE(daemon_.Send(response));
    EXPECT_TRUE(
        game.RunUntil([&](const SessionStats&) { return HasOutcomeOf(command.command_id()); }));
    EXPECT_EQ(game.adaptive().active_arm(), command.arm());
  }

  FakeDaemon daemon_;
};

TEST_F(GameTest, PlaysWithADaemonOfVersion1) {
  ScriptedGame game(daemon_.address(), FastOptions());
  ASSERT_TRUE(
      game.RunUntil([](const SessionStats& stats) { return stats.acknowledged_sequence > 0; }));
  EXPECT_EQ(game.stats().prior_source_count, 3u);
  ASSERT_THAT(game.stats().beliefs, SizeIs(7));
  EXPECT_EQ(game.stats().beliefs[6].alpha, 2);
  ExpectObeys(game, Recorded<Response>("switch_command"));
  ASSERT_TRUE(daemon_.Send(Recorded<Response>("posterior_snapshot")));
  EXPECT_TRUE(game.RunUntil(
      [](const SessionStats& stats) { return stats.verdict.verdict == Verdict::kTie; }));
  EXPECT_EQ(game.stats().beliefs[6].alpha, 4);
  ASSERT_TRUE(daemon_.Send(Recorded<Response>("reconnect_elsewhere")));
  EXPECT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.resumed_count == 1; }));
  game.Stop();
  EXPECT_EQ(game.stats().last_error, "");
  EXPECT_EQ(game.stats().unknown_message_count, 0u);
  daemon_.Kill();
  EXPECT_THAT(daemon_.goodbyes, SizeIs(1));
  const v1::Hello& hello = daemon_.hellos.front();
  EXPECT_EQ(
      hello.min_protocol_version() == 0 ? hello.protocol_version() : hello.min_protocol_version(),
      1u);
}

TEST_F(GameTest, ReportsThePolicyOfTheDaemon) {
  ScriptedGame game(daemon_.address(), FastOptions());
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.connection_count == 1; }));
  const v1::Welcome welcome = Recorded<Response>("welcome").welcome();
  EXPECT_EQ(game.stats().daemon_version, "0.1.0");
  EXPECT_EQ(game.stats().policy, "paper");
  EXPECT_EQ(game.stats().seed, welcome.seed());
  EXPECT_NE(welcome.seed(), 0u);
}

TEST_F(GameTest, RefusesADaemonWithAnUnsupportedVersionAndAcceptsItAfterAChange) {
  daemon_.SetScript([](FakeDaemon::Script& script) { script.welcome.set_protocol_version(3); });
  ScriptedGame game(daemon_.address(), FastOptions());
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return !stats.refusal.empty(); }));
  EXPECT_EQ(game.stats().refusal, "the daemon at " + daemon_.address() +
                                      " uses version 3 of the protocol, this game supports 1 to 2; "
                                      "update the older one");
  EXPECT_THAT(game.stats().last_error, StartsWith(game.stats().refusal));
  EXPECT_EQ(game.stats().connection_count, 0u);
  EXPECT_EQ(game.stats().sent_sequence, 0u);
  daemon_.SetScript([](FakeDaemon::Script& script) { script.welcome.set_protocol_version(1); });
  EXPECT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.connection_count == 1; }));
  EXPECT_EQ(game.stats().refusal, "");
}

TEST_F(GameTest, CountsAndSkipsMessagesOfANewerDaemon) {
  ScriptedGame game(daemon_.address(), FastOptions());
  ASSERT_TRUE(
      game.RunUntil([](const SessionStats& stats) { return stats.acknowledged_sequence > 0; }));
  Response newer;
  AddNewerFields(newer);
  ASSERT_TRUE(daemon_.Send(newer));
  Response command = Recorded<Response>("switch_command");
  command.mutable_switch_command()->set_reason(static_cast<v1::SwitchReason>(99));
  ASSERT_TRUE(daemon_.Send(command));
  Response snapshot = Newer<Response>("posterior_snapshot");
  snapshot.mutable_posterior_snapshot()->set_verdict(static_cast<v1::Verdict>(99));
  ASSERT_TRUE(daemon_.Send(snapshot));
  ExpectObeys(game, Newer<Response>("switch_command"));
  EXPECT_EQ(game.stats().unknown_message_count, 5u);
  EXPECT_EQ(game.stats().beliefs[6].alpha, 4) << "only the verdict of the snapshot is unknown";
  EXPECT_EQ(game.stats().verdict.verdict, Verdict::kUnknown);
  EXPECT_EQ(game.stats().command_count, 1u);
  EXPECT_EQ(game.stats().connection_count, 1u);
  ASSERT_TRUE(daemon_.Send(Newer<Response>("reconnect_elsewhere")));
  EXPECT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.resumed_count == 1; }));
}

}  // namespace
}  // namespace sweepstake::test_support
