// Tests the audit log of sessions over the stream: every exported decision can be replayed bit by
// bit.
#include <spdlog/sinks/ringbuffer_sink.h>

#include <limits>
#include <utility>
#include <vector>

#include "engine_client/decider/audit/rederive.h"
#include "engine_client/decider/policy/log_cost.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class AuditTest : public RpcTest {
 protected:
  using RpcTest::RpcTest;
  std::vector<v1::AuditSegment> List(const v1::ListAuditSegmentsRequest& request = {}) {
    const auto stub = v1::AuditService::NewStub(channel_);
    grpc::ClientContext context;
    const auto reader = stub->ListAuditSegments(&context, request);
    std::vector<v1::AuditSegment> segments;
    v1::ListAuditSegmentsResponse part;
    while (reader->Read(&part))
      segments.insert(segments.end(), part.segments().begin(), part.segments().end());
    EXPECT_TRUE(reader->Finish().ok());
    return segments;
  }
  // Sends frames in messages `first` to `last`, with a tick after each, and waits for each
  // acknowledgement.
  void Play(TelemetryClient& client, uint64_t first, uint64_t last) {
    for (uint64_t message = first; message <= last; ++message) {
      client.Send(Frames(message, 30));
      ASSERT_TRUE(Applied(applied_ += 1));
      Tick();
      ASSERT_EQ(client.AwaitAcknowledgement(message), message);
    }
  }

  uint64_t applied_ = 0;  // messages since the server started
};

decision::AuditReport Derived(const std::vector<decision::AuditRow>& rows) {
  decision::AuditReport report = decision::Rederive(rows);
  EXPECT_FALSE(report.difference) << report.difference->Text();
  return report;
}

TEST_F(AuditTest, AnEmptyLogHasNoRows) {
  EXPECT_TRUE(ExportAudit().empty());
  EXPECT_TRUE(List().empty());
}

TEST_F(AuditTest, EveryExportedDecisionCanBeReplayed) {
  TelemetryClient client(channel_);
  const std::string id = client.Open(HelloMessage()).session_id();
  Play(client, 1, 5);
  client.Send(BailOut(6, 99'999));
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.decision_count, 6u);
  EXPECT_EQ(report.row_count, 7u);
  const auto segments = List();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].session_id(), id);
  EXPECT_EQ(segments[0].project(), "game");
  EXPECT_EQ(segments[0].scene(), "harbour");
  EXPECT_EQ(segments[0].row_count(), 7u);
  EXPECT_GT(segments[0].unix_start_ms(), 1'600'000'000'000);
}

TEST_F(AuditTest, TheSetupRowListsTheSourcesOfThePriorAndTheirWeights) {
  v1::Hello hello = HelloMessage();
  hello.set_policy("adaptive");
  hello.set_machine_class("desktop");
  hello.set_build("1.1");
  for (const std::string source : {"a", "b", "c"}) {
    Put({{.key = {.project = hello.project(),
                  .scene = hello.scene(),
                  .measured_by = "lane",
                  .arm = "Grid",
                  .backend_version = 1,
                  .machine_class = "desktop",
                  .reward_version = decision::kLogCostRewardVersion},
          .source_id = source,
          .source_sequence = 1,
          .evidence = {.alpha = 5'000, .beta = 5'000, .window_count = 50},
          .build = source == "c" ? "1.0" : "1.1"}});
  }
  TelemetryClient client(channel_);
  client.Open(hello);
  Play(client, 1, 1);
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  const std::vector<decision::AuditRow> rows = ExportAudit();
  EXPECT_THAT(rows.at(0).setup->origin.prior_sources,
              ElementsAre("2 sources of build 1.1 on desktop with weight 0.5",
                          "1 source of build 1.0 on desktop with weight 0.25"));
  Derived(rows);
}

class AuditOfTrials : public AuditTest, public testing::WithParamInterface<bool> {};

TEST_P(AuditOfTrials, TheSetupRowSaysWhetherTheGameStopsThem) {
  v1::Hello hello = HelloMessage();
  if (GetParam()) hello.add_capabilities(v1::CAPABILITY_STOPS_TRIALS);
  TelemetryClient client(channel_);
  client.Open(hello);
  Play(client, 1, 1);
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  const std::vector<decision::AuditRow> rows = ExportAudit();
  ASSERT_FALSE(rows.empty());
  ASSERT_TRUE(rows[0].setup);
  EXPECT_EQ(rows[0].setup->setup.stops_trials, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Capability, AuditOfTrials, testing::Bool());

TEST_F(AuditTest, BailOutsWithoutEvidenceAreReplayedAsSuch) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  for (uint64_t sequence = 1; sequence <= 20; ++sequence) client.Send(BailOut(sequence, sequence));
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(server_->counters().surplus_bail_out_count, 4u);
  EXPECT_EQ(Derived(ExportAudit()).decision_count, 20u);
}

TEST_F(AuditTest, ASessionResumedAfterARestartBeginsAnotherSegment) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
    Play(client, 1, 3);
  }
  RestartServer();
  applied_ = 0;
  TelemetryClient client(channel_);
  EXPECT_TRUE(client.Open(hello).resumed());
  Play(client, 4, 6);
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.session_count, 1u);
  EXPECT_EQ(report.segment_count, 2u);
  EXPECT_EQ(report.decision_count, 6u);
}

TEST_F(AuditTest, ASessionResumedWithinItsWindowContinuesItsSegment) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
    Play(client, 1, 2);
  }
  TelemetryClient client(channel_);
  EXPECT_TRUE(client.Open(hello).resumed());
  Play(client, 3, 4);
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.segment_count, 1u);
  EXPECT_GE(report.decision_count, 4u);
}

TEST_F(AuditTest, IsListedAndExportedBySessionProjectAndScene) {
  v1::Hello desert = HelloMessage();
  desert.set_scene("desert");
  TelemetryClient one(channel_);
  TelemetryClient other(channel_);
  const std::string id = one.Open(HelloMessage()).session_id();
  other.Open(desert);
  Play(one, 1, 1);
  Play(other, 1, 1);
  ASSERT_EQ(List().size(), 2u);
  v1::ExportDecisionsRequest request;
  request.set_session_id(id);
  EXPECT_EQ(ExportAudit(request).at(0).session, id);
  EXPECT_EQ(Derived(ExportAudit(request)).session_count, 1u);
  request.set_scene("desert");
  EXPECT_TRUE(ExportAudit(request).empty());
  v1::ListAuditSegmentsRequest scenes;
  scenes.set_project("game");
  scenes.set_scene("desert");
  ASSERT_EQ(List(scenes).size(), 1u);
  EXPECT_EQ(List(scenes)[0].scene(), "desert");
}

using Numbers = std::vector<std::pair<uint32_t, uint64_t>>;

// Returns the segment and the number of each row.
Numbers NumbersOf(const std::vector<decision::AuditRow>& rows) {
  Numbers numbers;
  for (const decision::AuditRow& row : rows) numbers.emplace_back(row.segment, row.row);
  return numbers;
}

TEST_F(AuditTest, ASessionCanBeExportedFromAGivenRowOn) {
  v1::Hello hello = HelloMessage();
  v1::ExportDecisionsRequest request;
  {
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
    Play(client, 1, 3);
  }
  RestartServer();
  applied_ = 0;
  TelemetryClient client(channel_);
  request.set_session_id(client.Open(hello).session_id());
  Play(client, 4, 6);
  const Numbers all = NumbersOf(ExportAudit(request));
  ASSERT_EQ(all.size(), 8u) << "two segments, each with its setup row";
  const auto behind = [&](uint32_t segment, uint64_t row) {
    request.set_after_segment(segment);
    request.set_after_row(row);
    return NumbersOf(ExportAudit(request));
  };
  EXPECT_EQ(behind(1, 2), Numbers(all.begin() + 2, all.end()));
  EXPECT_EQ(behind(1, 4), Numbers(all.begin() + 4, all.end())) << "the end of a segment";
  EXPECT_EQ(behind(2, 3), Numbers(all.begin() + 7, all.end()));
  EXPECT_THAT(behind(2, 4), IsEmpty());
  EXPECT_THAT(behind(3, 1), IsEmpty()) << "no such segment yet";
}

TEST_F(AuditTest, AnInvalidStartRowIsRefused) {
  const auto code = [&](const std::string& session, uint32_t segment, uint64_t row) {
    v1::ExportDecisionsRequest request;
    request.set_session_id(session);
    request.set_after_segment(segment);
    request.set_after_row(row);
    grpc::ClientContext context;
    const auto stub = v1::AuditService::NewStub(channel_);
    const auto reader = stub->ExportDecisions(&context, request);
    for (v1::ExportDecisionsResponse part; reader->Read(&part);) continue;
    return reader->Finish().error_code();
  };
  EXPECT_EQ(code("", 1, 1), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(code("a", 1, 0), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(code("a", 0, 1), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(code("a", 1, std::numeric_limits<uint64_t>::max()), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(code("a", 1, 1), grpc::StatusCode::OK) << "an unknown session has no rows";
}

TEST_F(AuditTest, ManyRowsAreSentInSeveralMessages) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  Play(client, 1, 1'000);
  const std::vector<decision::AuditRow> rows = ExportAudit();
  size_t bytes = 0;
  for (const decision::AuditRow& row : rows) bytes += EncodeAuditRow(row).size();
  EXPECT_GT(bytes, 2 * kAuditBytesPerMessage);
  EXPECT_EQ(Derived(rows).decision_count, 1'000u);
}

TEST_F(AuditTest, RowsAreLostIfTheDiskIsTooSlowAndTheLogContinuesAfterThem) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  Play(client, 1, 2);
  store_.Hold();
  uint64_t message = 2;
  while (server_->counters().lost_audit_row_count < 3) {
    const uint64_t decisions = server_->counters().decision_count;
    client.Send(Frames(++message, 30));
    ASSERT_TRUE(Applied(++applied_));
    Tick();
    ASSERT_TRUE(Eventually([&] { return server_->counters().decision_count > decisions; }));
  }
  store_.Release();
  ASSERT_EQ(client.AwaitAcknowledgement(message), message);
  Play(client, message + 1, message + 5);
  EXPECT_EQ(server_->counters().waiting_audit_bytes, 0u);
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.incomplete_segment_count, 1u);
  EXPECT_GT(report.decision_count, 10u);
  EXPECT_GE(report.underived_decision_count, 5u);
  const auto segments = List();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].first_row(), 1u);
  EXPECT_EQ(segments[0].lost_row_count(), server_->counters().lost_audit_row_count);
}

TEST_F(AuditTest, ATickWithoutEventsCausesNoRowAndNoCommit) {
  TelemetryClient idle(channel_);
  TelemetryClient playing(channel_);
  idle.Open(OneArmHello());
  v1::Hello desert = OneArmHello();
  desert.set_scene("desert");
  playing.Open(desert);
  Play(idle, 1, 1);
  Play(playing, 1, 1);
  Flush();
  const uint64_t commits = server_->counters().stored_commit_count;
  const uint64_t decisions = server_->counters().decision_count;
  Play(playing, 2, 20);
  EXPECT_EQ(server_->counters().stored_commit_count, commits + 19);
  EXPECT_EQ(server_->counters().decision_count, decisions + 19);
  Play(idle, 2, 2);
  EXPECT_EQ(Derived(ExportAudit()).segment_count, 2u);
}

class AuditLossTest : public AuditTest {
 protected:
  AuditLossTest() { log_.sinks().push_back(lines_); }
  // Advances one second, and waits until the daemon's log has a line that contains `text`.
  [[nodiscard]] bool Told(const std::string& text) {
    clock_.Advance(kSecondNs);
    return Eventually([&] {
      for (const std::string& line : lines_->last_formatted()) {
        if (line.find(text) != std::string::npos) return true;
      }
      return false;
    });
  }

  const std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> lines_ =
      std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(16);
};

TEST_F(AuditLossTest, LostRowsAreCountedAndLoggedOnceAMinute) {
  store_.LoseAuditRows(7);
  clock_.Advance(kSecondNs);
  EXPECT_TRUE(Told("7 rows of the audit log could not be written, 7 since the start"));
  EXPECT_EQ(server_->counters().lost_audit_row_count, 7u);
  store_.LoseAuditRows(2);
  clock_.Advance(kSecondNs);
  ASSERT_TRUE(Eventually([&] { return server_->counters().lost_audit_row_count == 9; }));
  store_.LoseAuditRows(1);
  clock_.Advance(60 * kSecondNs);
  EXPECT_TRUE(Told("3 rows of the audit log could not be written, 10 since the start"));
}

TEST_F(AuditLossTest, EvidenceThatPlayersMayNotAddIsCountedAndLogged) {
  store_.LimitPlayers(3);
  clock_.Advance(kSecondNs);
  EXPECT_TRUE(
      Told("3 records of players were not stored, or without their regime, 3 since the start "
           "(the latest: scene s)"));
  EXPECT_EQ(server_->counters().limited_player_evidence_count, 3u);
}

class SmallAuditTest : public AuditTest {
 protected:
  SmallAuditTest() : AuditTest(*storage::OpenMemoryPriorStore(kLimits)) {}
  static constexpr priors::AuditLimits kLimits{.bytes = 20'000};
};

TEST_F(SmallAuditTest, ALiveSessionLosesItsOldestRowsAndTheListingShowsIt) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  Play(client, 1, 200);
  const auto segments = List();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_GT(segments[0].first_row(), 1u);
  EXPECT_EQ(segments[0].first_row() + segments[0].row_count(), 202u) << "including the setup row";
  EXPECT_EQ(segments[0].lost_row_count(), 0u);
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.row_count, segments[0].row_count());
  EXPECT_EQ(report.decision_count, 0u);
  EXPECT_EQ(report.underived_decision_count, segments[0].row_count());
  EXPECT_EQ(report.incomplete_segment_count, 1u);
}

class WithoutAuditTest : public AuditTest {
 protected:
  WithoutAuditTest() { options_.keeps_audit = false; }
};

TEST_F(WithoutAuditTest, NothingIsStoredIfTheAuditLogIsOff) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  Play(client, 1, 2);
  EXPECT_TRUE(List().empty());
}

}  // namespace
}  // namespace sweepstake::rpc
