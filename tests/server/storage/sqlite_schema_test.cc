// Files of every older schema: what a daemon makes of them, and what it leaves of them.
#include "server/storage/sqlite_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

// The scripts of schemas/ up to the parameter make a file of that version.
class OlderSchemaTest : public ::testing::TestWithParam<int> {
 protected:
  OlderSchemaTest() {
    auto database = *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kCreate);
    for (int version = 1; version <= GetParam(); ++version) {
      std::ifstream script(std::string(SWEEPSTAKE_SCHEMAS_DIR) + "/" + std::to_string(version) +
                           ".sql");
      const std::string sql{std::istreambuf_iterator<char>(script), {}};
      const absl::Status status = database.Execute(sql);
      EXPECT_TRUE(status.ok()) << status;
    }
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path path_ = directory_.path() / "priors.db";
  std::filesystem::path copy_ = path_.string() + ".schema-" + std::to_string(GetParam());
};

TEST_P(OlderSchemaTest, HasItsSumsAfterTheMigration) {
  auto store = OpenSqlitePriorStore(path_);
  ASSERT_TRUE(store.ok()) << store.status();
  const auto sums = *LoadSums(**store, {Key("Grid"), Key("SAP"), Key("DBVT")});
  EXPECT_EQ(sums.sums[0].evidence, (priors::Evidence{7.0, 1.5, 7, 8}));
  EXPECT_EQ(sums.sums[0].source_count, 3u);
  EXPECT_EQ(sums.sums[1].evidence, (priors::Evidence{0.75, 0.25, 1, 0}));
  EXPECT_EQ(sums.sums[2].source_count, 0u);
  EXPECT_EQ(sums.source_count, 3u);
  const auto scenes = *(*store)->List({}, std::nullopt, 10);
  ASSERT_EQ(scenes.size(), 2u);
  ASSERT_EQ(scenes[0].arms.size(), 1u) << "nobody taught KDTree anything";
  EXPECT_EQ(scenes[0].arms[0].live, (priors::Evidence{100.875, 7.75, (1ull << 63) - 1, 2}));
  EXPECT_EQ(scenes[0].source_count, 2u);
  EXPECT_EQ(scenes[1].source_count, 3u);
}

TEST_P(OlderSchemaTest, IsWholeAfterTheMigrationAndBefore) {
  EXPECT_TRUE(VerifyStore(path_).ok()) << VerifyStore(path_).status();
  ASSERT_TRUE(OpenSqlitePriorStore(path_).ok());
  const auto contents = VerifyStore(path_);
  ASSERT_TRUE(contents.ok()) << contents.status();
  EXPECT_EQ(contents->schema_version, SqliteSchemaVersion());
  EXPECT_EQ(contents->record_count, 6);
}

TEST_P(OlderSchemaTest, HasNothingInQuarantineAfterTheMigration) {
  auto store = *OpenSqlitePriorStore(path_);
  EXPECT_TRUE(store->ExportQuarantined({}, {}, 9)->records.empty());
  EXPECT_EQ(store->Export({}, {}, 9)->records.size(), 6u);
  ASSERT_TRUE(store->Quarantine(std::vector{Record("new", 1, Key("Grid"), 4)}, 9).ok());
  EXPECT_EQ(store->ExportQuarantined({}, {}, 9)->records.size(), 1u);
}

TEST_P(OlderSchemaTest, GoesOnAfterTheMigration) {
  auto store = *OpenSqlitePriorStore(path_);
  EXPECT_EQ((*store->LoadSource("a"))->progress.commit_sequence, 3u);
  EXPECT_EQ(*store->LoadSource("b"), std::nullopt);
  SourceUpdate update = Update("a", 4, {Key("Grid"), Key("Grid", "desert")});
  update.audit = {
      .segment = 2, .project = "game", .scene = "harbour", .rows = {{.number = 1, .text = "row"}}};
  ASSERT_TRUE(store->Commit(std::vector{update}).ok());
  EXPECT_EQ(LoadSums(*store, {Key("Grid")})->sums[0].evidence.window_count, 8u);
  EXPECT_EQ((*store->LoadScene({"game", "desert", "desktop", 1}))->source_count, 3u);
  EXPECT_EQ(store->ListAudit({}, 0, 9)->size(), GetParam() == 1 ? 1u : 2u);
}

TEST_P(OlderSchemaTest, HasItsAuditLogAfterTheMigrationAndTrimsIt) {
  auto store = *OpenSqlitePriorStore(path_, {.bytes = 12});
  const auto segments = *store->ListAudit({}, 0, 9);
  ASSERT_EQ(segments.size(), GetParam() == 1 ? 0u : 1u);
  if (segments.empty()) return;
  EXPECT_EQ(segments[0].session_id, "a");
  EXPECT_EQ(segments[0].unix_start_ms, 1'800'000'000'000);
  EXPECT_EQ(segments[0].row_count, 2u);
  EXPECT_EQ(store->LoadAudit(segments[0].id, 2, 9, 99)->at(0).text, "row 2");
  SourceUpdate update = Update("a", 4, {});
  update.audit = {.segment = 1, .project = "game", .scene = "harbour", .rows = {}};
  update.audit.rows.push_back({.number = 3, .text = "row 3"});
  ASSERT_TRUE(store->Commit(std::vector{update}).ok());
  EXPECT_EQ(store->ListAudit({}, 0, 9)->at(0).first_row, 3u);
}

TEST_P(OlderSchemaTest, IsKeptAsItWasBesideTheNewOne) {
  ASSERT_TRUE(OpenSqlitePriorStore(path_).ok());
  auto copy = *SqliteDatabase::Open(copy_.string(), SqliteDatabase::OpenMode::kExisting);
  EXPECT_EQ(*copy.QueryInteger("PRAGMA user_version"), GetParam());
  EXPECT_EQ(*copy.QueryInteger("PRAGMA application_id"), kSqliteApplicationId);
  EXPECT_EQ(*copy.QueryInteger("SELECT count(*) FROM evidence"), 6);
  EXPECT_FALSE(std::filesystem::exists(copy_.string() + ".new"));
  EXPECT_FALSE(
      std::filesystem::exists(path_.string() + ".schema-" + std::to_string(SqliteSchemaVersion())));
}

TEST_P(OlderSchemaTest, IsNotChangedWhereItCannotBeKept) {
  std::filesystem::create_directory(copy_);
  EXPECT_TRUE(absl::IsUnavailable(OpenSqlitePriorStore(path_).status()));
  auto database = *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting);
  EXPECT_EQ(*database.QueryInteger("PRAGMA user_version"), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Schemas, OlderSchemaTest, ::testing::Range(1, 11));

}  // namespace
}  // namespace sweepstake::storage
