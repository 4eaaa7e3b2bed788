// Tests backups that the daemon makes automatically, and the start from one of them.
#include "server/storage/backup/automatic_backup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <future>

#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/commit_mark.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/server/storage/without_links.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

// Records the names that a folder gets (+) and loses (-), in order.
class FolderEvents {
 public:
  explicit FolderEvents(const std::filesystem::path& folder)
      : descriptor_(inotify_init1(IN_NONBLOCK)) {
    inotify_add_watch(descriptor_, folder.c_str(),
                      IN_CREATE | IN_DELETE | IN_MOVED_FROM | IN_MOVED_TO);
  }
  ~FolderEvents() { close(descriptor_); }
  FolderEvents(const FolderEvents&) = delete;
  FolderEvents& operator=(const FolderEvents&) = delete;

  std::vector<std::string> Take() const {
    std::vector<std::string> names;
    alignas(inotify_event) std::array<char, 64 * 1024> bytes;
    for (ssize_t size = 0; (size = read(descriptor_, bytes.data(), bytes.size())) > 0;) {
      for (const char* next = bytes.data(); next < bytes.data() + size;) {
        const auto* event = reinterpret_cast<const inotify_event*>(next);
        const bool is_new = (event->mask & (IN_CREATE | IN_MOVED_TO)) != 0;
        names.push_back((is_new ? "+" : "-") + std::string(event->name));
        next += sizeof(inotify_event) + event->len;
      }
    }
    return names;
  }

 private:
  const int descriptor_;
};

class AutomaticBackupTest : public ::testing::Test {
 protected:
  void Commit(uint64_t n) {
    ASSERT_TRUE(
        (*OpenSqlitePriorStore(path_))->Commit(std::vector{Update("a", n, {Key("Grid")})}).ok());
  }
  void BackUp(const std::string& time) {
    const auto made = BackUpStore(directory_.path(), path_.string() + ".backup-" + time);
    ASSERT_TRUE(made.ok()) << made.status();
  }
  // Overwrites a page of the file.
  static void Damage(const std::filesystem::path& path) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(4096);
    file << std::string(4096, '\x5a');
  }
  size_t CountFiles(const std::string& part) {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(directory_.path()))
      count += entry.path().filename().string().find(part) != std::string::npos;
    return count;
  }
  size_t RemoveFiles(const std::string& part) {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(directory_.path()))
      if (entry.path().filename().string().find(part) != std::string::npos)
        found.push_back(entry.path());
    for (const auto& path : found) std::filesystem::remove(path);
    return found.size();
  }
  static uint64_t CommitOf(PriorStore& store) {
    const auto source = *store.LoadSource("a");
    return source ? source->progress.commit_sequence : 0;
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path path_ = directory_.path() / "priors.db";
};

TEST_F(AutomaticBackupTest, AnOlderCopyInPlaceOfTheDatabaseIsReported) {
  Commit(1);
  std::filesystem::copy_file(path_, directory_.path() / "older.db");
  Commit(2);
  Commit(3);
  {
    const auto opened = OpenStoreOrBackup(path_);
    CommitMark(path_).Write(*CountCommits(*opened->store));
    EXPECT_EQ(opened->damage, "");
  }
  EXPECT_EQ(OpenStoreOrBackup(path_)->damage, "");
  std::filesystem::rename(directory_.path() / "older.db", path_);
  EXPECT_THAT(OpenStoreOrBackup(path_)->damage, HasSubstr("lacks 2 commits that it had before"));
}

TEST_F(AutomaticBackupTest, ADamagedFileIsKeptAndReplacedByTheLastIntactBackup) {
  Commit(1);
  BackUp("20260101T000000Z");
  Commit(2);
  BackUp("20260102T000000Z");
  Commit(3);
  BackUp("20260103T000000Z");
  Damage(path_.string() + ".backup-20260103T000000Z");
  Damage(path_);
  const auto opened = OpenStoreOrBackup(path_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_EQ(CommitOf(*opened->store), 2u);
  EXPECT_THAT(opened->damage, HasSubstr("priors.db.backup-20260102T000000Z replaces it"));
  EXPECT_THAT(opened->damage,
              HasSubstr("The damaged file is kept as " + path_.string() + ".quarantine-"));
  EXPECT_THAT(opened->damage, HasSubstr("Check the disk"));
  EXPECT_EQ(CountFiles(".quarantine-"), 1u);
  EXPECT_EQ(CountFiles(".backup-"), 3u);
  const auto read = [&] {
    const uint64_t commit = (*opened->reads->Begin().LoadSource("a"))->progress.commit_sequence;
    opened->reads->End();
    return commit;
  };
  EXPECT_EQ(read(), 2u) << "reads use the restored file";
  EXPECT_TRUE(opened->store->Commit(std::vector{Update("a", 3, {Key("Grid")})}).ok());
  EXPECT_EQ(read(), 3u);
}

TEST_F(AutomaticBackupTest, TheDamagedFileIsKeptUnchangedBeforeTheBackupReplacesIt) {
  Commit(1);
  BackUp("20260101T000000Z");
  Damage(path_);
  const std::string damaged = test_support::FileText(path_);
  const FolderEvents events(directory_.path());
  const auto opened = OpenStoreOrBackup(path_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  const std::vector<std::string> names = events.Take();
  const auto kept = std::find_if(names.begin(), names.end(), [](const std::string& name) {
    return name.starts_with("+priors.db.quarantine-");
  });
  const auto published = std::find(names.begin(), names.end(), "+priors.db");
  ASSERT_NE(published, names.end());
  EXPECT_LT(kept, published) << "a crash in between must not lose the damaged file";
  EXPECT_THAT(names, ::testing::Not(::testing::Contains("-priors.db")));
  EXPECT_EQ(test_support::FileText(directory_.path() / kept->substr(1)), damaged);
}

TEST_F(AutomaticBackupTest, WithoutHardLinksTheDamagedFileIsKeptAsACopy) {
  Commit(1);
  BackUp("20260101T000000Z");
  Damage(path_);
  const std::string damaged = test_support::FileText(path_);
  const auto opened = WithoutLinks([&] {
    const auto store = OpenStoreOrBackup(path_);
    return store.ok() && CommitOf(*store->store) == 1;
  });
  if (!opened) GTEST_SKIP() << "this kernel cannot disable hard links for a process";
  EXPECT_TRUE(*opened);
  EXPECT_EQ(CountFiles(".quarantined"), 0u);
  size_t kept = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory_.path()))
    kept += entry.path().filename().string().starts_with("priors.db.quarantine-") &&
            test_support::FileText(entry.path()) == damaged;
  EXPECT_EQ(kept, 1u);
}

TEST_F(AutomaticBackupTest, AnEmptyFileAndANonDatabaseAreReplacedToo) {
  Commit(1);
  BackUp("20260101T000000Z");
  for (const size_t size : {0, 9'999}) {
    std::ofstream(path_, std::ios::trunc) << std::string(size, 'x');
    const auto opened = OpenStoreOrBackup(path_);
    ASSERT_TRUE(opened.ok()) << opened.status();
    EXPECT_EQ(CommitOf(*opened->store), 1u);
    EXPECT_GE(RemoveFiles(".quarantine-"), 1u) << size;
  }
}

TEST_F(AutomaticBackupTest, WithoutAnIntactBackupNothingIsChanged) {
  Commit(1);
  BackUp("20260101T000000Z");
  Damage(path_.string() + ".backup-20260101T000000Z");
  Damage(path_);
  const absl::Status status = OpenStoreOrBackup(path_).status();
  EXPECT_TRUE(absl::IsDataLoss(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("no undamaged backup priors.db.backup-*"));
  EXPECT_EQ(CountFiles("quarantine"), 0u);
  EXPECT_EQ(CountFiles("restored"), 0u);
}

TEST_F(AutomaticBackupTest, AMissingOrForeignFileIsNotReplaced) {
  Commit(1);
  BackUp("20260101T000000Z");
  std::filesystem::remove(path_);
  EXPECT_THAT(std::string(OpenStoreOrBackup(path_).status().message()),
              HasSubstr("shows that it existed"));
  ASSERT_TRUE(SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kCreate)
                  ->Execute("CREATE TABLE other (x)")
                  .ok());
  EXPECT_THAT(std::string(OpenStoreOrBackup(path_).status().message()),
              HasSubstr("not a Sweepstake database"));
  EXPECT_EQ(CountFiles("quarantine"), 0u);
}

// Follows the advice in the error about a database file that is lost, empty, damaged or of another
// program.
class LostStoreTest : public AutomaticBackupTest, public ::testing::WithParamInterface<int> {
 protected:
  void Lose() {
    if (GetParam() == 0) std::filesystem::remove(path_);
    if (GetParam() == 1) std::filesystem::resize_file(path_, 0);
    if (GetParam() == 2) Damage(path_);
    if (GetParam() == 3) std::ofstream(path_) << std::string(5'000, 'x');
  }
  void MoveAway() {
    for (const char* end : {"", "-wal", "-shm"}) {
      const auto file = path_.string() + end;
      if (std::filesystem::exists(file)) std::filesystem::rename(file, file + ".away");
    }
  }
};

TEST_P(LostStoreTest, TheAdviceLeadsToARestoredOrANewStore) {
  Commit(1);
  const auto copy = directory_.path() / "copy.db";
  ASSERT_TRUE(BackUpStore(directory_.path(), copy).ok());
  for (const bool restores : {true, false}) {
    Lose();
    const absl::Status status = OpenStoreOrBackup(path_).status();
    EXPECT_TRUE(absl::IsDataLoss(status)) << status;
    const std::string advice(status.message());
    EXPECT_THAT(advice, HasSubstr("; move away those of priors.db, priors.db-wal and"));
    EXPECT_THAT(advice, HasSubstr("then restore a backup with `sweepstaked restore`, or"));
    EXPECT_THAT(advice, HasSubstr("/store-id too, to start with an empty store"));
    MoveAway();
    EXPECT_FALSE(OpenStoreOrBackup(path_).ok());
    if (restores) {
      ASSERT_TRUE(RestoreStore(copy, directory_.path()).ok());
    } else {
      std::filesystem::remove(directory_.path() / "store-id");
    }
    const auto opened = OpenStoreOrBackup(path_);
    ASSERT_TRUE(opened.ok()) << opened.status();
    EXPECT_EQ(opened->damage, "");
    EXPECT_EQ(opened->store->List({}, std::nullopt, 9)->size(), restores ? 1u : 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Losses, LostStoreTest, ::testing::Range(0, 4));

TEST_F(AutomaticBackupTest, ReportsRowsWithWrongHashes) {
  Commit(1);
  EXPECT_EQ(OpenStoreOrBackup(path_)->damage, "");
  ASSERT_TRUE(SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting)
                  ->Execute("UPDATE evidence SET alpha = 9; UPDATE scene SET source_count = 8")
                  .ok());
  const auto opened = OpenStoreOrBackup(path_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_THAT(opened->damage, HasSubstr("2 rows of"));
  EXPECT_THAT(opened->damage, HasSubstr("restore a backup"));
}

TEST_F(AutomaticBackupTest, BacksUpAStoreInUseAndRemovesTheOldestBackups) {
  const auto store = *OpenSqlitePriorStore(path_);
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  for (const char* time : {"20260101T000000Z", "20260102T000000Z", "20260103T000000Z"})
    BackUp(time);
  const auto long_ago = std::filesystem::file_time_type::clock::now() - std::chrono::hours(48);
  std::filesystem::last_write_time(path_.string() + ".backup-20260103T000000Z", long_ago);
  for (const char* end : {".new", ".new-journal"})
    std::ofstream(path_.string() + ".backup-20260104T000000Z" + end) << "left by a killed daemon";
  std::promise<absl::StatusOr<MadeBackup>> made;
  {
    AutomaticBackups backups(path_, {.interval = std::chrono::hours(24), .count = 2},
                             [&](const auto& file) { made.set_value(file); });
    const auto file = made.get_future().get();
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_EQ(VerifyStore(file->file)->record_count, 1);
    EXPECT_EQ(file->damaged_row_count, 0);
  }
  EXPECT_EQ(CountFiles(".backup-"), 2u);
  EXPECT_TRUE(std::filesystem::exists(path_.string() + ".backup-20260103T000000Z"));
  EXPECT_GT(*LastBackupTime(path_), long_ago);
}

// The wall clock was years ahead when the first backup was made.
TEST_F(AutomaticBackupTest, AWrongWallClockDoesNotChangeTheOrderOfBackups) {
  Commit(1);
  BackUp("000009-20990101T000000Z");
  Commit(2);
  const auto long_ago = std::filesystem::file_time_type::clock::now() - std::chrono::hours(48);
  std::filesystem::last_write_time(path_.string() + ".backup-000009-20990101T000000Z", long_ago);
  std::promise<absl::StatusOr<MadeBackup>> made;
  {
    AutomaticBackups backups(path_, {.interval = std::chrono::hours(24), .count = 1},
                             [&](const auto& file) { made.set_value(file); });
    ASSERT_TRUE(made.get_future().get().ok());
  }
  EXPECT_EQ(CountFiles(".backup-"), 1u);
  EXPECT_EQ(CountFiles(".backup-000010-"), 1u);
  Damage(path_);
  const auto opened = OpenStoreOrBackup(path_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_EQ(CommitOf(*opened->store), 2u);
}

TEST_F(AutomaticBackupTest, AFileThatReplacedTheStoreIsNotBackedUp) {
  Commit(1);
  std::promise<absl::StatusOr<MadeBackup>> made;
  {
    std::atomic<bool> told = false;
    const FileId other = *FileId::Of(directory_.path());
    AutomaticBackups backups(path_, {.patience = milliseconds(0), .file = other},
                             [&](const auto& file) {
                               if (!told.exchange(true)) made.set_value(file);
                             });
    EXPECT_TRUE(absl::IsUnavailable(made.get_future().get().status()));
  }
  EXPECT_EQ(CountFiles("backup"), 0u);
}

TEST_F(AutomaticBackupTest, AFailedBackupIsReportedAndLeavesNoFile) {
  std::promise<absl::StatusOr<MadeBackup>> made;
  {
    std::atomic<bool> told = false;
    AutomaticBackups backups(path_, {.patience = milliseconds(0)}, [&](const auto& file) {
      if (!told.exchange(true)) made.set_value(file);
    });
    EXPECT_TRUE(absl::IsNotFound(made.get_future().get().status()));
  }
  EXPECT_EQ(CountFiles("backup"), 0u);
}

TEST_F(AutomaticBackupTest, ACopyCanBeCancelled) {
  Commit(1);
  const std::atomic<bool> stop = true;
  const auto file = directory_.path() / "copy.db";
  EXPECT_TRUE(absl::IsCancelled(BackUpStore(directory_.path(), file, &stop).status()));
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(CountFiles(".new"), 0u);
}

}  // namespace
}  // namespace sweepstake::storage
