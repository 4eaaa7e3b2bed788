// Tests limits on the rate of listings, exports and new watchers, and on the number of concurrent
// exports, imports and watchers.
#include "engine_client/telemetry/daemon_channel.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

class ReadQuotaTest : public RpcTest {
 protected:
  ReadQuotaTest() { options_.max_reads_per_s = 2; }

  std::unique_ptr<grpc::ClientContext> Call(const std::string& token) const {
    auto context = std::make_unique<grpc::ClientContext>();
    // The deadline makes the test fail instead of block if a call is wrongly accepted.
    context->set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    if (!token.empty()) context->AddMetadata("authorization", "Bearer " + token);
    return context;
  }
  grpc::Status List(const std::string& token = "") {
    v1::ListPosteriorsResponse response;
    const auto context = Call(token);
    return v1::PosteriorsService::NewStub(channel_)->ListPosteriors(context.get(), {}, &response);
  }
  grpc::Status Export(const std::string& token = "") {
    const auto context = Call(token);
    const auto reader = v1::PriorsService::NewStub(channel_)->ExportPriors(context.get(), {});
    for (v1::ExportPriorsResponse page; reader->Read(&page);) continue;
    return reader->Finish();
  }
};

TEST_F(ReadQuotaTest, AnAddressHasAReadRateAndItsGamesContinue) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(List().ok());
    EXPECT_TRUE(Export().ok());
  }
  const grpc::Status status = List();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_TOO_MANY_READS);
  EXPECT_THAT(status.error_message(), HasSubstr("max_reads_per_s"));
  EXPECT_EQ(ReasonOf(Export()), v1::ERROR_REASON_TOO_MANY_READS);
  v1::WatchPosteriorsResponse event;
  const auto watch = Call("");
  EXPECT_EQ(
      ReasonOf(
          v1::PosteriorsService::NewStub(channel_)->WatchPosteriors(watch.get(), {})->Finish()),
      v1::ERROR_REASON_TOO_MANY_READS);
  TelemetryClient(channel_).Open(OneArmHello());
  EXPECT_THAT(logged_->text(), HasSubstr("TOO_MANY_READS"));
  clock_.Advance(kSecondNs);
  EXPECT_TRUE(List().ok());
  EXPECT_TRUE(List().ok());
  EXPECT_FALSE(List().ok());
}

TEST_F(ReadQuotaTest, TheRateCanBeChangedAtAnyTime) {
  for (int i = 0; i < 1'000 && List().ok(); ++i) continue;
  EXPECT_FALSE(List().ok());
  options_.max_reads_per_s = 1'000;
  server_->Adjust(options_);
  clock_.Advance(kSecondNs);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(List().ok());
}

// Tests tokens that are each used from several addresses.
class TokenReadQuotaTest : public ReadQuotaTest {
 protected:
  TokenReadQuotaTest() {
    options_.tokens = &tokens_;
    for (const char* name : {"ann", "bob"}) tokens_.Add(name, auth::Role::kAdmin);
  }

  ScriptedTokens tokens_;
};

TEST_F(TokenReadQuotaTest, ATokenHasOneReadRateForAllAddresses) {
  AccessControl access(options_, clock_, log_);
  const auto tell = [&](const std::string& address) { return access.BeginRead(address, 7).ok(); };
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(tell("ipv4:192.0.2." + std::to_string(i)));
  EXPECT_FALSE(tell("ipv4:192.0.2.100"));
  EXPECT_TRUE(access.BeginRead("ipv4:192.0.2.100", 8).ok()) << "another token";
  EXPECT_TRUE(access.BeginRead("ipv4:192.0.2.101", 0).ok()) << "none";
}

class TransferQuotaTest : public TokenReadQuotaTest {
 protected:
  TransferQuotaTest() {
    options_.max_reads_per_s = 1'000'000;
    options_.max_transfers = 3;
    options_.max_transfers_per_token = 2;
  }
  // Stores `count` records.
  void Fill(size_t count) {
    std::vector<priors::PriorRecord> records(count);
    for (size_t i = 0; i < count; ++i) {
      records[i].key.project = "game";
      records[i].key.scene = "harbour";
      records[i].key.arm = "Grid";
      records[i].source_id = "source " + std::to_string(i) + std::string(100, 'x');
      records[i].source_sequence = 1;
    }
    Put(records);
  }
  // An import that is under way.
  struct OpenImport {
    std::unique_ptr<grpc::ClientContext> context;
    v1::ImportPriorsResponse response;
    std::unique_ptr<grpc::ClientWriter<v1::ImportPriorsRequest>> writer;
  };
  std::unique_ptr<OpenImport> Begin(const std::string& token) {
    auto import = std::make_unique<OpenImport>();
    import->context = Call(token);
    import->writer = v1::PriorsService::NewStub(channel_)->ImportPriors(import->context.get(),
                                                                        &import->response);
    return import;
  }
};

TEST_F(TransferQuotaTest, TheDaemonAndATokenHaveLimitedConcurrentTransfers) {
  AccessControl access(options_, clock_, log_);
  const auto begin = [&](int64_t token_id) {
    auth::Principal caller;
    caller.token_id = token_id;
    return access.BeginTransfer(caller, v1::ERROR_REASON_TOO_MANY_READS);
  };
  auto first = begin(1);
  const auto second = begin(1);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_TRUE(absl::IsResourceExhausted(begin(1).status()));
  const auto other = begin(2);
  EXPECT_TRUE(other.ok());
  EXPECT_TRUE(absl::IsResourceExhausted(begin(2).status())) << "the daemon already has three";
  first->reset();
  EXPECT_TRUE(begin(1).ok());
  EXPECT_TRUE(begin(2).ok()) << "the previous one has ended";
}

TEST_F(TransferQuotaTest, AnExportOrImportOverTheLimitIsRefusedAndLogged) {
  options_.max_transfers = 0;
  server_->Adjust(options_);
  EXPECT_EQ(ReasonOf(Export("ann-token")), v1::ERROR_REASON_TOO_MANY_READS);
  EXPECT_EQ(ReasonOf(Begin("ann-token")->writer->Finish()), v1::ERROR_REASON_TOO_MANY_IMPORTS);
  EXPECT_THAT(logged_->text(), HasSubstr("(TOO_MANY_READS): 0 exports and imports"));
  EXPECT_THAT(logged_->text(), HasSubstr("(TOO_MANY_IMPORTS): 0 exports and imports"));
  options_.max_transfers = 1;
  server_->Adjust(options_);
  for (int i = 0; i < 10; ++i)
    EXPECT_TRUE(Eventually([&] { return Export("bob-token").ok(); }))
        << "each transfer releases its place";
}

TEST_F(TransferQuotaTest, AnEndlessImportIsEndedDespiteProgress) {
  options_.transfer_patience_ns = 60 * kSecondNs;
  RestartServer();
  const auto import = Begin("ann-token");
  bool goes_on = true;
  for (int second = 0; goes_on && second < 1'000; ++second) {
    v1::ImportPriorsRequest request;
    goes_on = import->writer->Write(request);
    clock_.Advance(kSecondNs);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_FALSE(goes_on);
  EXPECT_EQ(import->writer->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(TransferQuotaTest, AnExportThatIsReadTooSlowlyIsEndedDespiteProgress) {
  constexpr int kPages = 100;
  Fill(kPages * kRecordsPerMessage);
  options_.transfer_patience_ns = 30 * kSecondNs;
  RestartServer();
  const auto context = Call("ann-token");
  const auto reader =
      v1::PriorsService::NewStub(SmallWindowChannel())->ExportPriors(context.get(), {});
  int pages = 0;
  for (v1::ExportPriorsResponse part; reader->Read(&part); ++pages) clock_.Advance(kSecondNs);
  EXPECT_LT(pages, kPages);
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(TransferQuotaTest, AnImportWithTooManyRecordsIsEnded) {
  v1::PriorRecord record;
  record.set_project("game");
  record.set_scene("harbour");
  record.set_arm("Grid");
  record.set_backend_version(1);
  record.set_reward_version(1);
  record.set_source_id("a");
  record.set_source_sequence(1);
  v1::ImportPriorsRequest request;
  for (uint32_t i = 0; i < kRecordsPerMessage; ++i) *request.add_records() = record;
  const auto import = Begin("ann-token");
  for (uint32_t sent = 0; sent <= kMaxImportRecords; sent += kRecordsPerMessage)
    import->writer->Write(request);
  const grpc::Status status = import->writer->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_IMPORT_TOO_LARGE);
}

class WatcherQuotaTest : public TokenReadQuotaTest {
 protected:
  WatcherQuotaTest() {
    options_.max_reads_per_s = 1'000'000;
    options_.max_watchers = 4;
  }
};

TEST_F(WatcherQuotaTest, ATokenMayHaveHalfOfTheWatchersAndOneThatEndsMakesRoom) {
  const auto posteriors = v1::PosteriorsService::NewStub(channel_);
  const auto sessions = v1::SessionsService::NewStub(channel_);
  const auto& open = server_->counters().open_watcher_count;
  const auto first = Call("ann-token");
  const auto watch = posteriors->WatchPosteriors(first.get(), {});
  const auto second = Call("ann-token");
  const auto other_watch = sessions->WatchSessions(second.get(), {});
  ASSERT_TRUE(Eventually([&] { return open == 2; }));
  const auto refused = Call("ann-token");
  const grpc::Status status = sessions->WatchSessions(refused.get(), {})->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_TOO_MANY_WATCHERS);
  EXPECT_THAT(status.error_message(), HasSubstr("this token has 2 watchers"));
  const auto bobs = Call("bob-token");
  const auto bobs_watch = posteriors->WatchPosteriors(bobs.get(), {});
  EXPECT_TRUE(Eventually([&] { return open == 3; }))
      << "half of the watchers is reserved for others";
  first->TryCancel();
  EXPECT_TRUE(Eventually([&] { return open == 2; }));
  const auto third = Call("ann-token");
  const auto third_watch = posteriors->WatchPosteriors(third.get(), {});
  EXPECT_TRUE(Eventually([&] { return open == 3; }));
  for (const auto* call : {&second, &bobs, &third}) (*call)->TryCancel();
}

TEST_F(WatcherQuotaTest, AnAddressMayHaveHalfOfTheWatchersAndTheOwnMachineAll) {
  AccessControl access(options_, clock_, log_);
  std::vector<AccessControl::Share> shares;
  const auto begin = [&](const std::string& address) {
    auto share = access.BeginWatch({}, address);
    if (share.ok()) shares.push_back(*share);
    return share.ok();
  };
  EXPECT_TRUE(begin("ipv4:192.0.2.7"));
  EXPECT_TRUE(begin("ipv4:192.0.2.7"));
  EXPECT_FALSE(begin("ipv4:192.0.2.7"));
  EXPECT_TRUE(begin("ipv4:192.0.2.8")) << "another address";
  shares.clear();
  for (uint32_t i = 0; i < options_.max_watchers; ++i) EXPECT_TRUE(begin("ipv4:127.0.0.1"));
  EXPECT_FALSE(begin("ipv4:127.0.0.1")) << "the daemon has all its watchers";
  shares.clear();
  EXPECT_TRUE(begin("ipv4:192.0.2.7"));
}

}  // namespace
}  // namespace sweepstake::rpc
