// A daemon folds the evidence of old sessions, and says so.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "server/daemon.h"
#include "server/storage/sqlite_prior_store.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

// A daemon with the evidence of one session of long ago.
class DaemonFoldingTest : public ::testing::Test {
 protected:
  DaemonFoldingTest() {
    config_.listen = "127.0.0.1:0";
    config_.http = "127.0.0.1:0";
    config_.data = directory_.path() / "data";
    config_.log_level = "off";
    std::filesystem::create_directory(config_.data);
    priors::SourceUpdate update = storage::Update("old", 1, {storage::Key("Grid")});
    update.unix_time_s = 1'000'000'000;  // in 2001
    const auto store = storage::OpenSqlitePriorStore(config_.data / "priors.db");
    EXPECT_TRUE((*store)->Commit({&update, 1}).ok());
  }
  std::unique_ptr<Daemon> Start() {
    auto daemon = Daemon::Start(config_, clock_);
    EXPECT_TRUE(daemon.ok()) << daemon.status();
    return *std::move(daemon);
  }
  static v1::ExportPriorsResponse ExportFrom(const Daemon& daemon) {
    const auto stub = v1::PriorsService::NewStub(grpc::CreateChannel(
        "127.0.0.1:" + std::to_string(daemon.port()), grpc::InsecureChannelCredentials()));
    grpc::ClientContext context;
    const auto reader = stub->ExportPriors(&context, {});
    v1::ExportPriorsResponse all;
    v1::ExportPriorsResponse part;
    while (reader->Read(&part)) all.MergeFrom(part);
    EXPECT_TRUE(reader->Finish().ok());
    return all;
  }
  // Waits until the daemon has told of a run that folded the session.
  static void WaitUntilFolded(const Daemon& daemon) {
    const std::string shown = "\nsweepstake_store_folded_sources_total 1\n";
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (test_support::Get(daemon.http_port(), "/metrics").body.find(shown) ==
           std::string::npos) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  static void ExpectFolded(const Daemon& daemon) {
    WaitUntilFolded(daemon);
    const v1::ExportPriorsResponse exported = ExportFrom(daemon);
    EXPECT_EQ(exported.records_size(), 0);
    EXPECT_EQ(exported.folded_record_count(), 1u);
    EXPECT_EQ(exported.folded_window_count(), 1u);
  }

  test_support::TemporaryDirectory directory_;
  Config config_;
  rpc::SteadyClock clock_;
};

TEST_F(DaemonFoldingTest, EvidenceOfMoreThanAYearAgoIsFoldedAtTheStartAndNotExported) {
  ExpectFolded(*Start());
}

TEST_F(DaemonFoldingTest, ReloadTakesOverAfterHowManyDays) {
  config_.fold_days = 0;
  const auto daemon = Start();
  EXPECT_EQ(ExportFrom(*daemon).records_size(), 1);
  Config changed = config_;
  changed.fold_days = 30;
  daemon->Reload(changed);
  ExpectFolded(*daemon);
}

}  // namespace
}  // namespace sweepstake::server
