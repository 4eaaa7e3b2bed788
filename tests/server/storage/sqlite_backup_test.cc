// Tests backups: they are made while the store is written, verified and restored.
#include "server/storage/backup/sqlite_backup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "server/storage/data_directory.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

using ::testing::HasSubstr;

class SqliteBackupTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(data_);
    store_ = *OpenSqlitePriorStore(data_ / "priors.db");
    ASSERT_TRUE(store_
                    ->Commit(std::vector{Update("a", 1, {Key("Grid"), Key("SAP")}),
                                         Update("b", 1, {Key("Grid", "desert")})})
                    .ok());
  }
  void BackUp() { ASSERT_TRUE(BackUpStore(data_, file_).ok()); }
  std::vector<PriorRecord> Records(const std::filesystem::path& directory) {
    return (*OpenSqlitePriorStore(directory / "priors.db"))->Export({}, {}, 100)->records;
  }
  void Execute(const std::string& sql) {
    auto file = *SqliteDatabase::Open(file_.string(), SqliteDatabase::OpenMode::kExisting);
    ASSERT_TRUE(file.Execute(sql).ok());
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path data_ = directory_.path() / "data";
  std::filesystem::path file_ = directory_.path() / "copy.db";
  std::filesystem::path empty_ = directory_.path() / "empty";
  std::unique_ptr<PriorStore> store_;
};

TEST_F(SqliteBackupTest, ACopyOfAStoreInUseHasAllCommits) {
  auto writer =
      *SqliteDatabase::Open((data_ / "priors.db").string(), SqliteDatabase::OpenMode::kExisting);
  ASSERT_TRUE(writer.Execute("BEGIN IMMEDIATE; UPDATE source SET decision_count = 9").ok());
  const auto contents = BackUpStore(data_, file_);
  ASSERT_TRUE(contents.ok()) << contents.status();
  EXPECT_EQ(contents->record_count, 3);
  EXPECT_EQ(contents->source_count, 2);
  EXPECT_EQ(contents->scene_count, 2);
  EXPECT_FALSE(std::filesystem::exists(file_.string() + ".new"));
}

TEST_F(SqliteBackupTest, AlsoHasTokensAndResumeKeyAndARestoreWritesThem) {
  const auto content = [](const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  {
    auto tokens =
        *SqliteDatabase::Open((data_ / "tokens.db").string(), SqliteDatabase::OpenMode::kCreate);
    ASSERT_TRUE(
        tokens.Execute("CREATE TABLE token (name TEXT); INSERT INTO token VALUES ('a')").ok());
    std::ofstream(data_ / "tokens-made");
    std::ofstream(data_ / "resume-key", std::ios::binary) << std::string("\0key\xff", 5);
    BackUp();
  }
  ASSERT_TRUE(RestoreStore(file_, empty_).ok());
  EXPECT_EQ(content(empty_ / "resume-key"), std::string("\0key\xff", 5));
  EXPECT_TRUE(std::filesystem::exists(empty_ / "tokens-made"));
  auto tokens =
      *SqliteDatabase::Open((empty_ / "tokens.db").string(), SqliteDatabase::OpenMode::kReadOnly);
  EXPECT_EQ(*tokens.QueryText("SELECT name FROM token"), "a");
  struct stat found {};
  for (const char* name : {"tokens.db", "tokens-made", "resume-key"}) {
    ASSERT_EQ(stat((empty_ / name).c_str(), &found), 0);
    EXPECT_EQ(found.st_mode & 0777, 0600u) << name;
  }
  auto restored =
      *SqliteDatabase::Open((empty_ / "priors.db").string(), SqliteDatabase::OpenMode::kReadOnly);
  EXPECT_EQ(*restored.QueryInteger("SELECT count(*) FROM kept_file"), 0);
  EXPECT_FALSE(std::filesystem::exists(file_.string() + ".tokens"));
}

TEST_F(SqliteBackupTest, ARestoreKeepsTheFilesOfTheDirectory) {
  std::ofstream(data_ / "resume-key") << "old";
  BackUp();
  std::filesystem::create_directory(empty_);
  std::ofstream(empty_ / "resume-key") << "new";
  ASSERT_TRUE(RestoreStore(file_, empty_).ok());
  std::string key;
  std::ifstream(empty_ / "resume-key") >> key;
  EXPECT_EQ(key, "new");
}

// A backup from elsewhere must not write anywhere else.
TEST_F(SqliteBackupTest, ARestoreWritesOnlyFilesThatItKnows) {
  BackUp();
  Execute("INSERT INTO kept_file VALUES ('../stolen', x'00', row_hash('../stolen', x'00'))");
  ASSERT_TRUE(RestoreStore(file_, empty_).ok());
  EXPECT_FALSE(std::filesystem::exists(directory_.path() / "stolen"));
}

TEST_F(SqliteBackupTest, AForeignTriggerIsReported) {
  BackUp();
  Execute("CREATE TRIGGER foreign_one AFTER INSERT ON source BEGIN DELETE FROM audit_row; END");
  EXPECT_THAT(std::string(VerifyStore(file_).status().message()), HasSubstr("its schema is not"));
}

TEST_F(SqliteBackupTest, AChangedKeptFileIsReported) {
  std::ofstream(data_ / "resume-key") << "key";
  BackUp();
  Execute("UPDATE kept_file SET content = x'00'");
  EXPECT_THAT(std::string(VerifyStore(file_).status().message()),
              HasSubstr("1 rows were changed on the disk"));
}

TEST_F(SqliteBackupTest, WithDamagedTokensThereIsNoBackup) {
  std::ofstream(data_ / "tokens.db") << std::string(5'000, 'x');
  EXPECT_TRUE(absl::IsDataLoss(BackUpStore(data_, file_).status()));
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(SqliteBackupTest, ABackupOverwritesNoFile) {
  std::ofstream(file_) << "precious";
  EXPECT_TRUE(absl::IsAlreadyExists(BackUpStore(data_, file_).status()));
  EXPECT_EQ(std::filesystem::file_size(file_), 8u);
}

TEST_F(SqliteBackupTest, ADirectoryWithoutADatabaseHasNoBackup) {
  const absl::Status status = BackUpStore(empty_, file_).status();
  EXPECT_TRUE(absl::IsNotFound(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("--data"));
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(SqliteBackupTest, ARestoreBringsBackTheBackedUpStore) {
  BackUp();
  ASSERT_TRUE(store_->Commit(std::vector{Update("c", 1, {Key("Grid")})}).ok());
  const auto contents = RestoreStore(file_, empty_);
  ASSERT_TRUE(contents.ok()) << contents.status();
  EXPECT_EQ(contents->record_count, 3);
  EXPECT_EQ(Records(empty_).size(), 3u);
  EXPECT_EQ(Records(data_).size(), 4u);
}

TEST_F(SqliteBackupTest, FilesThatRootCreatesBelongToTheOwnerOfTheDirectory) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can create files for other users";
  std::filesystem::create_directory(empty_);
  ASSERT_EQ(chown(empty_.c_str(), 65534, 65534), 0);
  ASSERT_TRUE(BackUpStore(data_, empty_ / "copy.db").ok());
  ASSERT_TRUE(RestoreStore(empty_ / "copy.db", empty_).ok());
  for (const char* name : {"copy.db", "priors.db"}) {
    struct stat made {};
    ASSERT_EQ(stat((empty_ / name).c_str(), &made), 0);
    EXPECT_EQ(made.st_uid, 65534u) << name;
    EXPECT_EQ(made.st_gid, 65534u) << name;
  }
}

TEST_F(SqliteBackupTest, RefusesToRestoreIntoADirectoryWithADatabaseOrADaemon) {
  BackUp();
  EXPECT_TRUE(absl::IsAlreadyExists(RestoreStore(file_, data_).status()));
  const auto daemon = *DataDirectory::Open(empty_);
  EXPECT_THAT(std::string(RestoreStore(file_, empty_).status().message()),
              HasSubstr("another daemon"));
  EXPECT_FALSE(std::filesystem::exists(empty_ / "priors.db"));
}

TEST_F(SqliteBackupTest, ADamagedBackupIsReportedAndNotRestored) {
  BackUp();
  std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(4096);
  file << std::string(4096, '\x5a');
  file.close();
  EXPECT_TRUE(absl::IsDataLoss(VerifyStore(file_).status())) << VerifyStore(file_).status();
  EXPECT_TRUE(absl::IsDataLoss(RestoreStore(file_, empty_).status()));
  EXPECT_FALSE(std::filesystem::exists(empty_ / "priors.db"));
}

TEST_F(SqliteBackupTest, ReportsSumsThatDifferFromTheRows) {
  BackUp();
  Execute("UPDATE evidence SET alpha = alpha + 1 WHERE key_id = 1");
  Execute("UPDATE evidence SET hash = content_hash");
  EXPECT_THAT(std::string(VerifyStore(file_).status().message()), HasSubstr("1 sums differ"));
}

TEST_F(SqliteBackupTest, ReportsAWrongNumberOfSources) {
  BackUp();
  Execute("UPDATE scene SET source_count = source_count + 1");
  Execute("UPDATE scene SET hash = content_hash");
  EXPECT_THAT(std::string(VerifyStore(file_).status().message()), HasSubstr("2 scenes have a"));
}

TEST_F(SqliteBackupTest, ReportsSourcesThatDifferFromTheEvidence) {
  BackUp();
  Execute("UPDATE scene_source SET scene_id = 3 - scene_id");
  EXPECT_THAT(std::string(VerifyStore(file_).status().message()),
              HasSubstr("2 sources are missing in the list"));
  Execute("UPDATE scene_source SET scene_id = 3 - scene_id");
  EXPECT_TRUE(VerifyStore(file_).ok());
  Execute("INSERT INTO scene_source SELECT 1, id, 0, '' FROM scene WHERE scene = 'desert'");
  Execute("UPDATE scene SET source_count = 2 WHERE scene = 'desert'");
  Execute("UPDATE scene SET hash = content_hash");
  EXPECT_THAT(std::string(VerifyStore(file_).status().message()),
              HasSubstr("1 sources are listed for a scene"));
}

TEST_F(SqliteBackupTest, ReportsWrongParties) {
  BackUp();
  Execute("UPDATE scene_party SET latest_source_id = 99 WHERE scene_id = 1");
  EXPECT_THAT(std::string(VerifyStore(file_).status().message()),
              HasSubstr("2 parties of scenes have a wrong latest source"));
}

TEST_F(SqliteBackupTest, ReportsDanglingReferences) {
  BackUp();
  Execute("DELETE FROM source WHERE name = 'b'");
  EXPECT_THAT(std::string(VerifyStore(file_).status().message()),
              HasSubstr("refer to a row that does not exist"));
}

TEST_F(SqliteBackupTest, AForeignFileIsNotABackup) {
  std::ofstream(file_) << std::string(5000, 'x');
  EXPECT_TRUE(absl::IsDataLoss(VerifyStore(file_).status()));
  const absl::Status missing = VerifyStore(directory_.path() / "nowhere").status();
  EXPECT_TRUE(absl::IsNotFound(missing)) << missing;
  EXPECT_THAT(std::string(missing.message()), HasSubstr("nowhere: there is no such file"));
  ASSERT_EQ(mkfifo((directory_.path() / "pipe").c_str(), 0600), 0);
  const absl::Status pipe = VerifyStore(directory_.path() / "pipe").status();
  EXPECT_TRUE(absl::IsInvalidArgument(pipe)) << pipe << "; it must not wait for a writer";
}

}  // namespace
}  // namespace sweepstake::storage
