// A store is moved to PostgreSQL and back, completely or not at all.
#include "server/storage/postgres/postgres_migration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "server/storage/data_directory.h"
#include "server/storage/outbox/outbox.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/server/storage/postgres/temporary_postgres_store.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kLongAgoUnixS = 1'700'000'000;

fs::path DatabaseIn(const fs::path& directory) { return directory / DataDirectory::kDatabaseName; }

// A directory whose store contains sessions, counting and quarantined imports, a revoked source,
// and an audit log.
void Fill(const fs::path& directory) {
  const auto data = DataDirectory::Open(directory);
  ASSERT_TRUE(data.ok()) << data.status();
  const auto store = OpenSqlitePriorStore(data->database());
  ASSERT_TRUE(store.ok()) << store.status();
  SourceUpdate old = UpdateOf({"0.9", 3}, kLongAgoUnixS, "old",
                              {Key("Grid"), Key("SAP"), KeyIn("13/-4/0", "Grid")});
  ASSERT_TRUE((*store)->Commit(std::vector{old}).ok());
  std::vector<SourceUpdate> updates;
  for (int i = 1; i <= 7; ++i) {
    SourceUpdate update = UpdateOf({"1.0 \"é\"", i}, kLongAgoUnixS + 1000, "s" + std::to_string(i),
                                   {Key("Grid"), Key("arm \\ " + std::to_string(i % 3))});
    update.increments[0].evidence.alpha = 1e6 / (3 * i);
    update.audit = {.segment = 1,
                    .project = "game",
                    .scene = "harbour",
                    .unix_start_ms = 5,
                    .rows = {{1, "a,\"b\n\r\",ä😀\\"}, {2, "2"}}};
    updates.push_back(update);
  }
  ASSERT_TRUE((*store)->Commit(updates).ok());
  ASSERT_TRUE((*store)->Import(std::vector{Record("imported", 4, Key("Grid"), 9e14)}).ok());
  ASSERT_TRUE((*store)
                  ->Quarantine(std::vector{Record("waiting", 2, Key("Grid"), 1e5 / 3),
                                           Record("waiting", 2, Key("SAP", "quay"), 2)},
                               10)
                  .ok());
  ASSERT_TRUE((*store)->Revoke({.id = "s3"}, false).ok());
  ASSERT_TRUE((*store)->Revoke({.id = "barred"}, false).ok());
}

// All results that readers get from a store.
struct Seen {
  std::vector<PriorRecord> records;
  std::vector<PriorRecord> waiting;
  std::vector<priors::AuditSegment> segments;
  std::vector<priors::StoredAuditRow> rows;
  std::vector<priors::Evidence> sums;
  std::vector<uint64_t> source_counts;

  friend bool operator==(const Seen&, const Seen&) = default;
};

Seen See(PriorStore& store) {
  const auto page = *store.Export({}, {}, 1000);
  Seen seen{.records = page.records,
            .waiting = store.ExportQuarantined({}, {}, 1000)->records,
            .segments = *store.ListAudit({}, 0, 100),
            .rows = {},
            .sums = {},
            .source_counts = {}};
  for (const auto& segment : seen.segments) {
    const auto rows = *store.LoadAudit(segment.id, 1, 100, 1 << 20);
    seen.rows.insert(seen.rows.end(), rows.begin(), rows.end());
  }
  const auto scenes = *store.List({}, std::nullopt, 100);
  for (const auto& scene : scenes) {
    seen.source_counts.push_back(scene.source_count);
    for (const auto& arm : scene.arms) seen.sums.push_back(arm.live);
  }
  return seen;
}

Seen SeeIn(const fs::path& directory) { return See(**OpenSqlitePriorStore(DatabaseIn(directory))); }

// The progress reports of a migration, one per table, in order.
using Told = std::vector<std::string>;
OnMigrated TellTo(Told& told) {
  return [&told](const std::string& table, uint64_t rows, uint64_t of) {
    told.push_back(table + " " + std::to_string(rows) + "/" + std::to_string(of));
  };
}

const OnMigrated kNobody = [](const std::string&, uint64_t, uint64_t) {};

class PostgresMigration : public ::testing::Test {
 protected:
  PostgresMigration() : from_(directory_.path() / "from"), to_(directory_.path() / "to") {
    Fill(from_);
  }

  const test_support::TemporaryDirectory directory_;
  const fs::path from_;
  const fs::path to_;
  const std::string url_ = Server().NewDatabase();
};

TEST_F(PostgresMigration, AStoreIsEqualInPostgresAndAfterMovingBack) {
  const Seen before = SeeIn(from_);
  ASSERT_FALSE(before.records.empty());
  ASSERT_EQ(before.waiting.size(), 2u);
  Told told;
  const auto there = MigrateToPostgres(from_, url_, TellTo(told));
  ASSERT_TRUE(there.ok()) << there.status();
  EXPECT_EQ(See(*OpenStore(url_)), before);
  EXPECT_THAT(told, ::testing::Contains("quarantined_evidence 2/2"));
  Told told_back;
  const auto back = MigrateFromPostgres(url_, to_, TellTo(told_back));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(SeeIn(to_), before);
  EXPECT_EQ(told_back, told);
  EXPECT_EQ(back->record_count, there->record_count);
  EXPECT_EQ(back->damaged_row_count, 0);
  EXPECT_FALSE(fs::exists(to_.string() + ".migration"));
}

TEST_F(PostgresMigration, SessionsContinueAndRevokedSourcesStayRevoked) {
  ASSERT_TRUE(MigrateToPostgres(from_, url_, kNobody).ok());
  const auto store = OpenStore(url_);
  const auto session = *store->LoadSource("s1");
  ASSERT_TRUE(session);
  EXPECT_EQ(session->progress, Update("s1", 1, {}).progress);
  SourceUpdate next = Update("s1", 2, {Key("Grid")});
  next.writer = {.id = 5, .resumed_sequence = 1};
  ASSERT_TRUE(store
                  ->Commit(std::vector{next, Update("s3", 2, {Key("Grid")}),
                                       Update("barred", 1, {Key("Grid")}),
                                       Update("new", 1, {Key("Grid"), Key("new arm", "new")})})
                  .ok());
  EXPECT_EQ((*store->LoadSource("s1"))->progress.commit_sequence, 2u);
  EXPECT_EQ(*store->LoadSource("s3"), std::nullopt);
  EXPECT_EQ(*store->LoadSource("barred"), std::nullopt);
  EXPECT_NE(*store->LoadSource("new"), std::nullopt);
  EXPECT_EQ(store->Revoke({.build = "0.9"}, false)->record_count, 3u);
  EXPECT_EQ(store->Promote({}, false)->record_count, 2u);
}

TEST_F(PostgresMigration, IsRefusedWhileUpdatesWaitForASharedStore) {
  for (const fs::path& directory : {from_, to_}) {
    ASSERT_TRUE(DataDirectory::Open(directory).ok());
    ASSERT_TRUE(Outbox::Open(directory / DataDirectory::kOutboxName)
                    ->Replace(std::vector{Update("late", 1, {Key("Grid")})})
                    .ok());
  }
  EXPECT_TRUE(absl::IsFailedPrecondition(MigrateToPostgres(from_, url_, kNobody).status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(MigrateFromPostgres(url_, to_, kNobody).status()));
  EXPECT_FALSE(fs::exists(DatabaseIn(to_)));
}

TEST_F(PostgresMigration, AnExistingStoreIsNotOverwritten) {
  ASSERT_TRUE(OpenStore(url_)->Commit(std::vector{Update("mine", 1, {Key("Grid")})}).ok());
  const auto refused = MigrateToPostgres(from_, url_, kNobody);
  EXPECT_TRUE(absl::IsAlreadyExists(refused.status())) << refused.status();
  EXPECT_EQ(OpenStore(url_)->Export({}, {}, 100)->records.size(), 1u);
  const Seen before = SeeIn(from_);
  const OnMigrated never = [](const std::string& table, uint64_t, uint64_t) {
    ADD_FAILURE() << table << " was copied although the migration was refused";
  };
  EXPECT_TRUE(absl::IsAlreadyExists(MigrateFromPostgres(url_, from_, never).status()));
  EXPECT_EQ(SeeIn(from_), before);
  const auto in_use = DataDirectory::Open(to_);
  ASSERT_TRUE(in_use.ok());
  EXPECT_TRUE(absl::IsUnavailable(MigrateFromPostgres(url_, to_, never).status()));
}

}  // namespace
}  // namespace sweepstake::storage
