// Tests sessions of games while the prior store cannot be read: a session begins anyway, and the
// welcome message reports the missing priors. A session whose messages could count twice never
// begins.
#include <spdlog/sinks/ringbuffer_sink.h>

#include <fstream>

#include "server/storage/backup/automatic_backup.h"
#include "server/storage/sqlite_database.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

// A base class, so that the directory exists before the store is opened in it.
class WithDirectory {
 protected:
  const test_support::TemporaryDirectory directory_;
  const std::string path_ = (directory_.path() / "priors.db").string();
  storage::OpenedStore in_directory_ = *storage::OpenStoreOrBackup(path_);
};

class DamagedStoreTest : public WithDirectory, public RpcTest {
 protected:
  DamagedStoreTest() : RpcTest(std::move(in_directory_.store), std::move(in_directory_.reads)) {
    log_.sinks().push_back(log_lines_);
  }

  // Makes a session that learns one window, and restarts the server, so that only the store has the
  // session. Returns a Hello that resumes it.
  v1::Hello Learnt() {
    v1::Hello hello = HelloMessage();
    {
      TelemetryClient client(channel_);
      Resume(hello, LearnOneWindow(client, hello));
    }
    RestartServer();
    return hello;
  }
  // Overwrites the table's pages in the file, and makes the store read them again.
  void Damage(const std::string& table) {
    auto other =
        *storage::SqliteDatabase::Open(path_, storage::SqliteDatabase::OpenMode::kExisting);
    ASSERT_EQ(*other.QueryInteger("PRAGMA wal_checkpoint(TRUNCATE)"), 0) << "the log is in use";
    const int64_t size = *other.QueryInteger("PRAGMA page_size");
    const int64_t page =
        *other.QueryInteger("SELECT rootpage FROM sqlite_schema WHERE name = '" + table + "'");
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp((page - 1) * size);
    file << std::string(static_cast<size_t>(size), '\x5a');
    file.close();
    ASSERT_TRUE(other.Execute("CREATE TABLE since_then (x)").ok());
  }
  void ExpectDecisions(TelemetryClient& client) {
    client.Send(Frames(1, 30));
    ASSERT_TRUE(Applied(1));
    Tick();
    const v1::PosteriorSnapshot snapshot =
        client.Await(&v1::StreamTelemetryResponse::has_posterior_snapshot).posterior_snapshot();
    EXPECT_GT(snapshot.arms(0).alpha() + snapshot.arms(0).beta(), 2);
  }

  const std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> log_lines_ =
      std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(100);
};

TEST_F(DamagedStoreTest, ANewSessionBeginsWithoutPriorsAndDecides) {
  Learnt();
  Damage("evidence_key");
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(HelloMessage());
  EXPECT_TRUE(welcome.priors_unavailable());
  EXPECT_EQ(welcome.prior_source_count(), 0u);
  EXPECT_EQ(welcome.priors(0).alpha() + welcome.priors(0).beta(), 2);
  EXPECT_EQ(server_->counters().degraded_start_count, 1u);
  ExpectDecisions(client);
}

TEST_F(DamagedStoreTest, ANewSessionBeginsWithoutPriorsIfAHashIsWrong) {
  Learnt();
  ASSERT_TRUE(storage::SqliteDatabase::Open(path_, storage::SqliteDatabase::OpenMode::kExisting)
                  ->Execute("UPDATE evidence_key SET alpha_sum = 1e6 WHERE arm = 'Grid'")
                  .ok());
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(HelloMessage());
  EXPECT_TRUE(welcome.priors_unavailable());
  EXPECT_EQ(welcome.priors(0).alpha() + welcome.priors(0).beta(), 2);
  EXPECT_EQ(server_->counters().degraded_start_count, 1u);
  ExpectDecisions(client);
}

TEST_F(DamagedStoreTest, ASessionWithUnreadableProgressIsNotResumed) {
  const v1::Hello hello = Learnt();
  Damage("source");
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(hello);
  EXPECT_FALSE(welcome.resumed());
  EXPECT_NE(welcome.session_id(), hello.session_id());
  EXPECT_EQ(welcome.acknowledged_sequence(), 0u);
  EXPECT_TRUE(welcome.priors_unavailable());
  EXPECT_EQ(welcome.priors(0).alpha() + welcome.priors(0).beta(), 2)
      << "evidence of a damaged source is not used";
  ExpectDecisions(client);
}

TEST_F(DamagedStoreTest, ASessionContinuesWithItsOwnEvidenceIfItsScenesCannotBeRead) {
  const v1::Hello hello = Learnt();
  Damage("scene");
  const v1::Welcome welcome = TelemetryClient(channel_).Open(hello);
  EXPECT_TRUE(welcome.resumed());
  EXPECT_EQ(welcome.acknowledged_sequence(), 1u);
  EXPECT_TRUE(welcome.priors_unavailable());
  EXPECT_NEAR(welcome.priors(0).alpha() + welcome.priors(0).beta(), 3, 1e-12);
}

TEST_F(DamagedStoreTest, TheLogReportsItOnceAMinute) {
  Learnt();
  Damage("evidence_key");
  TelemetryClient(channel_).Open(HelloMessage());
  TelemetryClient(channel_).Open(HelloMessage());
  ASSERT_EQ(log_lines_->last_formatted().size(), 1u);
  EXPECT_THAT(log_lines_->last_formatted()[0], HasSubstr("malformed"));
  EXPECT_THAT(log_lines_->last_formatted()[0], HasSubstr("restore a backup"));
  clock_.Advance(60 * kSecondNs);
  TelemetryClient(channel_).Open(HelloMessage());
  ASSERT_EQ(log_lines_->last_formatted().size(), 2u);
  EXPECT_THAT(log_lines_->last_formatted()[1], HasSubstr("3 so far"));
}

TEST_F(DamagedStoreTest, TheLogReportsWatchersRefusedByADamagedOrBusyStore) {
  Learnt();
  const auto end_of_watch = [&] {
    grpc::ClientContext context;
    return ReasonOf(
        v1::PosteriorsService::NewStub(channel_)->WatchPosteriors(&context, {})->Finish());
  };
  store_.Close(true);
  EXPECT_EQ(end_of_watch(), v1::ERROR_REASON_STORE_BUSY);
  store_.Close(false);
  Damage("evidence_key");
  EXPECT_EQ(end_of_watch(), v1::ERROR_REASON_STORE_FAILED);
  EXPECT_THAT(log_lines_->last_formatted(),
              ::testing::ElementsAre(HasSubstr("(STORE_BUSY)"), HasSubstr("(STORE_FAILED)")));
}

TEST_F(DamagedStoreTest, ASlowStoreDoesNotBlockASessionAndTheEvidenceReachesItLater) {
  const v1::Hello hello = Learnt();
  std::promise<void> release;
  thread_.Submit([&](priors::PriorStore&) { release.get_future().wait(); });
  TelemetryClient client(channel_);
  const size_t submitted = store_.submit_count();
  client.Send(Request(hello));
  ASSERT_TRUE(Eventually([&] { return store_.submit_count() == submitted + 1; }));
  clock_.Advance(options_.load_patience_ns);
  const v1::Welcome welcome = client.Await(&v1::StreamTelemetryResponse::has_welcome).welcome();
  EXPECT_TRUE(welcome.priors_unavailable());
  EXPECT_FALSE(welcome.resumed());
  EXPECT_NE(welcome.session_id(), hello.session_id());
  ExpectDecisions(client);
  release.set_value();
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
  EXPECT_EQ(Stored().source_count, 2u);
  EXPECT_EQ(Stored().arms[0].live.window_count, 2u);
}

}  // namespace
}  // namespace sweepstake::rpc
