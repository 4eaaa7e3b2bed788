// The audit log of sessions over the stream: what is exported is derived again bit for bit.
#include "server/audit/rederive.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

class AuditTest : public RpcTest {
 protected:
  std::string Export(const v1::ExportDecisionsRequest& request = {}) {
    const auto stub = v1::AuditService::NewStub(channel_);
    grpc::ClientContext context;
    const auto reader = stub->ExportDecisions(&context, request);
    std::string csv;
    v1::ExportDecisionsResponse part;
    while (reader->Read(&part)) {
      if (!part.header().empty()) csv += part.header() + "\n";
      for (const std::string& row : part.rows()) csv += row + "\n";
    }
    const grpc::Status status = reader->Finish();
    EXPECT_TRUE(status.ok()) << status.error_message();
    return csv;
  }
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
  // Ticks with frames of messages `first` to `last`, each acknowledged.
  void Play(TelemetryClient& client, uint64_t first, uint64_t last) {
    for (uint64_t message = first; message <= last; ++message) {
      client.Send(Frames(message, 30));
      ASSERT_TRUE(Applied(applied_ += 1));
      Tick();
      ASSERT_EQ(client.AwaitAcknowledgement(message), message);
    }
  }

  uint64_t applied_ = 0;  // messages, since the server started
};

decision::AuditReport Derived(const std::string& csv) {
  decision::AuditReport report = decision::Rederive(csv);
  EXPECT_FALSE(report.difference) << report.difference->Text();
  return report;
}

TEST_F(AuditTest, AnEmptyLogIsAHeader) {
  EXPECT_EQ(Export(), decision::AuditHeader() + "\n");
  EXPECT_TRUE(List().empty());
}

TEST_F(AuditTest, EveryDecisionIsDerivedAgainFromWhatIsExported) {
  TelemetryClient client(channel_);
  const std::string id = client.Open(HelloMessage()).session_id();
  Play(client, 1, 5);
  client.Send(BailOut(6, 99'999));
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  const auto report = Derived(Export());
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

TEST_F(AuditTest, ASessionThatGoesOnAfterARestartBeginsAnotherSegment) {
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
  const auto report = Derived(Export());
  EXPECT_EQ(report.session_count, 1u);
  EXPECT_EQ(report.segment_count, 2u);
  EXPECT_EQ(report.decision_count, 6u);
}

TEST_F(AuditTest, ASessionThatComesBackWithinItsTimeGoesOnInItsSegment) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
    Play(client, 1, 2);
  }
  TelemetryClient client(channel_);
  EXPECT_TRUE(client.Open(hello).resumed());
  Play(client, 3, 4);
  const auto report = Derived(Export());
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
  ASSERT_TRUE(Eventually([&] { return List().size() == 2; }));
  v1::ExportDecisionsRequest request;
  request.set_session_id(id);
  EXPECT_THAT(Export(request), HasSubstr(id));
  EXPECT_EQ(Derived(Export(request)).session_count, 1u);
  request.set_scene("desert");
  EXPECT_EQ(Export(request), decision::AuditHeader() + "\n");
  v1::ListAuditSegmentsRequest scenes;
  scenes.set_project("game");
  scenes.set_scene("desert");
  ASSERT_EQ(List(scenes).size(), 1u);
  EXPECT_EQ(List(scenes)[0].scene(), "desert");
}

TEST_F(AuditTest, OfManyRowsComesInManyMessages) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  Play(client, 1, 1'000);
  const std::string csv = Export();
  EXPECT_GT(csv.size(), 2 * kAuditBytesPerMessage);
  EXPECT_EQ(Derived(csv).decision_count, 1'000u);
}

TEST_F(AuditTest, EndsWhereTheDiskDoesNotKeepUpAndIsDerivedAgainUpToThere) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  Play(client, 1, 2);
  store_.Hold();
  while (server_->counters().cut_audit_log_count == 0) {
    const uint64_t decisions = server_->counters().decision_count;
    Tick();
    ASSERT_TRUE(Eventually([&] { return server_->counters().decision_count > decisions; }));
  }
  store_.Release();
  client.Send(Frames(3, 30));
  ASSERT_TRUE(Applied(3));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(3), 3u) << "evidence goes on";
  const auto report = Derived(Export());
  EXPECT_LT(report.decision_count, server_->counters().decision_count);
  EXPECT_GT(report.decision_count, 10u);
}

class WithoutAuditTest : public AuditTest {
 protected:
  WithoutAuditTest() { options_.audit.rows = 0; }
};

TEST_F(WithoutAuditTest, NothingIsKeptWhereNothingIsWanted) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  Play(client, 1, 2);
  EXPECT_TRUE(List().empty());
}

}  // namespace
}  // namespace sweepstake::rpc
