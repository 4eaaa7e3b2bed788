// Tests the daemon as the program runs it: files, health, drain.
#include "server/daemon.h"

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <deque>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/auth/token_store.h"
#include "server/rpc/health_probe.h"
#include "server/storage/sqlite_prior_store.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"
#include "tests/server/host/no_descriptors.h"
#include "tests/server/storage/failing_disk.h"
#include "tests/support/http_exchange.h"
#include "tests/support/sanitizers/active.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

using ::testing::HasSubstr;

class DaemonTest : public ::testing::Test {
 protected:
  DaemonTest() {
    config_.listen = "127.0.0.1:0";
    config_.data = directory_.path() / "data";
    config_.port_file = directory_.path() / "port";
    config_.log_level = "off";
    config_.rpc.decision.explore = false;
    config_.rpc.decision.settling_ns = 0;
    config_.rpc.decision.decision_interval_ns = 20'000'000;
  }
  std::unique_ptr<Daemon> Start() {
    auto daemon = Daemon::Start(config_, clock_);
    EXPECT_TRUE(daemon.ok()) << daemon.status();
    return *std::move(daemon);
  }

  test_support::TemporaryDirectory directory_;
  Config config_;
  sessions::SteadyLoopClock clock_;
};

v1::StreamTelemetryRequest Hello() {
  v1::StreamTelemetryRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.set_protocol_version(1);
  hello.set_project("game");
  hello.set_scene("harbour");
  hello.add_arms()->set_name("Grid");
  hello.mutable_arms(0)->set_backend_version(1);
  hello.set_mode(v1::MODE_AI);
  hello.set_policy("paper");  // with this policy a window counts as one observation
  return request;
}

v1::StreamTelemetryRequest OneFrame(uint64_t sequence) {
  v1::StreamTelemetryRequest request;
  request.set_sequence(sequence);
  v1::FrameBatch& batch = *request.mutable_frame_batch();
  batch.add_frame_time_ns(16'000'000);
  batch.add_detection_time_ns(4'000'000);
  batch.add_aabb_check_count(10);
  batch.add_native_bytes(1000);
  batch.add_object_count(5);
  batch.add_arm(0);
  batch.add_switch_epoch(0);
  batch.add_flags(0);
  return request;
}

// Opens a session and sends it one window in the message `sequence`. Returns the welcome message
// once this message is acknowledged.
v1::Welcome RunSession(int port, const v1::StreamTelemetryRequest& hello = Hello(),
                       uint64_t sequence = 1) {
  const auto channel =
      grpc::CreateChannel("127.0.0.1:" + std::to_string(port), grpc::InsecureChannelCredentials());
  const auto stub = v1::TelemetryService::NewStub(channel);
  grpc::ClientContext context;
  const auto stream = stub->StreamTelemetry(&context);
  stream->Write(hello);
  stream->Write(OneFrame(sequence));
  v1::Welcome welcome;
  v1::StreamTelemetryResponse response;
  while (stream->Read(&response)) {
    if (response.has_welcome()) welcome = response.welcome();
    if (response.has_acknowledgement() && response.acknowledgement().sequence() == sequence) break;
  }
  context.TryCancel();
  stream->Finish();
  return welcome;
}

std::shared_ptr<grpc::Channel> ChannelTo(const Daemon& daemon) {
  return grpc::CreateChannel("127.0.0.1:" + std::to_string(daemon.port()),
                             grpc::InsecureChannelCredentials());
}

TEST_F(DaemonTest, ThePortFileContainsThePort) {
  const auto daemon = Start();
  int port = 0;
  std::ifstream(config_.port_file) >> port;
  EXPECT_GT(port, 0);
  EXPECT_EQ(port, daemon->port());
}

TEST_F(DaemonTest, APortFileThatCannotBeWrittenStopsTheStart) {
  config_.port_file = directory_.path() / "nowhere" / "port";
  const absl::Status status = Daemon::Start(config_, clock_).status();
  EXPECT_TRUE(absl::IsUnavailable(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("cannot write the port file"));
}

TEST_F(DaemonTest, APipeOrADeviceIsNotReplacedByAPortFile) {
  config_.port_file = directory_.path() / "pipe";
  ASSERT_EQ(mkfifo(config_.port_file.c_str(), 0600), 0);
  const auto daemon = Daemon::Start(config_, clock_);
  EXPECT_THAT(std::string(daemon.status().message()), HasSubstr("is not a file"));
  EXPECT_TRUE(std::filesystem::is_fifo(config_.port_file));
}

TEST_F(DaemonTest, AFailedStartRemovesThePortFileOfAnEarlierDaemon) {
  const auto other = Start();
  config_.listen = "127.0.0.1:" + std::to_string(other->port());
  config_.data = directory_.path() / "other";
  config_.port_file = directory_.path() / "stale";
  std::ofstream(config_.port_file) << "1\n";
  sessions::SteadyLoopClock clock;
  EXPECT_FALSE(Daemon::Start(config_, clock).ok());
  EXPECT_FALSE(std::filesystem::exists(config_.port_file));
}

TEST_F(DaemonTest, EvidenceOfOneRunIsThePriorOfTheNext) {
  {
    const auto daemon = Start();
    EXPECT_EQ(RunSession(daemon->port()).prior_source_count(), 0u);
  }
  const auto daemon = Start();
  const v1::Welcome welcome = RunSession(daemon->port());
  EXPECT_EQ(welcome.prior_source_count(), 1u);
  EXPECT_NEAR(welcome.priors(0).alpha() + welcome.priors(0).beta(), 3, 1e-9);
}

TEST_F(DaemonTest, DrainingIsIdempotentAndFreesTheDataDirectory) {
  auto daemon = Start();
  daemon->Drain();
  daemon->Drain();
  daemon.reset();
  EXPECT_NE(Start(), nullptr);
}

TEST_F(DaemonTest, ASecondDaemonOnTheSameDataIsRefused) {
  const auto daemon = Start();
  sessions::SteadyLoopClock clock;
  const absl::Status status = Daemon::Start(config_, clock).status();
  EXPECT_THAT(std::string(status.message()), HasSubstr("another daemon"));
}

TEST_F(DaemonTest, APortInUseIsAnError) {
  const auto daemon = Start();
  config_.listen = "127.0.0.1:" + std::to_string(daemon->port());
  config_.data = directory_.path() / "other";
  sessions::SteadyLoopClock clock;
  const absl::Status status = Daemon::Start(config_, clock).status();
  EXPECT_TRUE(absl::IsUnavailable(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("cannot listen on"));
}

TEST_F(DaemonTest, AnEmptyDatabaseFileStopsTheStart) {
  std::filesystem::create_directory(config_.data);
  std::ofstream(config_.data / "priors.db").close();
  EXPECT_TRUE(absl::IsDataLoss(Daemon::Start(config_, clock_).status()));
}

TEST_F(DaemonTest, ADatabaseThatWasDeletedIsNotReplacedByAnEmptyOne) {
  Start()->Drain();
  std::filesystem::remove(config_.data / "priors.db");
  const absl::Status status = Daemon::Start(config_, clock_).status();
  EXPECT_TRUE(absl::IsDataLoss(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("store-id"));
  EXPECT_FALSE(std::filesystem::exists(config_.data / "priors.db"));
  std::filesystem::remove(config_.data / "store-id");
  EXPECT_NE(Start(), nullptr);
}

TEST_F(DaemonTest, ADatabaseOfAnotherDirectoryIsRefused) {
  Start()->Drain();
  const auto here = config_.data / "priors.db";
  config_.data = directory_.path() / "other";
  Start()->Drain();
  std::filesystem::copy_file(here, config_.data / "priors.db",
                             std::filesystem::copy_options::overwrite_existing);
  const absl::Status status = Daemon::Start(config_, clock_).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("is another database than at the last start"));
}

TEST_F(DaemonTest, HealthIsServingUntilItDrains) {
  const auto daemon = Start();
  const std::string address = "127.0.0.1:" + std::to_string(daemon->port());
  EXPECT_EQ(*rpc::ProbeHealth(address, {}, std::chrono::minutes(1)), rpc::Health::kServing);
  EXPECT_TRUE(daemon->Alive(std::chrono::minutes(1)));
  daemon->Drain();
  EXPECT_FALSE(rpc::ProbeHealth(address, {}, std::chrono::minutes(1)).ok());
  EXPECT_FALSE(daemon->Alive(std::chrono::minutes(1)));
}

TEST_F(DaemonTest, AnImportDuringTheDrainIsRefusedAndStoresNothing) {
  const auto daemon = Start();
  const auto channel = ChannelTo(*daemon);
  const auto telemetry = v1::TelemetryService::NewStub(channel);
  grpc::ClientContext session_context, import_context;
  const auto session = telemetry->StreamTelemetry(&session_context);
  session->Write(Hello());
  v1::StreamTelemetryResponse response;
  ASSERT_TRUE(session->Read(&response));
  v1::ImportPriorsResponse imported;
  const auto import = v1::PriorsService::NewStub(channel)->ImportPriors(&import_context, &imported);
  v1::ImportPriorsRequest request;
  request.set_promote(true);
  v1::PriorRecord& record = *request.add_records();
  record.set_project("game");
  record.set_scene("quay");
  record.set_arm("Grid");
  record.set_backend_version(1);
  record.set_machine_class("desktop");
  record.set_reward_version(1);
  record.set_source_id("file");
  record.set_source_sequence(1);
  ASSERT_TRUE(import->Write(request));
  // The calls of a connection arrive in order, so the daemon has the import before it drains.
  grpc::ClientContext list_context;
  v1::ListSessionsResponse sessions;
  const auto list = v1::SessionsService::NewStub(channel);
  ASSERT_TRUE(list->ListSessions(&list_context, {}, &sessions).ok());
  std::thread drain([&] { daemon->Drain(std::chrono::minutes(10)); });
  while (!response.has_reconnect() && session->Read(&response)) continue;
  import->WritesDone();
  const grpc::Status status = import->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(status.error_message(), HasSubstr("the daemon is draining; nothing was changed"));
  session->Finish();
  drain.join();
  const auto store = *storage::OpenSqlitePriorStore(config_.data / "priors.db");
  EXPECT_TRUE(store->Export({"game", "quay"}, {}, 10)->records.empty());
}

TEST_F(DaemonTest, IsAliveWithoutFreeDescriptorsButNotWithoutItsListener) {
#if SWEEPSTAKE_ASAN || SWEEPSTAKE_TSAN
  GTEST_SKIP() << "sanitizers open files to look at memory and to name functions";
#endif
  const auto daemon = Start();
  {
    test_support::NoDescriptors exhausted;
    EXPECT_TRUE(daemon->Alive(std::chrono::minutes(1))) << "it cannot connect";
    exhausted.FreeOne();
    EXPECT_TRUE(daemon->Alive(std::chrono::milliseconds(200))) << "its listener cannot accept";
  }
  EXPECT_TRUE(daemon->Alive(std::chrono::minutes(1)));
  daemon->Drain();
  EXPECT_FALSE(daemon->Alive(std::chrono::minutes(1)));
}

TEST_F(DaemonTest, ContinuesDecidingAndAcknowledgesNothingWhileTheDiskFails) {
  config_.http = "127.0.0.1:0";
  const storage::FailingDisk::Faults faults[] = {
      {.write_error = 1}, {.sync_error = 1}, {.full = true}, {.read_only = true}};
  for (const auto& fault : faults) {
    storage::FailingDisk disk;
    const auto daemon = Start();
    const auto channel = ChannelTo(*daemon);
    const auto stub = v1::TelemetryService::NewStub(channel);
    grpc::ClientContext context;
    const auto stream = stub->StreamTelemetry(&context);
    v1::StreamTelemetryResponse response;
    const auto read_until = [&](auto is_it) {
      while (stream->Read(&response) && !is_it())
        EXPECT_NE(response.acknowledgement().sequence(), 2u) << "before its time";
    };
    stream->Write(Hello());
    stream->Write(OneFrame(1));
    read_until([&] { return response.acknowledgement().sequence() == 1; });
    disk.Set(fault);
    stream->Write(OneFrame(2));
    read_until([&] { return response.has_posterior_snapshot(); });
    std::string ready;
    while (!ready.starts_with("[+]decision-loop ok\n[-]store"))
      ready = test_support::Get(daemon->http_port(), "/readyz").body;
    EXPECT_THAT(ready, HasSubstr("cannot write; decisions continue in memory: "));
    disk.Set({});
    read_until([&] { return response.acknowledgement().sequence() == 2; });
    context.TryCancel();
    stream->Finish();
  }
}

TEST_F(DaemonTest, IsNotReadyWhileItsDatabaseIsFull) {
  config_.audit.bytes = 0;
  config_.database_bytes = 1;
  {
    const auto daemon = Start();
    const auto channel = ChannelTo(*daemon);
    const auto stub = v1::TelemetryService::NewStub(channel);
    std::deque<grpc::ClientContext> contexts(60);
    std::vector<std::unique_ptr<
        grpc::ClientReaderWriter<v1::StreamTelemetryRequest, v1::StreamTelemetryResponse>>>
        streams;
    for (grpc::ClientContext& context : contexts) {
      v1::StreamTelemetryRequest hello = Hello();
      hello.mutable_hello()->set_scene(std::string(100, 's') + std::to_string(streams.size()));
      streams.push_back(stub->StreamTelemetry(&context));
      streams.back()->Write(hello);
      streams.back()->Write(OneFrame(1));
    }
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    rpc::Health health = rpc::Health::kServing;
    while (health != rpc::Health::kNotServing && std::chrono::steady_clock::now() < deadline)
      health = *rpc::HealthOf(channel, std::chrono::minutes(1));
    EXPECT_EQ(health, rpc::Health::kNotServing);
    Config larger = config_;
    larger.database_bytes = 1 << 19;
    daemon->Reload(larger);
    while (health != rpc::Health::kServing && std::chrono::steady_clock::now() < deadline)
      health = *rpc::HealthOf(channel, std::chrono::minutes(1));
    EXPECT_EQ(health, rpc::Health::kServing);
    for (grpc::ClientContext& context : contexts) context.TryCancel();
    for (const auto& stream : streams) stream->Finish();
  }
  config_.database_bytes = 1 << 20;
  const auto daemon = Start();
  EXPECT_FALSE(RunSession(daemon->port()).session_id().empty()) << "acknowledged";
  EXPECT_EQ(*rpc::HealthOf(ChannelTo(*daemon), std::chrono::minutes(1)), rpc::Health::kServing);
}

// Waits until `count` sessions have rows in the audit log.
void AwaitAudited(const Daemon& daemon, int count) {
  const auto stub = v1::AuditService::NewStub(ChannelTo(daemon));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  v1::ListAuditSegmentsResponse listed;
  do {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    grpc::ClientContext context;
    const auto reader = stub->ListAuditSegments(&context, {});
    v1::ListAuditSegmentsResponse page;
    for (listed.Clear(); reader->Read(&page);) listed.MergeFrom(page);
    ASSERT_TRUE(reader->Finish().ok());
  } while (listed.segments_size() != count);
}

TEST_F(DaemonTest, ReloadAppliesTheLimitsOfTheAuditLog) {
  config_.rpc.max_reads_per_s = 1'000'000;
  config_.audit.bytes = 0;
  const auto daemon = Start();
  RunSession(daemon->port());
  AwaitAudited(*daemon, 0);
  Config some = config_;
  some.audit.bytes = 1 << 20;
  daemon->Reload(some);
  RunSession(daemon->port());
  AwaitAudited(*daemon, 1);
  daemon->Reload(config_);
  AwaitAudited(*daemon, 0);
}

class DaemonTokenTest : public DaemonTest {
 protected:
  DaemonTokenTest() {
    std::filesystem::create_directory(config_.data);
    config_.rpc.max_reads_per_s = 1'000'000;  // tests repeat a read until the result changes
  }

  auth::TokenStore Tokens() const {
    return auth::TokenStore::Open(config_.data / "tokens.db").value();
  }
  std::string MakeToken(const std::string& name) const {
    return Tokens()
        .Create({.name = name,
                 .role = auth::Role::kWatch,
                 .projects = {},
                 .expires_unix_s = std::nullopt,
                 .made_by = "the test"},
                1)
        .value();
  }
  static grpc::StatusCode List(const Daemon& daemon, const std::string& token) {
    const auto stub = v1::PosteriorsService::NewStub(ChannelTo(daemon));
    grpc::ClientContext context;
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
    v1::ListPosteriorsResponse response;
    return stub->ListPosteriors(&context, {}, &response).error_code();
  }
};

TEST_F(DaemonTokenTest, OnOtherAddressesItNeedsATokenClientCertificatesOrInsecure) {
  config_.listen = "0.0.0.0:0";
  config_.rpc.tls.cert = config_.rpc.tls.key = "is-looked-at-later.pem";
  const absl::Status refused = Daemon::Start(config_, clock_).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("sweepstaked token create"));
  const auto is_later = [&] {
    return absl::IsInvalidArgument(Daemon::Start(config_, clock_).status());
  };
  config_.rpc.tls.ca = "ca.pem";
  EXPECT_TRUE(is_later());
  config_.rpc.tls.ca.clear();
  config_.insecure = true;
  EXPECT_TRUE(is_later());
  config_.insecure = false;
  MakeToken("first");
  EXPECT_TRUE(is_later());
}

TEST_F(DaemonTokenTest, ARunningDaemonAcceptsNewTokensAndRefusesRevokedOnes) {
  const auto daemon = Start();
  EXPECT_EQ(List(*daemon, ""), grpc::StatusCode::OK) << "there is no token yet";
  const std::string token = MakeToken("first");
  const auto await = [&](const std::string& with, grpc::StatusCode code) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (List(*daemon, with) != code && std::chrono::steady_clock::now() < deadline) continue;
    EXPECT_EQ(List(*daemon, with), code);
  };
  await("", grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_EQ(List(*daemon, token), grpc::StatusCode::OK);
  EXPECT_TRUE(daemon->Alive(std::chrono::minutes(1))) << "health needs no token";
  EXPECT_TRUE(Tokens().Revoke("first", "the test", 2).ok());
  await(token, grpc::StatusCode::UNAUTHENTICATED);
}

TEST_F(DaemonTokenTest, CreationAndRevocationOfTokensAreInTheAuditLog) {
  MakeToken("first");
  const auto daemon = Start();
  const std::string token = Tokens()
                                .Create({.name = "second",
                                         .role = auth::Role::kAdmin,
                                         .projects = {},
                                         .expires_unix_s = std::nullopt,
                                         .made_by = "the test"},
                                        1)
                                .value();
  EXPECT_TRUE(Tokens().Revoke("first", "another test", 2).ok());
  const auto stub = v1::AuditService::NewStub(ChannelTo(*daemon));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  std::string text;
  const auto has = [&](const char* part) { return text.find(part) != std::string::npos; };
  while (!(has("another test") && has("second was made")) &&
         std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    const auto rows = stub->ExportDecisions(&context, {});
    text.clear();
    for (v1::ExportDecisionsResponse part; rows->Read(&part);) {
      for (const v1::AuditRow& row : part.rows()) text += row.action() + "\n";
    }
  }
  EXPECT_THAT(text, HasSubstr("token first was revoked by another test"));
  EXPECT_THAT(text,
              HasSubstr("token second was created by the test, role admin, for all projects"));
}

TEST_F(DaemonTokenTest, ALostTokenFileStopsTheStartUntilItsMarkIsRemoved) {
  MakeToken("first");
  const auto is_refused = [&] {
    return absl::IsFailedPrecondition(Daemon::Start(config_, clock_).status());
  };
  std::filesystem::remove(config_.data / "tokens.db");
  EXPECT_TRUE(is_refused());
  EXPECT_TRUE(is_refused()) << "a refused start must not create an empty file";
  std::filesystem::remove(config_.data / "tokens-made");
  EXPECT_FALSE(is_refused());
}

TEST_F(DaemonTokenTest, WithRequireTokensItDoesNotStartWithoutAToken) {
  config_.require_tokens = true;
  config_.insecure = true;
  const absl::Status refused = Daemon::Start(config_, clock_).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("sweepstaked token create"));
  MakeToken("first");
  EXPECT_EQ(List(*Start(), ""), grpc::StatusCode::UNAUTHENTICATED);
}

TEST_F(DaemonTokenTest, ADamagedTokenFileStopsTheStart) {
  std::ofstream(config_.data / "tokens.db").close();
  EXPECT_TRUE(absl::IsDataLoss(Daemon::Start(config_, clock_).status()));
}

}  // namespace
}  // namespace sweepstake::server
