// Tests the store on a failing disk: acknowledged commits survive, and failures are reported.
#include "tests/server/storage/failing_disk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

class FailingDiskTest : public ::testing::Test {
 protected:
  absl::Status Open() {
    auto store = OpenSqlitePriorStore(path_);
    if (!store.ok()) return store.status();
    store_ = *std::move(store);
    return absl::OkStatus();
  }
  absl::Status Commit(uint64_t n) {
    return store_->Commit(std::vector{Update("a", n, {Key("Grid")})});
  }
  void CommitUpTo(uint64_t n) {
    for (uint64_t i = 1; i <= n; ++i) ASSERT_TRUE(Commit(i).ok()) << i;
  }
  // Returns the number of the last commit in the store.
  uint64_t Stored() {
    const auto source = store_->LoadSource("a");
    if (!source.ok()) ADD_FAILURE() << source.status();
    return source.ok() && *source ? (*source)->progress.commit_sequence : 0;
  }
  // Simulates the death of the process, and starts the next one.
  void Restart(bool power_cut) {
    disk_->Kill();
    store_.reset();
    power_cut ? disk_->RestartAfterPowerCut() : disk_->Restart();
    const absl::Status status = Open();
    ASSERT_TRUE(status.ok()) << status;
  }
  void BeginOnDisk(uint64_t seed) {
    store_.reset();
    disk_.reset();
    disk_ = std::make_unique<FailingDisk>(seed);
    path_ = directory_.path() / std::to_string(seed) / "priors.db";
    std::filesystem::create_directory(path_.parent_path());
    ASSERT_TRUE(Open().ok());
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path path_;
  std::unique_ptr<FailingDisk> disk_;
  std::unique_ptr<PriorStore> store_;
};

TEST_F(FailingDiskTest, ACommitSurvivesAPowerCut) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    BeginOnDisk(seed);
    CommitUpTo(3);
    Restart(/*power_cut=*/true);
    EXPECT_EQ(Stored(), 3u) << seed;
  }
}

TEST_F(FailingDiskTest, DataReadByTheNextProcessSurviveAPowerCutWithoutASync) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    BeginOnDisk(seed);
    CommitUpTo(2);
    const uint64_t before = disk_->change_count();
    ASSERT_TRUE(Commit(3).ok());
    disk_->KillAfter(disk_->change_count() - before - 1);  // before the sync
    EXPECT_TRUE(absl::IsUnavailable(Commit(4))) << seed;
    EXPECT_TRUE(disk_->has_unsynced());
    Restart(/*power_cut=*/false);
    EXPECT_EQ(Stored(), 4u) << seed;  // this number is sent to a game that resumes
    Restart(/*power_cut=*/true);
    EXPECT_EQ(Stored(), 4u) << seed;
  }
}

TEST_F(FailingDiskTest, DataReadByTheNextProcessSurviveAPowerCutAfterAFailedSync) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    BeginOnDisk(seed);
    CommitUpTo(2);
    disk_->Set({.sync_error = 1});
    EXPECT_TRUE(absl::IsUnavailable(Commit(3))) << seed;
    Restart(/*power_cut=*/false);
    const uint64_t stored = Stored();
    Restart(/*power_cut=*/true);
    EXPECT_EQ(Stored(), stored) << seed;
  }
}

TEST_F(FailingDiskTest, TheLogIsMadeDurableWithoutRoomForACheckpoint) {
  BeginOnDisk(1);
  CommitUpTo(2);
  const uint64_t before = disk_->change_count();
  ASSERT_TRUE(Commit(3).ok());
  disk_->KillAfter(disk_->change_count() - before - 1);
  EXPECT_FALSE(Commit(4).ok());
  store_.reset();
  disk_->Restart();
  disk_->Set({.full = true});
  ASSERT_TRUE(Open().ok());
  EXPECT_FALSE(disk_->has_unsynced());
}

TEST_F(FailingDiskTest, DataOfAFailedSyncAreMadeDurableWithoutRoomForACheckpoint) {
  std::vector<priors::EvidenceKey> many;
  for (int i = 0; i < 200; ++i) many.push_back(Key("arm " + std::to_string(i)));
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    BeginOnDisk(seed);
    CommitUpTo(2);
    disk_->Set({.sync_error = 1});
    EXPECT_FALSE(store_->Commit(std::vector{Update("a", 3, many)}).ok()) << seed;
    disk_->Kill();
    store_.reset();
    disk_->Restart();
    disk_->Set({.full = true});
    ASSERT_TRUE(Open().ok());
    const uint64_t stored = Stored();
    Restart(/*power_cut=*/true);
    EXPECT_EQ(Stored(), stored) << seed;
  }
}

// After the check, the daemon may replace the file or read it again. The next power cut must not
// change the result of the check.
TEST_F(FailingDiskTest, TheLogIsMadeDurableBeforeDamagedPagesAreChecked) {
  BeginOnDisk(1);
  CommitUpTo(2);
  const int64_t page =  // a page of a table that is not in the log
      *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kReadOnly)
           ->QueryInteger("SELECT rootpage FROM sqlite_schema WHERE name = 'audit_row'");
  const uint64_t before = disk_->change_count();
  ASSERT_TRUE(Commit(3).ok());
  disk_->KillAfter(disk_->change_count() - before - 1);  // before the sync
  EXPECT_FALSE(Commit(4).ok());
  ASSERT_TRUE(disk_->has_unsynced());
  disk_->Kill();
  store_.reset();
  disk_->Restart();
  {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp((page - 1) * 4096);
    file << std::string(4096, '\x5a');
  }
  disk_->Set({.sync_error = 1});
  EXPECT_TRUE(absl::IsUnavailable(Open())) << "a power cut could still change the file";
  disk_->Set({});
  EXPECT_TRUE(absl::IsDataLoss(Open()));
  EXPECT_FALSE(disk_->has_unsynced());
}

TEST_F(FailingDiskTest, NoPowerCutLosesAcknowledgedEvidenceOrCountsItTwice) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    BeginOnDisk(seed);
    uint64_t acknowledged = 0;
    for (int life = 0; life < 4; ++life) {
      disk_->KillAfter((seed * 7 + static_cast<uint64_t>(life) * 13) % 41);
      while (Commit(acknowledged + 1).ok()) ++acknowledged;
      Restart(/*power_cut=*/life % 2 == 0);
      const uint64_t stored = Stored();
      EXPECT_GE(stored, acknowledged) << seed;
      EXPECT_EQ(LoadSums(*store_, {Key("Grid")})->sums[0].evidence.window_count, stored) << seed;
      acknowledged = stored;
    }
  }
}

TEST_F(FailingDiskTest, AFullFailingOrReadOnlyDiskIsReportedAndNothingIsAcknowledged) {
  const FailingDisk::Faults faults[] = {
      {.write_error = 1}, {.sync_error = 1}, {.full = true}, {.read_only = true}};
  uint64_t seed = 0;
  for (const FailingDisk::Faults& fault : faults) {
    BeginOnDisk(++seed);
    CommitUpTo(2);
    disk_->Set(fault);
    EXPECT_TRUE(absl::IsUnavailable(Commit(3))) << seed;
    EXPECT_EQ(LoadSums(*store_, {Key("Grid")})->sums[0].evidence.window_count, 2u);
    disk_->Set({});
    EXPECT_TRUE(Commit(3).ok()) << seed;
    Restart(/*power_cut=*/true);
    EXPECT_EQ(Stored(), 3u) << seed;
  }
}

TEST_F(FailingDiskTest, AFailedReadAtTheStartDoesNotCountAsDamage) {
  int failed = 0;
  BeginOnDisk(1);
  CommitUpTo(50);
  for (int i = 0; i < 200; ++i) {
    store_.reset();
    disk_->Set({.read_error = 0.05});
    const absl::Status status = Open();
    disk_->Set({});
    if (status.ok()) continue;
    ++failed;
    EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  }
  EXPECT_GT(failed, 20);
}

}  // namespace
}  // namespace sweepstake::storage
