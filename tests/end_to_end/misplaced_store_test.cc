// A running daemon whose database is removed or replaced loses nothing that it acknowledged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include "server/storage/sqlite_prior_store.h"
#include "tests/end_to_end/store_reader.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/daemon_process.h"
#include "tests/support/file_text.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr size_t kCommittingGames = 3;

size_t CountIn(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// Returns the copies of the database that the log mentions.
std::vector<fs::path> CopiesIn(const std::string& log) {
  const std::regex report(
      "acknowledged evidence is in ([^ ]*priors\\.db\\.backup-[^ ]*): stop the daemon");
  std::vector<fs::path> copies;
  for (std::sregex_iterator match(log.begin(), log.end(), report); match != std::sregex_iterator();
       ++match)
    copies.emplace_back((*match)[1].str());
  return copies;
}

class MisplacedDatabaseTest : public ::testing::Test {
 protected:
  MisplacedDatabaseTest() {
    for (size_t i = 0; i < kCommittingGames; ++i) {
      rpc::TelemetryClient& game = games_.emplace_back(
          grpc::CreateChannel(daemon_.address(), grpc::InsecureChannelCredentials()));
      v1::Hello hello = rpc::OneArmHello();
      hello.set_time_scale(200);
      ids_.push_back(game.Open(hello).session_id());
    }
    for (sequence_ = 1; sequence_ < 6; ++sequence_) {
      for (rpc::TelemetryClient& game : games_) SendNext(game);
      for (rpc::TelemetryClient& game : games_) game.AwaitAcknowledgement(sequence_);
    }
  }
  void SendNext(rpc::TelemetryClient& game) const { game.Send(rpc::Frames(sequence_, 30)); }
  // Follows the instructions for the copy in the log of the daemon, which has ended.
  void FollowAdvice() const {
    const std::string log = daemon_.log();
    std::smatch advice;
    ASSERT_TRUE(std::regex_search(
        log, advice,
        std::regex("stop the daemon, move ([^ ]+), ([^ ]+) and ([^ ]+) away if they exist, run "
                   "`sweepstaked (restore [^`]+)`, and start the daemon again")))
        << log;
    for (size_t i = 1; i <= 3; ++i) {
      const fs::path file = advice[i].str();
      if (fs::exists(file)) fs::rename(file, elsewhere_.path() / file.filename());
    }
    const std::string restore = SWEEPSTAKED_PATH " " + advice[4].str();
    EXPECT_EQ(std::system(restore.c_str()), 0) << restore;
  }
  std::string Ready() const { return Get(daemon_.http_port(), "/readyz").body; }
  // Runs the games until the log mentions a copy; returns its name.
  fs::path AwaitCopy() {
    EXPECT_TRUE(rpc::Eventually([&] { return !CopiesIn(daemon_.log()).empty(); }));
    return CopiesIn(daemon_.log()).front();
  }
  // Checks that nothing sent from now on is acknowledged, and that the daemon reports this.
  void ExpectNothingMoreIsAcknowledged() {
    for (rpc::TelemetryClient& game : games_) {
      SendNext(game);
      game.Send(rpc::Goodbye());
      const grpc::Status end = game.Finish();
      EXPECT_EQ(end.error_code(), grpc::StatusCode::UNAVAILABLE);
      EXPECT_THAT(end.error_message(), HasSubstr("not on disk"));
      EXPECT_EQ(game.AwaitAcknowledgement(0), sequence_ - 1);
    }
    EXPECT_THAT(Ready(), HasSubstr("[-]store"));
    EXPECT_THAT(Get(daemon_.http_port(), "/metrics").body,
                HasSubstr("\nsweepstake_store_healthy 0\n"));
  }
  void ExpectAllIn(const fs::path& folder) const {
    for (const std::string& id : ids_) {
      const priors::SourceState source = ReadSource(folder, id);
      EXPECT_EQ(source.progress.message_sequence, sequence_ - 1);
      EXPECT_EQ(source.progress.frame_count, 30 * (sequence_ - 1));
      ExpectConsistent(source);
    }
  }

  TemporaryDirectory data_;
  TemporaryDirectory elsewhere_;
  const fs::path database_ = data_.path() / "priors.db";
  DaemonProcess daemon_{data_.path(), "127.0.0.1:0", {"--http", "127.0.0.1:0"}};
  std::deque<rpc::TelemetryClient> games_;
  std::vector<std::string> ids_;
  uint64_t sequence_ = 0;
};

TEST_F(MisplacedDatabaseTest, ADatabaseRemovedDuringGamesIsReportedOnceAndSaved) {
  fs::remove(database_);
  ExpectNothingMoreIsAcknowledged();
  const fs::path copy = AwaitCopy();
  EXPECT_THAT(Ready(), HasSubstr("priors.db was removed while it was in use"));
  EXPECT_THAT(Ready(), HasSubstr("restore " + copy.string()));
  EXPECT_EQ(daemon_.Terminate(), 0);
  EXPECT_EQ(CountIn(daemon_.log(), "nothing more is acknowledged"), 1u) << daemon_.log();
  EXPECT_EQ(CountIn(daemon_.log(), "all acknowledged evidence is in"), 1u) << daemon_.log();
  EXPECT_THAT(daemon_.log(), HasSubstr("Later evidence is lost at the stop"));
  EXPECT_THAT(daemon_.log(), HasSubstr("later evidence of 3 sessions is not"));
  EXPECT_THAT(daemon_.log(), HasSubstr("3 of the sessions have ended, and their evidence is lost"));
  FollowAdvice();
  ExpectAllIn(data_.path());
  const DaemonProcess next(data_.path());
}

TEST_F(MisplacedDatabaseTest, ADatabaseReplacedDuringGamesIsReportedOnceAndSaved) {
  const fs::path other = elsewhere_.path() / "priors.db";
  ASSERT_TRUE(storage::OpenSqlitePriorStore(other).ok());
  fs::rename(other, database_);
  ExpectNothingMoreIsAcknowledged();
  EXPECT_FALSE(AwaitCopy().empty());
  EXPECT_THAT(Ready(), HasSubstr("priors.db was replaced while it was in use"));
  EXPECT_EQ(daemon_.Terminate(), 0);
  EXPECT_EQ(CountIn(daemon_.log(), "nothing more is acknowledged"), 1u) << daemon_.log();
  EXPECT_EQ(fs::file_size(database_.string() + "-wal"), 0u)
      << "nothing may be written to the other file";
  FollowAdvice();
  ExpectAllIn(data_.path());
}

TEST_F(MisplacedDatabaseTest, AMovedDatabaseIsDetectedWithoutGamesAndUsedAgainWhenItIsBack) {
  const fs::path away = elsewhere_.path() / "away";
  for (rpc::TelemetryClient& game : games_) game.Cancel();
  fs::rename(database_, away);
  EXPECT_FALSE(AwaitCopy().empty());
  EXPECT_THAT(Ready(), HasSubstr("[-]store"));
  fs::rename(away, database_);
  EXPECT_TRUE(rpc::Eventually([&] { return CountIn(Ready(), "[-]store") == 0; }));
  EXPECT_EQ(daemon_.Terminate(), 0);
  EXPECT_THAT(daemon_.log(), HasSubstr("drained: all acknowledged evidence is on disk\""));
  ExpectAllIn(data_.path());
}

TEST_F(MisplacedDatabaseTest, ADatabaseMovedAgainIsSavedAgainWithLaterEvidence) {
  const fs::path away = elsewhere_.path() / "away";
  fs::rename(database_, away);
  AwaitCopy();
  fs::rename(away, database_);
  EXPECT_TRUE(rpc::Eventually([&] { return CountIn(Ready(), "[-]store") == 0; }));
  for (rpc::TelemetryClient& game : games_) SendNext(game);
  for (rpc::TelemetryClient& game : games_) game.AwaitAcknowledgement(sequence_);
  ++sequence_;
  fs::rename(database_, away);
  EXPECT_EQ(daemon_.Terminate(), 0);
  const std::vector<fs::path> copies = CopiesIn(daemon_.log());
  ASSERT_EQ(copies.size(), 2u) << daemon_.log();
  fs::rename(copies.back(), database_);
  ExpectAllIn(data_.path());
}

TEST(MisplacedDirectoryTest, AFailedCopyIsTriedAgainAtShutdownWithoutWaiting) {
  const TemporaryDirectory folder;
  const fs::path above = folder.path() / "above";
  fs::create_directories(above / "data");
  DaemonProcess daemon(above / "data");
  fs::rename(above, folder.path() / "away");
  const auto log = [&] { return FileText(folder.path() / "away" / "data" / "log"); };
  EXPECT_TRUE(rpc::Eventually([&] { return CountIn(log(), "cannot be copied") == 1; }));
  fs::create_directory(above);
  EXPECT_EQ(daemon.Terminate(), 0);
  ASSERT_EQ(CopiesIn(log()).size(), 1u) << log();
  EXPECT_TRUE(fs::exists(CopiesIn(log()).front()));
}

}  // namespace
}  // namespace sweepstake::test_support
