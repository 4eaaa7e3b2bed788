// Tests which evidence a revocation removes, who may revoke it, and that no trace of it remains.
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class RevokeTest : public RpcTest {
 protected:
  RevokeTest() {
    options_.tokens = &tokens_;
    tokens_.Add("all", auth::Role::kAdmin);
    tokens_.Add("mine", auth::Role::kOperator, {"game"});
    tokens_.Add("player", auth::Role::kIngest);
  }

  // Runs a session of this build that learns one window. REQUIRES: it is the n-th session of the
  // server.
  v1::Welcome Learn(const std::string& build, uint64_t n, const std::string& token = "all-token") {
    TelemetryClient client(channel_, token);
    v1::Hello hello = OneArmHello();
    hello.set_build(build);
    const v1::Welcome welcome = client.Open(hello);
    client.Send(Frames(1, 30, 10 * n));
    EXPECT_TRUE(Applied(n));
    Tick();
    client.AwaitAcknowledgement(1);
    return welcome;
  }
  static v1::RevokePriorsRequest OfBuild(const std::string& build) {
    v1::RevokePriorsRequest request;
    request.mutable_sources()->set_build(build);
    return request;
  }
  grpc::Status Revoke(const v1::RevokePriorsRequest& request,
                      const std::string& token = "all-token") {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    return v1::PriorsService::NewStub(channel_)->RevokePriors(&context, request, &revoked_);
  }
  v1::RevokePriorsResponse RevokedBy(const v1::RevokePriorsRequest& request) {
    const grpc::Status status = Revoke(request);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return revoked_;
  }

  ScriptedTokens tokens_;
  v1::RevokePriorsResponse revoked_;
};

TEST_F(RevokeTest, ABuildIsRemovedCompletelyAfterAPreviewThatChangesNothing) {
  Learn("1.0", 1);
  const priors::SceneEvidence before = Stored();
  Learn("1.1", 2);
  Learn("1.1", 3);
  const priors::SceneEvidence with = Stored();
  v1::RevokePriorsRequest request = OfBuild("1.1");
  request.set_preview(true);
  EXPECT_EQ(RevokedBy(request).source_count(), 2u);
  EXPECT_EQ(revoked_.record_count(), 2u);
  EXPECT_EQ(revoked_.window_count(), 2u);
  EXPECT_EQ(Stored().arms[0].live, with.arms[0].live);
  EXPECT_TRUE(AdminRows().empty());

  EXPECT_EQ(RevokedBy(OfBuild("1.1")).source_count(), 2u);
  EXPECT_EQ(Stored().arms[0].live, before.arms[0].live) << "equal in every bit";
  EXPECT_EQ(Stored().source_count, 1u);
  EXPECT_EQ(RevokedBy(OfBuild("1.1")).source_count(), 0u) << "the sources are already revoked";
  ASSERT_TRUE(Eventually([&] { return AdminRows().size() == 2; }));
  EXPECT_THAT(AdminRows()[0], AllOf(HasSubstr(" revoked 2 sources with 2 records, build 1.1"),
                                    StartsWith("token all at ")));
}

TEST_F(RevokeTest, APreviewListsTheScenesWhoseLeaderWouldChange) {
  const auto import = [this](const std::string& source, const std::string& arm, double alpha) {
    v1::ImportPriorsRequest request;
    request.set_promote(true);
    for (int scene = 0; scene < 25; ++scene) {
      v1::PriorRecord& record = *request.add_records();
      record.set_project("game");
      record.set_scene(std::to_string(100 + scene));
      record.set_arm(arm);
      record.set_backend_version(1);
      record.set_reward_version(3);
      record.set_source_id(source);
      record.set_source_sequence(1);
      record.set_alpha_increment(scene == 0 ? 10 : alpha);
      record.set_beta_increment(10);
      record.set_build(source);
    }
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer all-token");
    v1::ImportPriorsResponse response;
    const auto writer = v1::PriorsService::NewStub(channel_)->ImportPriors(&context, &response);
    writer->Write(request);
    writer->WritesDone();
    EXPECT_TRUE(writer->Finish().ok());
  };
  import("1.0", "Grid", 20);
  import("1.1", "SAP", 30);
  v1::RevokePriorsRequest request = OfBuild("1.1");
  request.set_preview(true);
  const v1::LeaderChanges changes = RevokedBy(request).leader_changes();
  EXPECT_EQ(changes.scene_count(), 24u) << "the first scene's arms are equal: the first one leads";
  ASSERT_EQ(changes.scenes_size(), 20);
  EXPECT_EQ(changes.scenes(0).project(), "game");
  EXPECT_EQ(changes.scenes(0).scene(), "101");
  EXPECT_EQ(changes.scenes(0).reward_version(), 3u);
  EXPECT_EQ(changes.scenes(0).arm(), "SAP");
  EXPECT_EQ(changes.scenes(0).next_arm(), "Grid");
  request.mutable_sources()->set_build("1.0");
  EXPECT_EQ(RevokedBy(request).leader_changes().scenes(0).scene(), "100");
  request.mutable_sources()->set_project("other");
  EXPECT_EQ(RevokedBy(request).leader_changes().scene_count(), 0u);
  EXPECT_FALSE(RevokedBy(OfBuild("1.1")).has_leader_changes()) << "this is not a preview";
}

TEST_F(RevokeTest, ARevokedSessionContinuesWithoutStoringEvidence) {
  TelemetryClient client(channel_, "all-token");
  v1::RevokePriorsRequest request;
  request.mutable_sources()->set_source_id(LearnOneWindow(client, OneArmHello()).session_id());
  EXPECT_EQ(RevokedBy(request).record_count(), 1u);
  client.Send(Frames(2, 30));
  ASSERT_TRUE(Applied(2));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(2), 2u);
  EXPECT_TRUE(Stored().arms.empty());
}

TEST_F(RevokeTest, TheSessionsOfATokenAreRevokedByItsId) {
  Learn("1.0", 1, "all-token");
  Learn("1.0", 2, "player-token");
  v1::RevokePriorsRequest request;
  request.mutable_sources()->set_token_id(3);
  EXPECT_EQ(RevokedBy(request).source_count(), 1u);
  EXPECT_EQ(Stored().source_count, 1u);
}

TEST_F(RevokeTest, ATokenForSomeProjectsMustNameOne) {
  Learn("1.0", 1);
  EXPECT_EQ(ReasonOf(Revoke(OfBuild("1.0"), "mine-token")), v1::ERROR_REASON_NOT_ALLOWED);
  v1::RevokePriorsRequest request = OfBuild("1.0");
  request.mutable_sources()->set_project("game");
  EXPECT_TRUE(Revoke(request, "mine-token").ok());
  EXPECT_EQ(revoked_.source_count(), 1u);
}

TEST_F(RevokeTest, ARequestThatNamesNoSourcesIsRefused) {
  v1::RevokePriorsRequest all;
  all.mutable_sources()->set_project("game");
  v1::RevokePriorsRequest negative = OfBuild("1.0");
  negative.mutable_sources()->set_token_id(-1);
  v1::RevokePriorsRequest before_1970 = OfBuild("1.0");
  before_1970.mutable_sources()->set_unix_until_s(-1);
  // A filter of a newer version; without it, more would be revoked.
  v1::RevokePriorsRequest newer = OfBuild("1.0");
  v1::SourceFilter& filter = *newer.mutable_sources();
  filter.GetReflection()->MutableUnknownFields(&filter)->AddVarint(99, 1);
  for (const v1::RevokePriorsRequest& request :
       {v1::RevokePriorsRequest(), all, negative, before_1970, newer,
        OfBuild(std::string(129, 'x'))}) {
    EXPECT_EQ(ReasonOf(Revoke(request)), v1::ERROR_REASON_INVALID_MESSAGE)
        << request.ShortDebugString();
  }
}

}  // namespace
}  // namespace sweepstake::rpc
