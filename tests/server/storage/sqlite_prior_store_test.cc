// Tests the properties of the SQLite store that concern its file.
#include "server/storage/sqlite_prior_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <atomic>
#include <fstream>

#include "engine_client/decider/pooling/source_choice.h"
#include "server/storage/backup/automatic_backup.h"
#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/data_directory.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_schema.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/server/storage/instruction_counter.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

using ::testing::HasSubstr;

class SqlitePriorStoreTest : public ::testing::Test {
 protected:
  std::string OpenError() { return std::string(OpenSqlitePriorStore(path_).status().message()); }
  void Execute(const std::string& sql) {
    auto database = SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kCreate);
    ASSERT_TRUE(database.ok());
    ASSERT_TRUE(database->Execute(sql).ok());
  }
  int64_t QueryInteger(const std::string& sql) {
    return *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting)
                ->QueryInteger(sql);
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path path_ = directory_.path() / "priors.db";
};

TEST_F(SqlitePriorStoreTest, EvidenceIsKeptAfterReopening) {
  {
    auto store = *OpenSqlitePriorStore(path_);
    ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  }
  auto store = *OpenSqlitePriorStore(path_);
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  EXPECT_EQ(LoadSums(*store, {Key("Grid")})->sums[0].evidence.window_count, 1u);
}

TEST_F(SqlitePriorStoreTest, ACommitIsOneTimedFsync) {
  std::vector<std::chrono::nanoseconds> durations;
  auto store = *OpenSqlitePriorStore(path_, {}, 0, [&](auto taken) { durations.push_back(taken); });
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  durations.clear();  // The first commit also syncs the header of a new log.
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 2, {Key("Grid")})}).ok());
  ASSERT_EQ(durations.size(), 1u);
  EXPECT_GT(durations[0].count(), 0);
}

// Sets `stop` when the store starts its n-th statement after Begin. Counts the statements of every
// SQLite connection that is opened while this object lives.
class StopAtStatement {
 public:
  StopAtStatement() { sqlite3_auto_extension(reinterpret_cast<void (*)()>(&Attach)); }
  ~StopAtStatement() { sqlite3_reset_auto_extension(); }

  void Begin(int n) {
    stop = false;
    left_ = n;
  }

  static inline std::atomic<bool> stop = false;

 private:
  static int Attach(sqlite3* database, char** /*error*/, const sqlite3_api_routines* /*api*/) {
    const auto count = [](unsigned /*event*/, void* /*context*/, void* /*statement*/,
                          void* /*text*/) {
      if (--left_ == 0) stop = true;
      return 0;
    };
    return sqlite3_trace_v2(database, SQLITE_TRACE_STMT, count, nullptr);
  }
  static inline int left_ = 0;
};

TEST_F(SqlitePriorStoreTest, AnImportThatIsStoppedAtAnyStatementChangesNothing) {
  StopAtStatement at;
  const auto store = *OpenSqlitePriorStore(path_);
  store->StopChangesWhen(StopAtStatement::stop);
  const std::vector records{Record("a", 1, Key("Grid"), 1.0), Record("b", 1, Key("SAP"), 1.0),
                            Record("b", 1, Key("SAP", "quay"), 1.0)};
  int n = 1;
  for (at.Begin(n); absl::IsCancelled(store->Import(records).status()); at.Begin(++n)) {
    at.Begin(0);
    EXPECT_TRUE(store->Export({}, {}, 10)->records.empty()) << n;
    EXPECT_EQ(store->CountScenes("game")->keys, 0u) << n;
    EXPECT_EQ(QueryInteger("SELECT count(*) FROM source"), 0) << n;
  }
  EXPECT_GT(n, 10);
  EXPECT_EQ(store->Export({}, {}, 10)->records.size(), records.size());
}

TEST_F(SqlitePriorStoreTest, AStoreWhoseFileWasCutAcceptsNothing) {
  const auto store = *OpenSqlitePriorStore(path_);
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  ASSERT_TRUE(store->CheckPlace().ok());
  std::filesystem::resize_file(path_, 0);
  EXPECT_TRUE(absl::IsNotFound(store->CheckPlace()));
  EXPECT_THAT(std::string(store->CheckPlace().message()), HasSubstr(path_.string() + " was cut"));
  EXPECT_TRUE(absl::IsUnavailable(store->Commit(std::vector{Update("a", 2, {Key("Grid")})})));
}

// A store in use whose database file or log is moved away. A copy may replace it.
class MisplacedStoreTest : public SqlitePriorStoreTest,
                           public ::testing::WithParamInterface<std::pair<const char*, bool>> {
 protected:
  MisplacedStoreTest() : store_(*OpenSqlitePriorStore(path_)) {
    EXPECT_TRUE(store_->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
    EXPECT_TRUE(store_->CheckPlace().ok());
    const auto& [suffix, is_replaced] = GetParam();
    file_ = path_.string() + suffix;
    std::filesystem::rename(file_, moved_);
    if (is_replaced) std::filesystem::copy(moved_, file_);
  }

  std::unique_ptr<PriorStore> store_;
  std::filesystem::path file_;
  std::filesystem::path moved_ = directory_.path() / "moved";
};

TEST_P(MisplacedStoreTest, AcceptsNothingUntilTheFileIsBack) {
  const std::vector update{Update("a", 2, {Key("Grid")})};
  EXPECT_TRUE(absl::IsNotFound(store_->CheckPlace()));
  EXPECT_THAT(std::string(store_->CheckPlace().message()), HasSubstr(file_.string() + " was re"));
  EXPECT_TRUE(absl::IsUnavailable(store_->Commit(update)));
  EXPECT_TRUE(absl::IsUnavailable(
      store_->Import(std::vector{Record("file", 1, Key("Grid"), 1.0)}).status()));
  EXPECT_TRUE(absl::IsUnavailable(store_->Revoke({.id = "a"}, false).status()));
  std::filesystem::rename(moved_, file_);
  EXPECT_TRUE(store_->CheckPlace().ok());
  EXPECT_TRUE(store_->Commit(update).ok());
  EXPECT_EQ(LoadSums(*store_, {Key("Grid")})->sums[0].evidence.window_count, 2u);
}

TEST_P(MisplacedStoreTest, IsSavedCompletelyAndLeavesAnEmptyLog) {
  const auto saved = SaveMisplacedStore(*store_, path_);
  ASSERT_TRUE(saved.ok()) << saved.status();
  EXPECT_THAT(saved->filename().string(), ::testing::StartsWith("priors.db.backup-"));
  EXPECT_EQ(VerifyStore(*saved)->record_count, 1);
  const bool is_log = file_ != path_;
  const std::filesystem::path log =
      is_log ? moved_ : std::filesystem::path(path_.string() + "-wal");
  EXPECT_EQ(std::filesystem::file_size(log), 0u) << "another file must not inherit the log";
  const std::filesystem::path database = is_log ? path_ : moved_;
  store_.reset();
  EXPECT_EQ(VerifyStore(database)->record_count, 1) << "the moved file is whole by itself";
}

INSTANTIATE_TEST_SUITE_P(Each, MisplacedStoreTest,
                         ::testing::Values(std::pair("", false), std::pair("", true),
                                           std::pair("-wal", false), std::pair("-wal", true)));

TEST_F(SqlitePriorStoreTest, AStoreWhoseDirectoryWasRemovedIsSavedInANewOne) {
  const std::filesystem::path folder = directory_.path() / "data";
  std::filesystem::create_directory(folder);
  const auto store = *OpenSqlitePriorStore(folder / "priors.db");
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  std::filesystem::remove_all(folder);
  const auto saved = SaveMisplacedStore(*store, folder / "priors.db");
  ASSERT_TRUE(saved.ok()) << saved.status();
  EXPECT_EQ(VerifyStore(*saved)->record_count, 1);
}

TEST_F(SqlitePriorStoreTest, ANewFileHasOurApplicationId) {
  ASSERT_TRUE(OpenSqlitePriorStore(path_).ok());
  EXPECT_EQ(QueryInteger("PRAGMA application_id"), kSqliteApplicationId);
  EXPECT_EQ(QueryInteger("PRAGMA user_version"), 2);
}

TEST_F(SqlitePriorStoreTest, AnEmptyFileIsNeitherAdoptedNorChanged) {
  std::ofstream(path_).close();
  EXPECT_TRUE(absl::IsDataLoss(OpenSqlitePriorStore(path_).status()));
  EXPECT_THAT(OpenError(), HasSubstr("exists but is empty"));
  EXPECT_EQ(std::filesystem::file_size(path_), 0u);
}

TEST_F(SqlitePriorStoreTest, AFileThatIsNotADatabaseIsRefused) {
  std::ofstream(path_) << std::string(5000, 'x');
  EXPECT_THAT(OpenError(), HasSubstr("is not a Sweepstake database"));
  EXPECT_EQ(std::filesystem::file_size(path_), 5000u);
}

TEST_F(SqlitePriorStoreTest, AnotherProgramsDatabaseIsRefused) {
  Execute("CREATE TABLE evidence (x)");
  EXPECT_THAT(OpenError(), HasSubstr("is not a Sweepstake database"));
}

TEST_F(SqlitePriorStoreTest, AFileOfAnotherSchemaVersionIsRefusedAndNotChanged) {
  ASSERT_TRUE(OpenSqlitePriorStore(path_).ok());
  Execute("PRAGMA user_version = 11");
  EXPECT_TRUE(absl::IsFailedPrecondition(OpenSqlitePriorStore(path_).status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(VerifyStore(path_).status()));
  EXPECT_THAT(OpenError(),
              HasSubstr("has schema version 11, but this daemon reads only version 2"));
  EXPECT_EQ(QueryInteger("PRAGMA user_version"), 11);
}

TEST_F(SqlitePriorStoreTest, ALogWithoutItsFileIsRefused) {
  std::ofstream(path_.string() + "-wal") << "something";
  EXPECT_THAT(OpenError(), HasSubstr("is missing, but its write-ahead log"));
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(SqlitePriorStoreTest, AnUnfinishedFileIsReplaced) {
  std::ofstream(path_.string() + ".new") << "half a file";
  EXPECT_TRUE(OpenSqlitePriorStore(path_).ok());
  EXPECT_FALSE(std::filesystem::exists(path_.string() + ".new"));
}

TEST_F(SqlitePriorStoreTest, ADamagedFileIsRefused) {
  {
    auto store = *OpenSqlitePriorStore(path_);
    ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  }
  std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(4096);
  file << std::string(4096, '\x5a');
  file.close();
  EXPECT_TRUE(absl::IsDataLoss(OpenSqlitePriorStore(path_).status())) << OpenError();
}

TEST_F(SqlitePriorStoreTest, TheErrorNamesAMissingDirectory) {
  path_ = directory_.path() / "nowhere" / "priors.db";
  EXPECT_TRUE(absl::IsUnavailable(OpenSqlitePriorStore(path_).status()));
  EXPECT_THAT(OpenError(), HasSubstr("nowhere"));
}

TEST_F(SqlitePriorStoreTest, TheDatabaseSchemaRefusesInvalidEvidence) {
  ASSERT_TRUE(OpenSqlitePriorStore(path_).ok());
  auto database = *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting);
  ASSERT_TRUE(
      database
          .Execute(
              "INSERT INTO source VALUES (1, 'a', 1, 0, 1, 1, 0, 0, 0, 0, 0, 0, '', 0, '', '', 0);"
              "INSERT INTO scene VALUES (1, 'p', 's', '', 1, 1, 0, 0, '', 0);"
              "INSERT INTO evidence_key (project, scene, measured_by, arm, backend_version,"
              "  machine_class, reward_version, regime, scene_id, hash)"
              "VALUES ('p', 's', '', 'Grid', 1, '', 1, '', 1, 0);")
          .ok());
  for (const char* wrong : {"-1", "9e999", "1e15", "NULL", "'text'"}) {
    const std::string sql =
        std::string("INSERT INTO evidence VALUES (1, 1, 1, ") + wrong + ", 1, 1, 0, 0)";
    EXPECT_TRUE(absl::IsInvalidArgument(database.Execute(sql))) << wrong;
  }
  EXPECT_TRUE(absl::IsInvalidArgument(database.Execute("UPDATE source SET frame_count = -1")));
}

TEST_F(SqlitePriorStoreTest, ACommitThatFailsHalfwayChangesNothing) {
  auto store = *OpenSqlitePriorStore(path_);
  // The second table is missing: the first statement of the commit still works.
  Execute("DROP TABLE evidence");
  EXPECT_FALSE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  EXPECT_EQ(QueryInteger("SELECT count(*) FROM source"), 0);
  EXPECT_EQ(QueryInteger("SELECT count(*) FROM evidence_key"), 0);
}

TEST_F(SqlitePriorStoreTest, ADatabaseLockedByAnotherProgramIsUnavailable) {
  auto store = *OpenSqlitePriorStore(path_);
  auto other = *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting);
  ASSERT_TRUE(other.Execute("BEGIN IMMEDIATE").ok());
  EXPECT_TRUE(absl::IsUnavailable(store->Commit(std::vector{Update("a", 1, {Key("Grid")})})));
  ASSERT_TRUE(other.Execute("ROLLBACK").ok());
  EXPECT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
}

SourceUpdate Audited(const std::string& session, uint64_t n, uint64_t first_row, uint64_t count) {
  SourceUpdate update = Update(session, n, {Key("Grid")});
  update.audit = {.segment = 1, .project = "game", .scene = "harbour", .rows = {}};
  for (uint64_t i = first_row; i < first_row + count; ++i)
    update.audit.rows.push_back({.number = i, .bytes = "row"});
  return update;
}

TEST_F(SqlitePriorStoreTest, FailedAuditRowsLoseNoEvidenceAndLeaveAGap) {
  auto store = *OpenSqlitePriorStore(path_);
  ASSERT_TRUE(store->Commit(std::vector{Audited("a", 1, 1, 2)}).ok());
  Execute("ALTER TABLE audit_row RENAME TO gone");
  const absl::Status status =
      store->Commit(std::vector{Audited("a", 2, 3, 2), Audited("b", 1, 1, 3)});
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(LoadSums(*store, {Key("Grid")})->sums[0].evidence.window_count, 3u);
  EXPECT_EQ(store->losses().audit_row_count, 5u);
  Execute("ALTER TABLE gone RENAME TO audit_row");
  ASSERT_TRUE(store->Commit(std::vector{Audited("a", 3, 5, 1)}).ok());
  const auto segments = *store->ListAudit({}, 0, 9);
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].row_count, 3u);
  EXPECT_EQ(segments[0].lost_row_count, 2u);
  EXPECT_EQ(store->losses().audit_row_count, 5u);
}

TEST_F(SqlitePriorStoreTest, TheLimitsOfTheAuditLogHoldAfterReopening) {
  const priors::AuditLimits limits{.bytes = 24, .age_s = 100};
  ASSERT_TRUE((*OpenSqlitePriorStore(path_, limits))
                  ->Commit(std::vector{Audited("a", 1, 1, 5), Audited("b", 1, 1, 3)})
                  .ok());
  auto store = *OpenSqlitePriorStore(path_, limits);
  ASSERT_TRUE(store->Commit(std::vector{Audited("b", 2, 4, 1)}).ok());
  EXPECT_EQ(QueryInteger("SELECT count(*) FROM audit_row"), 4);
  EXPECT_EQ(QueryInteger("SELECT sum(byte_count) FROM audit_chunk"), 12);
  EXPECT_EQ(QueryInteger("SELECT count(*) FROM audit_segment"), 1);
}

TEST_F(SqlitePriorStoreTest, AChangedAgeLimitOfAuditRowsAppliesFromTheNextCommit) {
  const auto at = [](SourceUpdate update, uint64_t unix_s) {
    update.unix_time_s = unix_s;
    return std::vector{std::move(update)};
  };
  auto store = *OpenSqlitePriorStore(path_, {.age_s = 1'000, .steady_ns = FastSteadyNs});
  ASSERT_TRUE(store->Commit(at(Audited("a", 1, 1, 5), 1'000)).ok());
  ASSERT_TRUE(store->Commit(at(Audited("b", 1, 1, 3), 1'300)).ok());
  EXPECT_EQ(QueryInteger("SELECT count(*) FROM audit_row"), 8);
  ASSERT_TRUE(
      LimitStore(*store, {.age_s = 200, .steady_ns = FastSteadyNs}, /*max_bytes=*/1 << 30).ok());
  ASSERT_TRUE(store->Commit(at(Audited("b", 2, 4, 1), 1'301)).ok());
  EXPECT_EQ(QueryInteger("SELECT count(*) FROM audit_row"), 4);
}

// A wall clock that is two years ahead for one start, and then right again.
TEST_F(SqlitePriorStoreTest, AWrongWallClockRemovesNoAuditRows) {
  constexpr uint64_t kDayS = 86'400, kNow = 20'000 * kDayS;
  const auto commit = [&](const char* session, uint64_t unix_s) {
    SourceUpdate update = Audited(session, 1, 1, 5);
    update.unix_time_s = unix_s;
    return (*OpenSqlitePriorStore(path_))->Commit(std::vector{update});
  };
  ASSERT_TRUE(commit("a", kNow).ok());
  ASSERT_TRUE(commit("b", kNow + 730 * kDayS).ok());
  ASSERT_TRUE(commit("c", kNow + 730 * kDayS).ok()) << "a second start";
  ASSERT_TRUE(commit("d", kNow + kDayS).ok());
  EXPECT_EQ(QueryInteger("SELECT count(*) FROM audit_row"), 20);
}

TEST_F(SqlitePriorStoreTest, AFileAtItsMaximumSizeAcceptsNoNewEvidence) {
  uint64_t stored = 0;
  absl::Status status;
  const auto nth = [](uint64_t n) {
    const std::string name = std::to_string(n);
    return std::vector{Update("session " + name, 1, {Key("Grid", "scene " + name)})};
  };
  {
    auto store = *OpenSqlitePriorStore(path_, {}, /*max_bytes=*/1);
    while (stored < 1'000 && (status = store->Commit(nth(stored))).ok()) ++stored;
    EXPECT_TRUE(absl::IsUnavailable(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("the file has its maximum size"));
    EXPECT_FALSE(store->Commit(nth(stored)).ok());
    EXPECT_EQ(store->List({}, std::nullopt, 20'000)->size(), stored);
  }
  auto store = *OpenSqlitePriorStore(path_, {}, /*max_bytes=*/1 << 20);
  status = store->Commit(nth(stored));
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(store->List({}, std::nullopt, 20'000)->size(), stored + 1);
}

TEST_F(SqlitePriorStoreTest, RemovedDataIsNotInUseAlthoughTheFileKeepsItsSize) {
  auto store = *OpenSqlitePriorStore(path_, {.bytes = 1 << 20});
  const uint64_t empty_bytes = *UsedBytes(*store);
  SourceUpdate update = Audited("a", 1, 1, 500);
  for (auto& row : update.audit.rows) row.bytes.assign(1'000, 'x');
  ASSERT_TRUE(store->Commit(std::vector{update}).ok());
  EXPECT_GT(*UsedBytes(*store), empty_bytes + 500'000) << "already in the log";
  ASSERT_TRUE(LimitStore(*store, {.bytes = 1'000}, /*max_bytes=*/1 << 30).ok());
  EXPECT_LT(*UsedBytes(*store), empty_bytes + 100'000);
  store.reset();
  EXPECT_GT(std::filesystem::file_size(path_), 500'000u);
}

SourceUpdate WithLongRow(uint64_t n) {
  SourceUpdate update = Audited("a", n, n, 1);
  update.audit.rows[0].bytes.assign(1'000, 'x');
  return update;
}

TEST_F(SqlitePriorStoreTest, AFileAtItsMaximumSizeAcceptsEvidenceOfKnownSessionsWithoutAuditRows) {
  auto store = *OpenSqlitePriorStore(path_, {}, /*max_bytes=*/1);
  uint64_t n = 0;
  while (n < 1'000 && store->losses().audit_row_count < 5) {
    const absl::Status status = store->Commit(std::vector{WithLongRow(++n)});
    ASSERT_TRUE(status.ok()) << status;
  }
  EXPECT_EQ(store->losses().audit_row_count, 5u);
  EXPECT_EQ(LoadSums(*store, {Key("Grid")})->sums[0].evidence.window_count, n);
  EXPECT_EQ(store->ListAudit({}, 0, 9)->at(0).row_count, n - 5);
}

TEST_F(SqlitePriorStoreTest, AFileAtItsMaximumSizeReplacesOlderAuditRows) {
  {
    auto store = *OpenSqlitePriorStore(path_, {.bytes = 100'000});
    for (uint64_t n = 1; n <= 100; ++n)
      ASSERT_TRUE(store->Commit(std::vector{WithLongRow(n)}).ok());
  }
  auto store = *OpenSqlitePriorStore(path_, {.bytes = 50'000}, /*max_bytes=*/1);
  for (uint64_t n = 101; n <= 150; ++n)
    ASSERT_TRUE(store->Commit(std::vector{WithLongRow(n)}).ok());
  EXPECT_EQ(store->losses().audit_row_count, 0u);
  EXPECT_GT(store->ListAudit({}, 0, 9)->at(0).first_row, 90u);
}

TEST_F(SqlitePriorStoreTest, AFileAtItsMaximumSizeHasRoomAgainAfterItsAuditLogShrinks) {
  const auto nth = [](uint64_t n) {
    return std::vector{Update("new " + std::to_string(n), 1, {Key("Grid", std::to_string(n))})};
  };
  uint64_t stored = 0;
  {
    auto store = *OpenSqlitePriorStore(path_, {.bytes = 100'000});
    for (uint64_t n = 1; n <= 100; ++n)
      ASSERT_TRUE(store->Commit(std::vector{WithLongRow(n)}).ok());
    store = *OpenSqlitePriorStore(path_, {.bytes = 100'000}, /*max_bytes=*/1);
    while (stored < 1'000 && store->Commit(nth(stored)).ok()) ++stored;
    ASSERT_LT(stored, 1'000u);
  }
  auto store = *OpenSqlitePriorStore(path_, {.bytes = 50'000}, /*max_bytes=*/1);
  absl::Status status = store->Commit(nth(stored));
  EXPECT_TRUE(status.ok()) << status;
  while (stored < 1'000 && store->Commit(nth(stored)).ok()) ++stored;
  ASSERT_LT(stored, 1'000u);
  ASSERT_TRUE(LimitStore(*store, {.bytes = 10'000}, /*max_bytes=*/1).ok());
  status = store->Commit(nth(stored));
  EXPECT_TRUE(status.ok()) << "while the store is open: " << status;
}

TEST_F(SqlitePriorStoreTest, TheDatabaseSchemaRefusesInvalidAuditRows) {
  ASSERT_TRUE(OpenSqlitePriorStore(path_).ok());
  auto database = *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting);
  const std::string segment = "INSERT INTO audit_segment VALUES ";
  ASSERT_TRUE(database.Execute(segment + "(1, 'a', 1, 'p', 's', 0)").ok());
  for (const char* wrong : {"(2, '', 1, 'p', 's', 0)", "(2, 'a', 0, 'p', 's', 0)",
                            "(2, 'a', 2, '', 's', 0)", "(2, 'a', 1, 'p', 's', 0)"}) {
    EXPECT_FALSE(database.Execute(segment + wrong).ok()) << wrong;
  }
  const std::string row = "INSERT INTO audit_row VALUES ";
  ASSERT_TRUE(database.Execute(row + "(1, 1, 1, x'78')").ok());
  for (const char* wrong : {"(2, 1, 0, x'78')", "(2, 1, 2, x'')", "(2, 1, 2, NULL)",
                            "(2, 1, 2, 'x')", "(2, 1, 1, x'78')"}) {
    EXPECT_FALSE(database.Execute(row + wrong).ok()) << wrong;
  }
  EXPECT_FALSE(database.Execute("INSERT INTO audit_chunk VALUES (1, -1, 0)").ok());
  EXPECT_FALSE(database.Execute("INSERT INTO audit_chunk VALUES (1, 0, -1)").ok());
}

TEST_F(SqlitePriorStoreTest, AHelloVisitsEquallyManyRowsWithFewOrTenThousandSources) {
  InstructionCounter counter;
  auto store = *OpenSqlitePriorStore(path_);
  const auto teach = [&](int first, int end) {
    std::vector<SourceUpdate> updates;
    for (int i = first; i < end; ++i)
      updates.push_back(Update(std::to_string(i), 1, {Key("Grid"), Key("SAP")}));
    ASSERT_TRUE(store->Commit(updates).ok());
  };
  const auto read = [&](uint64_t source_count) {
    const auto keys = std::vector{Key("Grid"), Key("SAP")};
    EXPECT_EQ(LoadSums(*store, keys)->source_count, source_count);
    EXPECT_EQ((*store->LoadScene({"game", "harbour", "desktop", 1}))->source_count, source_count);
    EXPECT_EQ(store->List({}, std::nullopt, 10)->at(0).source_count, source_count);
  };
  // One more source than LoadSources uses.
  constexpr int kUsed = decision::kSourcesPerPlace * priors::kSourcesOfScene + 1;
  teach(0, kUsed);
  const uint64_t with_few = counter.During([&] { read(kUsed); });
  EXPECT_GT(with_few, 0u);
  teach(kUsed, 10'000);
  EXPECT_EQ(counter.During([&] { read(10'000); }), with_few);
}

TEST_F(SqlitePriorStoreTest, AHelloOfANewSceneVisitsNoRowsOfOtherProjects) {
  InstructionCounter counter;
  auto store = *OpenSqlitePriorStore(path_);
  const auto teach = [&](const std::string& project, int scene_count) {
    std::vector<SourceUpdate> updates;
    for (int i = 0; i < scene_count; ++i) {
      auto key = Key("Grid");
      key.project = project;
      key.scene = "scene " + std::to_string(i);
      updates.push_back(Update(project + std::to_string(i), 1, {key}));
    }
    ASSERT_TRUE(store->Commit(updates).ok());
  };
  const auto read = [&] {
    EXPECT_TRUE(store->List({"game", "a new one"}, std::nullopt, 1)->empty());
    EXPECT_EQ(store->List({"game", "scene 1"}, std::nullopt, 1)->size(), 1u);
    EXPECT_EQ(store->List({"game", ""}, std::nullopt, 10)->size(), 3u);
  };
  teach("game", 3);
  const uint64_t alone = counter.During(read);
  teach("before", 1'000);
  teach("later", 1'000);
  EXPECT_LT(counter.During(read), alone + 100);
}

TEST(DataDirectoryTest, IsCreatedWhenMissingAndLockedByOneDaemon) {
  const test_support::TemporaryDirectory temporary;
  const auto path = temporary.path() / "data";
  {
    auto first = DataDirectory::Open(path);
    ASSERT_TRUE(first.ok()) << first.status();
    EXPECT_EQ(first->database(), path / "priors.db");
    const absl::Status second = DataDirectory::Open(path).status();
    EXPECT_TRUE(absl::IsUnavailable(second));
    EXPECT_THAT(std::string(second.message()), HasSubstr("another daemon"));
  }
  EXPECT_TRUE(DataDirectory::Open(path).ok());
}

TEST(DataDirectoryTest, OnlyItsOwnerCanReadItWithAnyUmask) {
  const test_support::TemporaryDirectory temporary;
  const auto path = temporary.path() / "data";
  const auto mode = [](const std::filesystem::path& of) {
    return static_cast<unsigned>(std::filesystem::status(of).permissions());
  };
  const mode_t mask = umask(0);
  {
    const auto directory = DataDirectory::Open(path);
    const auto store = OpenSqlitePriorStore(directory->database());
    ASSERT_TRUE((*store)->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
    umask(mask);
    EXPECT_FALSE(directory->open_to_others());
    EXPECT_EQ(mode(path), 0700u);
    for (const char* file : {"priors.db", "priors.db-wal", "priors.db-shm"})
      EXPECT_EQ(mode(path / file), 0600u) << file;
  }
  std::filesystem::permissions(path, std::filesystem::perms(0755));
  std::filesystem::permissions(path / "priors.db", std::filesystem::perms(0644));
  EXPECT_TRUE(DataDirectory::Open(path)->open_to_others());
  EXPECT_EQ(mode(path), 0755u);
  EXPECT_EQ(mode(path / "priors.db"), 0600u);
}

TEST(DataDirectoryTest, AFileInItsPlaceIsAnError) {
  const test_support::TemporaryDirectory temporary;
  std::ofstream(temporary.path() / "data") << "x";
  EXPECT_TRUE(absl::IsUnavailable(DataDirectory::Open(temporary.path() / "data").status()));
  const auto said = [](const std::filesystem::path& path) {
    return std::string(DataDirectory::Open(path).status().message());
  };
  EXPECT_THAT(said(temporary.path() / "data"), HasSubstr("not a directory; move it away, or name"));
  EXPECT_THAT(said(temporary.path() / "nope" / "data"),
              HasSubstr("; make " + (temporary.path() / "nope").string() + " first, or name"));
}

}  // namespace
}  // namespace sweepstake::storage
