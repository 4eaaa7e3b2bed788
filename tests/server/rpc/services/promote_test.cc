// Imported records wait in quarantine until an authorised caller promotes them.
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class PromoteTest : public RpcTest {
 protected:
  PromoteTest() {
    options_.tokens = &tokens_;
    tokens_.Add("all", auth::Role::kAdmin);
    tokens_.Add("mine", auth::Role::kOperator, {"game"});
    tokens_.Add("reader", auth::Role::kWatch);
  }

  std::unique_ptr<grpc::ClientContext> As(const std::string& name) {
    auto context = std::make_unique<grpc::ClientContext>();
    context->AddMetadata("authorization", "Bearer " + name + "-token");
    return context;
  }
  // Returns a record of a source of this build about the scene of OneArmHello.
  static v1::PriorRecord RecordOf(const std::string& source, const std::string& build) {
    const v1::Hello hello = OneArmHello();
    v1::PriorRecord record;
    record.set_project(hello.project());
    record.set_scene(hello.scene());
    record.set_arm(hello.arms(0).name());
    record.set_backend_version(hello.arms(0).backend_version());
    record.set_machine_class(hello.machine_class());
    record.set_reward_version(1);
    record.set_source_id(source);
    record.set_source_sequence(1);
    record.set_alpha_increment(30);
    record.set_beta_increment(10);
    record.set_window_count(4);
    record.set_build(build);
    return record;
  }
  v1::ImportPriorsResponse Import(const std::vector<v1::PriorRecord>& records,
                                  bool promote = false) {
    v1::ImportPriorsRequest request;
    for (const v1::PriorRecord& record : records) *request.add_records() = record;
    request.set_promote(promote);
    v1::ImportPriorsResponse response;
    const auto context = As("all");
    const auto writer = stub()->ImportPriors(context.get(), &response);
    writer->Write(request);
    writer->WritesDone();
    EXPECT_TRUE(writer->Finish().ok());
    return response;
  }
  grpc::Status Promote(const v1::PromotePriorsRequest& request, const std::string& name = "all") {
    return stub()->PromotePriors(As(name).get(), request, &promoted_);
  }
  std::vector<v1::PriorRecord> Export(bool quarantined_only = false) {
    v1::ExportPriorsRequest request;
    request.set_quarantined_only(quarantined_only);
    const auto context = As("all");
    const auto reader = stub()->ExportPriors(context.get(), request);
    std::vector<v1::PriorRecord> records;
    for (v1::ExportPriorsResponse part; reader->Read(&part);)
      records.insert(records.end(), part.records().begin(), part.records().end());
    EXPECT_TRUE(reader->Finish().ok());
    return records;
  }
  // Returns alpha of the prior of a new session.
  double AlphaOfASession() {
    TelemetryClient client(channel_, "all-token");
    const v1::Welcome welcome = client.Open(OneArmHello());
    return welcome.priors_size() == 0 ? 1 : welcome.priors(0).alpha();
  }
  std::unique_ptr<v1::PriorsService::Stub> stub() { return v1::PriorsService::NewStub(channel_); }

  ScriptedTokens tokens_;
  v1::PromotePriorsResponse promoted_;
};

TEST_F(PromoteTest, AnImportReachesNoSessionAndNoPosteriorUntilItIsPromoted) {
  EXPECT_EQ(Import({RecordOf("a", "0.9")}).applied_count(), 1u);
  EXPECT_TRUE(Stored().arms.empty());
  EXPECT_EQ(AlphaOfASession(), 1);
  ASSERT_EQ(Export().size(), 1u);
  EXPECT_TRUE(Export()[0].is_quarantined());
  EXPECT_EQ(Export(/*quarantined_only=*/true).size(), 1u);

  v1::PromotePriorsRequest request;
  request.mutable_sources()->set_build("0.9");
  request.set_preview(true);
  ASSERT_TRUE(Promote(request).ok());
  EXPECT_EQ(promoted_.source_count(), 1u);
  EXPECT_EQ(promoted_.record_count(), 1u);
  EXPECT_EQ(promoted_.window_count(), 4u);
  EXPECT_EQ(promoted_.scene_count(), 1u);
  ASSERT_EQ(promoted_.leader_changes().scenes_size(), 1);
  EXPECT_EQ(promoted_.leader_changes().scenes(0).arm(), "") << "the scene has no leader before";
  EXPECT_EQ(promoted_.leader_changes().scenes(0).next_arm(), OneArmHello().arms(0).name());
  EXPECT_TRUE(Stored().arms.empty()) << "a preview changes nothing";
  ASSERT_TRUE(Eventually([&] { return AdminRows().size() == 1; })) << "the row of the import";
  EXPECT_THAT(AdminRows()[0],
              HasSubstr(" imported 1 record, 1 of them new or newer, which wait in quarantine"));

  request.set_preview(false);
  ASSERT_TRUE(Promote(request).ok());
  EXPECT_EQ(promoted_.record_count(), 1u);
  EXPECT_EQ(Stored().arms[0].live, (priors::Evidence{30, 10, 4, 0}));
  EXPECT_GT(AlphaOfASession(), 1);
  EXPECT_FALSE(Export()[0].is_quarantined());
  EXPECT_TRUE(Export(/*quarantined_only=*/true).empty());
  ASSERT_TRUE(Eventually([&] { return AdminRows().size() == 2; }));
  EXPECT_THAT(AdminRows()[1], AllOf(HasSubstr(" promoted 1 source with 1 record, build 0.9"),
                                    StartsWith("token all at ")));
  ASSERT_TRUE(Promote(request).ok());
  EXPECT_EQ(promoted_.record_count(), 0u) << "the record already counts";
}

TEST_F(PromoteTest, AnImportWithPromoteCountsAtOnce) {
  EXPECT_EQ(Import({RecordOf("a", "0.9")}, /*promote=*/true).applied_count(), 1u);
  EXPECT_EQ(Stored().arms[0].live, (priors::Evidence{30, 10, 4, 0}));
  EXPECT_TRUE(Export(/*quarantined_only=*/true).empty());
  ASSERT_TRUE(Eventually([&] { return AdminRows().size() == 1; }));
  EXPECT_THAT(AdminRows()[0],
              HasSubstr(" imported 1 record, 1 of them new or newer, which count at once"));
}

TEST_F(PromoteTest, AnExportHasWaitingRecordsAfterCountingOnesInPages) {
  std::vector<v1::PriorRecord> records;
  for (int i = 0; i < 150; ++i) records.push_back(RecordOf("counts " + std::to_string(i), "1"));
  Import(records, /*promote=*/true);
  for (int page = 0; page < 3; ++page) {
    records.clear();
    for (int i = 0; i < 150; ++i)
      records.push_back(RecordOf("waits " + std::to_string(150 * page + i), "2"));
    Import(records);
  }
  const auto exported = Export();
  ASSERT_EQ(exported.size(), 600u);
  for (size_t i = 0; i < exported.size(); ++i) EXPECT_EQ(exported[i].is_quarantined(), i >= 150);
  EXPECT_EQ(Export(/*quarantined_only=*/true).size(), 450u);
}

TEST_F(PromoteTest, WaitingRecordsAreRevokedLikeCountingOnes) {
  Import({RecordOf("a", "0.9"), RecordOf("b", "1.0")});
  v1::RevokePriorsRequest request;
  request.mutable_sources()->set_build("0.9");
  v1::RevokePriorsResponse revoked;
  ASSERT_TRUE(stub()->RevokePriors(As("all").get(), request, &revoked).ok());
  EXPECT_EQ(revoked.source_count(), 1u);
  EXPECT_EQ(revoked.window_count(), 4u);
  ASSERT_EQ(Export().size(), 1u);
  EXPECT_EQ(Export()[0].source_id(), "b");
}

TEST_F(PromoteTest, ATokenForSomeProjectsMustNameOneAndAReaderMayNotPromote) {
  Import({RecordOf("a", "0.9")});
  v1::PromotePriorsRequest request;
  EXPECT_EQ(ReasonOf(Promote(request, "mine")), v1::ERROR_REASON_NOT_ALLOWED);
  request.mutable_sources()->set_project("game");
  EXPECT_EQ(Promote(request, "reader").error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_TRUE(Stored().arms.empty());
  ASSERT_TRUE(Promote(request, "mine").ok());
  EXPECT_EQ(promoted_.record_count(), 1u);
}

TEST_F(PromoteTest, ANegativeNumberOrALongNameIsRefused) {
  v1::PromotePriorsRequest negative;
  negative.mutable_sources()->set_token_id(-1);
  v1::PromotePriorsRequest named;
  named.mutable_sources()->set_build(std::string(129, 'x'));
  for (const v1::PromotePriorsRequest& request : {negative, named})
    EXPECT_EQ(ReasonOf(Promote(request)), v1::ERROR_REASON_INVALID_MESSAGE);
}

}  // namespace
}  // namespace sweepstake::rpc
