// Actions of administrators are in the audit log, and reach the disk without waiting for a
// decision.
#include "server/sessions/admin_log.h"

#include <thread>

#include "engine_client/decider/audit/rederive.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class AdminLogTest : public RpcTest {
 protected:
  AdminLogTest() {
    options_.tokens = &tokens_;
    tokens_.Add("ann", auth::Role::kAdmin);
    tokens_.Add("ben", auth::Role::kOperator, {"game"});
  }
  static std::unique_ptr<grpc::ClientContext> As(const std::string& name) {
    auto context = std::make_unique<grpc::ClientContext>();
    context->AddMetadata("authorization", "Bearer " + name + "-token");
    return context;
  }
  void Kick(const std::string& session_id) {
    v1::KickSessionRequest request;
    request.set_session_id(session_id);
    v1::KickSessionResponse response;
    const auto context = As("ann");
    EXPECT_TRUE(v1::SessionsService::NewStub(channel_)
                    ->KickSession(context.get(), request, &response)
                    .ok());
  }
  void Order(const std::string& session_id, const std::string& arm = "Grid") {
    v1::OrderSessionRequest request;
    request.set_session_id(session_id);
    request.set_mode(v1::MODE_MANUAL);
    request.set_arm(arm);
    v1::OrderSessionResponse response;
    const auto context = As("ben");
    v1::SessionsService::NewStub(channel_)->OrderSession(context.get(), request, &response);
  }
  void Import() {
    const auto context = As("ben");
    v1::ImportPriorsResponse response;
    const auto writer =
        v1::PriorsService::NewStub(channel_)->ImportPriors(context.get(), &response);
    writer->WritesDone();
    EXPECT_TRUE(writer->Finish().ok());
  }
  std::vector<std::string> Log(const std::string& name = "ann") { return AdminRows(name); }
  [[nodiscard]] bool LogHas(size_t rows) {
    return Eventually([&] { return Log().size() == rows; });
  }

  ScriptedTokens tokens_;
};

TEST_F(AdminLogTest, RecordsWhoKickedOrderedAndImported) {
  TelemetryClient client(channel_, "ann-token");
  const std::string id = client.Open(OneArmHello()).session_id();
  Import();
  client.Cancel();  // so that no order waits for an answer
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_stream_count == 0; }));
  Order(id);
  Kick(id);
  ASSERT_TRUE(LogHas(4)) << "without any decision";
  EXPECT_THAT(
      Log(),
      ElementsAre(
          AllOf(StartsWith("token ben at ipv4:127.0.0.1:"),
                HasSubstr(" imported 0 records, 0 of them new or newer, which wait")),
          AllOf(StartsWith("token ben"), HasSubstr(" ordered session " + id + " to keep to Grid")),
          AllOf(StartsWith("token ben"), HasSubstr(" ordered session " + id + " to keep to Grid"),
                HasSubstr(", which was refused: GAME_AWAY")),
          AllOf(StartsWith("token ann"),
                HasSubstr(" kicked session " + id + " of game/harbour, which may not return"))));
  EXPECT_THAT(Log("ben"), ElementsAre())
      << "the log covers all projects, so a token for one project may not read it";
}

TEST_F(AdminLogTest, RecordsWhoGaveAnOrderBeforeTheGameAnswers) {
  v1::Hello hello = OneArmHello();
  hello.add_capabilities(v1::CAPABILITY_OPERATOR_ORDERS);
  TelemetryClient client(channel_, "ann-token");
  const std::string id = client.Open(hello).session_id();
  std::thread ben([&] { Order(id); });
  client.Await(&v1::StreamTelemetryResponse::has_operator_order);
  EXPECT_TRUE(LogHas(1));
  EXPECT_THAT(Log(),
              ElementsAre(AllOf(StartsWith("token ben at "), HasSubstr(" ordered session " + id))));
  client.Cancel();
  ben.join();
}

TEST_F(AdminLogTest, ANameCannotForgeAFieldOfItsRow) {
  const std::string arm = "x;operator=token ann";
  TelemetryClient client(channel_, "ann-token");
  v1::Hello hello = OneArmHello();
  hello.mutable_arms(0)->set_name(arm);
  const std::string id = client.Open(hello).session_id();
  client.Cancel();
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_stream_count == 0; }));
  Order(id, arm);
  ASSERT_TRUE(LogHas(2));
  EXPECT_THAT(Log(), Each(AllOf(StartsWith("token ben at "), HasSubstr(arm))));
}

class AdminLogWithoutAuditTest : public AdminLogTest {
 protected:
  AdminLogWithoutAuditTest() { options_.keeps_audit = false; }
};

TEST_F(AdminLogWithoutAuditTest, IsKeptWithoutAuditRowsOfDecisions) {
  Import();
  EXPECT_TRUE(LogHas(1));
}

TEST_F(AdminLogTest, EachRunOfTheDaemonHasASegmentThatReplayAccepts) {
  Import();
  ASSERT_TRUE(LogHas(1));
  RestartServer();
  Import();
  Import();
  ASSERT_TRUE(LogHas(3));
  v1::ExportDecisionsRequest request;
  request.mutable_filter()->set_session_id(std::string(decision::kAdminSession));
  std::vector<decision::AuditRow> log = ExportAudit(request, "ann");
  ASSERT_EQ(log.size(), 3u);
  EXPECT_EQ(log[2].segment, 2u);
  EXPECT_EQ(log[2].row, 2u);
  EXPECT_FALSE(decision::Rederive(log).difference);
  EXPECT_EQ(decision::Rederive(log).session_count, 0u);
  log[1].operator_name = "token ann";
  ASSERT_TRUE(decision::Rederive(log).difference);
  EXPECT_THAT(decision::Rederive(log).difference->Text(), HasSubstr("was edited"));
}

}  // namespace
}  // namespace sweepstake::rpc
