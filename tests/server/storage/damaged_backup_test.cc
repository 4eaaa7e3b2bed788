// Tests backups of a database with damaged rows: a backup is intact and lacks only these rows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>

#include "server/storage/backup/automatic_backup.h"
#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_store.h"
#include "server/storage/sqlite_schema.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

class DamagedBackupTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(data_);
    store_ = *OpenSqlitePriorStore(path_);
    ASSERT_TRUE(store_
                    ->Commit(std::vector{Update("a", 1, {Key("Grid"), Key("SAP")}),
                                         Update("b", 1, {Key("Grid"), Key("Grid", "desert")})})
                    .ok());
  }
  // Changes rows without updating their hashes, as disk damage does.
  void Damage(const std::string& change) { Execute(path_, "UPDATE " + change); }
  static void Execute(const std::filesystem::path& path, const std::string& sql) {
    auto file = *SqliteDatabase::Open(path.string(), SqliteDatabase::OpenMode::kExisting);
    const absl::Status status = file.Execute(sql);
    ASSERT_TRUE(status.ok()) << status;
  }
  static std::string HarbourGrid() {
    return "key_id IN (SELECT id FROM evidence_key WHERE scene = 'harbour' AND arm = 'Grid')";
  }
  // Backs up the database, restores the backup into another directory, and opens the result.
  std::unique_ptr<PriorStore> RestoredBackup(int64_t damaged_row_count) {
    const auto made = BackUpStore(data_, file_);
    EXPECT_TRUE(made.ok()) << made.status();
    EXPECT_EQ(made->damaged_row_count, damaged_row_count);
    const auto put_back = RestoreStore(file_, other_);
    EXPECT_TRUE(put_back.ok()) << put_back.status();
    EXPECT_EQ(put_back->damaged_row_count, 0);
    auto opened = OpenStoreOrBackup(other_ / "priors.db");
    EXPECT_TRUE(opened.ok()) << opened.status();
    EXPECT_EQ(opened->damage, "");
    return std::move(opened->store);
  }
  static KeySum SumOf(PriorStore& store, const EvidenceKey& key) {
    const auto sums = LoadSums(store, {key});
    EXPECT_TRUE(sums.ok()) << sums.status();
    return sums->sums[0];
  }
  static uint64_t SourceCountOf(PriorStore& store, const std::string& scene) {
    const auto found = store.LoadScene({"game", scene, "desktop", 1});
    EXPECT_TRUE(found.ok()) << found.status();
    return (*found)->source_count;
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path data_ = directory_.path() / "data";
  std::filesystem::path other_ = directory_.path() / "other";
  std::filesystem::path path_ = data_ / "priors.db";
  std::filesystem::path file_ = directory_.path() / "copy.db";
  std::unique_ptr<PriorStore> store_;
};

TEST_F(DamagedBackupTest, DamagedEvidenceIsOmittedAndTheRestIsKept) {
  Damage("evidence SET alpha = 1000 WHERE source_id = 1 AND " + HarbourGrid());
  const auto store = RestoredBackup(1);
  const KeySum grid = SumOf(*store, Key("Grid"));
  EXPECT_EQ(grid.evidence.alpha, 0.75);
  EXPECT_EQ(grid.evidence.window_count, 1u);
  EXPECT_EQ(grid.source_count, 1u);
  EXPECT_EQ(SumOf(*store, Key("SAP")).source_count, 1u);
  EXPECT_EQ(SourceCountOf(*store, "harbour"), 2u)
      << "the session has evidence about another arm too";
  EXPECT_FALSE((*store->LoadSource("a"))->evidence.empty());
  EXPECT_TRUE(store->Commit(std::vector{Update("a", 2, {Key("Grid")})}).ok());
  EXPECT_EQ(SumOf(*store, Key("Grid")).source_count, 2u);
}

TEST_F(DamagedBackupTest, ASceneLosesASourceWhoseOnlyEvidenceIsDamaged) {
  Damage(
      "evidence SET hash = hash + 1 WHERE key_id IN "
      "(SELECT id FROM evidence_key WHERE scene = 'desert')");
  const auto store = RestoredBackup(1);
  EXPECT_EQ(SumOf(*store, Key("Grid", "desert")).source_count, 0u);
  EXPECT_FALSE((*store->LoadSource("b"))->evidence.empty());
  EXPECT_EQ(SourceCountOf(*store, "harbour"), 2u);
  EXPECT_EQ(BackUpStore(other_, directory_.path() / "next.db")->scene_count, 1);
}

TEST_F(DamagedBackupTest, ADamagedSourceIsOmittedWithAllItsEvidence) {
  Damage("source SET message_sequence = 1000000 WHERE name = 'b'");
  const auto store = RestoredBackup(1);
  EXPECT_EQ(*store->LoadSource("b"), std::nullopt);
  EXPECT_EQ(SumOf(*store, Key("Grid")).source_count, 1u);
  EXPECT_EQ(SourceCountOf(*store, "harbour"), 1u);
  EXPECT_EQ(store->Export({}, {}, 9)->records.size(), 2u);
}

TEST_F(DamagedBackupTest, DamagedSumsAndCountsAreRecomputedAndNothingIsLost) {
  const KeySum before = SumOf(*store_, Key("Grid"));
  Damage("evidence_key SET alpha_sum = 1000 WHERE scene = 'harbour' AND arm = 'Grid'");
  Damage("evidence_key SET hash = 7 WHERE arm = 'SAP'");
  Damage("scene SET source_count = 7 WHERE scene = 'desert'");
  const auto store = RestoredBackup(3);
  EXPECT_EQ(SumOf(*store, Key("Grid")).evidence.alpha, before.evidence.alpha);
  EXPECT_EQ(SourceCountOf(*store, "desert"), 1u);
  EXPECT_EQ(store->Export({}, {}, 9)->records.size(), 4u);
}

TEST_F(DamagedBackupTest, TheDatabaseItselfIsNotChanged) {
  Damage("evidence SET alpha = 1000 WHERE source_id = 1 AND " + HarbourGrid());
  RestoredBackup(1);
  auto live = *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting);
  EXPECT_EQ(*CountDamagedRows(live), 1);
  EXPECT_EQ(*live.QueryInteger("SELECT count(*) FROM evidence"), 4);
}

TEST_F(DamagedBackupTest, OtherFaultsAreStillReported) {
  Damage("evidence SET alpha = 1000 WHERE source_id = 1 AND " + HarbourGrid());
  Damage("scene_source SET scene_id = 3 - scene_id WHERE source_id = 1");
  EXPECT_TRUE(absl::IsDataLoss(BackUpStore(data_, file_).status()));
}

TEST_F(DamagedBackupTest, TheDaemonMakesBackupsAndReportsHowManyRowsTheyLack) {
  Damage("evidence SET alpha = 1000 WHERE source_id = 1 AND " + HarbourGrid());
  std::promise<absl::StatusOr<MadeBackup>> made;
  {
    AutomaticBackups backups(path_, {.patience = std::chrono::milliseconds(0)},
                             [&](const auto& backup) { made.set_value(backup); });
    const auto backup = made.get_future().get();
    ASSERT_TRUE(backup.ok()) << backup.status();
    EXPECT_EQ(backup->damaged_row_count, 1);
    EXPECT_EQ(VerifyStore(backup->file)->record_count, 3);
  }
  // Truncate the file, so that the daemon must use the backup.
  store_.reset();
  std::filesystem::resize_file(path_, 5'000);
  const auto opened = OpenStoreOrBackup(path_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_THAT(opened->damage, ::testing::HasSubstr("replaces it"));
  EXPECT_EQ(SumOf(*opened->store, Key("Grid")).source_count, 1u);
}

TEST_F(DamagedBackupTest, ASavedMisplacedStoreWithADamagedRowCanBeRestored) {
  Damage("evidence SET alpha = 1000 WHERE source_id = 1 AND " + HarbourGrid());
  std::filesystem::rename(path_, data_ / "moved");
  const auto saved = SaveMisplacedStore(*store_, path_);
  ASSERT_TRUE(saved.ok()) << saved.status();
  const auto contents = RestoreStore(*saved, other_);
  ASSERT_TRUE(contents.ok()) << contents.status();
  EXPECT_EQ(contents->record_count, 3);
}

}  // namespace
}  // namespace sweepstake::storage
