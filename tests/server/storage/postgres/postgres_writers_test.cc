// Several daemons write to one store in PostgreSQL, and servers and connections fail.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libpq-fe.h>

#include <algorithm>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/server/storage/postgres/temporary_postgres_store.h"

namespace sweepstake::storage {
namespace {

SourceUpdate UpdateBy(priors::SourceWriter writer, uint64_t n) {
  SourceUpdate update = Update("a", n, {Key("Grid")});
  update.writer = writer;
  return update;
}

uint64_t WindowsOf(PriorStore& store) {
  return LoadSums(store, {Key("Grid")})->sums[0].evidence.window_count;
}

// Runs SQL as an administrator would.
void RunSql(const std::string& url, const std::string& sql) {
  PGconn* connection = PQconnectdb(url.c_str());
  PGresult* result = PQexec(connection, sql.c_str());
  EXPECT_NE(PQresultStatus(result), PGRES_FATAL_ERROR) << PQerrorMessage(connection);
  PQclear(result);
  PQfinish(connection);
}

void EndConnections(const std::string& url) {
  RunSql(url,
         "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = "
         "current_database() AND pid <> pg_backend_pid()");
}

TEST(PostgresWriters, CommitsOfOneDaemonAreVisibleToTheOthers) {
  const std::string url = Server().NewDatabase();
  const auto first = OpenStore(url);
  const auto second = OpenStore(url);
  ASSERT_TRUE(first->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  ASSERT_TRUE(second->Commit(std::vector{Update("b", 1, {Key("Grid")})}).ok());
  EXPECT_EQ(WindowsOf(*first), 2u);
  EXPECT_EQ(first->Export({}, {}, 10)->records, second->Export({}, {}, 10)->records);
}

TEST(PostgresWriters, EachDaemonGetsTheScenesThatOthersHaveChanged) {
  const std::string url = Server().NewDatabase();
  const auto first = OpenStore(url);
  const auto second = OpenStore(url);
  const auto told = [&] {
    std::vector<std::string> scenes;
    const auto changed = *first->TakeChangedScenes();
    for (const SceneKey& scene : changed) scenes.push_back(scene.scene);
    return scenes;
  };
  EXPECT_EQ(told().size(), 0u);
  ASSERT_TRUE(second
                  ->Commit(std::vector{Update("a", 1, {Key("Grid"), Key("Grid", "quay")}),
                                       Update("b", 1, {Key("SAP", "abbey")})})
                  .ok());
  EXPECT_THAT(told(), ::testing::UnorderedElementsAre("harbour", "quay", "abbey"));
  EXPECT_EQ(told().size(), 0u) << "once";
  ASSERT_TRUE(second->Commit(std::vector{Update("a", 2, {Key("Grid", "quay")})}).ok());
  EXPECT_THAT(told(), ::testing::ElementsAre("quay"));
  ASSERT_TRUE(second->Revoke({.id = "b"}, false).ok());
  EXPECT_THAT(told(), ::testing::ElementsAre("abbey"));
}

TEST(PostgresWriters, AChangeCommittedAfterALaterOneIsReported) {
  const std::string url = Server().NewDatabase();
  const auto store = OpenStore(url);
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid"), Key("Grid", "quay")})}).ok());
  PGconn* slow = PQconnectdb(url.c_str());
  PQclear(PQexec(slow,
                 "BEGIN; UPDATE sweepstake.scene SET changed_in = pg_current_xact_id() WHERE scene "
                 "= 'quay'"));
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 2, {Key("Grid")})}).ok());
  EXPECT_EQ(store->TakeChangedScenes()->size(), 2u);
  PQclear(PQexec(slow, "COMMIT"));
  PQfinish(slow);
  const auto told = *store->TakeChangedScenes();
  EXPECT_TRUE(std::any_of(told.begin(), told.end(),
                          [](const SceneKey& scene) { return scene.scene == "quay"; }));
}

TEST(PostgresWriters, TheFirstOfTwoDaemonsThatContinueFromACommitWins) {
  const std::string url = Server().NewDatabase();
  const auto former = OpenStore(url);
  const auto later = OpenStore(url);
  ASSERT_TRUE(former->Commit(std::vector{UpdateBy({1, 0}, 1)}).ok());
  ASSERT_TRUE(later->Commit(std::vector{UpdateBy({2, 1}, 2)}).ok());
  const auto refused = former->Commit(std::vector{UpdateBy({1, 0}, 2)});
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_TRUE(absl::IsFailedPrecondition(former->Commit(std::vector{UpdateBy({1, 0}, 3)})));
  ASSERT_TRUE(later->Commit(std::vector{UpdateBy({2, 1}, 2)}).ok())
      << "the answer to this commit was lost";
  ASSERT_TRUE(later->Commit(std::vector{UpdateBy({2, 1}, 3)}).ok());
  EXPECT_EQ(WindowsOf(*former), 3u);
  ASSERT_TRUE(former->Commit(std::vector{UpdateBy({3, 3}, 4)}).ok())
      << "the client has returned to the first daemon";
  EXPECT_TRUE(absl::IsFailedPrecondition(later->Commit(std::vector{UpdateBy({2, 1}, 4)})));
  EXPECT_EQ(WindowsOf(*former), 4u);
}

TEST(PostgresWriters, ARefusedUpdateUndoesItsWholeCommit) {
  const std::string url = Server().NewDatabase();
  const auto store = OpenStore(url);
  ASSERT_TRUE(store->Commit(std::vector{UpdateBy({1, 0}, 1)}).ok());
  SourceUpdate good = Update("b", 1, {Key("Grid")});
  EXPECT_FALSE(store->Commit(std::vector{good, UpdateBy({2, 0}, 2)}).ok());
  EXPECT_EQ(WindowsOf(*store), 1u);
  EXPECT_EQ(*store->LoadSource("b"), std::nullopt);
}

TEST(PostgresWriters, ALostConnectionIsReopened) {
  const std::string url = Server().NewDatabase();
  const auto store = OpenStore(url);
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  EndConnections(url);
  EXPECT_TRUE(absl::IsUnavailable(store->Commit(std::vector{Update("a", 2, {Key("Grid")})})));
  EXPECT_TRUE(store->Commit(std::vector{Update("a", 2, {Key("Grid")})}).ok());
  EXPECT_EQ(WindowsOf(*store), 2u);
}

TEST(PostgresWriters, ADatabaseThatReplacedTheStoreIsNotWritten) {
  const std::string url = Server().NewDatabase();
  const auto store = OpenStore(url);
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  EndConnections(url);
  RunSql(url, "UPDATE sweepstake.store SET id = 'another'");
  for (int i = 0; i < 3; ++i)
    EXPECT_TRUE(absl::IsUnavailable(store->Commit(std::vector{Update("a", 2, {Key("Grid")})})));
}

TEST(PostgresWriters, TablesOfAnotherSchemaVersionAreRefused) {
  const std::string url = Server().NewDatabase();
  OpenStore(url);
  RunSql(url, "INSERT INTO sweepstake.schema_version VALUES (99)");
  const auto store = OpenPostgresPriorStore(url);
  EXPECT_TRUE(absl::IsFailedPrecondition(store.status())) << store.status();
  EXPECT_THAT(std::string(store.status().message()), ::testing::HasSubstr("schema version 99"));
}

TEST(PostgresWriters, AMissingServerIsUnavailable) {
  const auto store = OpenPostgresPriorStore("host=/nowhere user=sweepstake dbname=sweepstake");
  EXPECT_TRUE(absl::IsUnavailable(store.status())) << store.status();
}

// Does the work of one writer: commits updates of its own sources about keys that all writers
// share, in an order that depends on the seed. Repeats each commit until it succeeds.
void Write(const std::string& url, uint64_t seed, std::vector<SourceUpdate>& written) {
  auto store = OpenPostgresPriorStore(url);
  while (!store.ok()) store = OpenPostgresPriorStore(url);
  std::mt19937_64 random(seed);
  for (uint64_t n = 1; n <= 60; ++n) {
    std::vector<SourceUpdate> group;
    for (uint64_t i = 0; i < 3; ++i) {
      const uint64_t first = random() % 5;
      group.push_back(Update(std::to_string(seed) + "/" + std::to_string((i + n) % 7), n,
                             {Key("arm " + std::to_string(first)),
                              Key("arm " + std::to_string((first + 1 + random() % 4) % 5))}));
      // Thirds are rounded, so their sums depend on the order of addition.
      for (auto& increment : group.back().increments)
        increment.evidence.alpha = static_cast<double>(random() % 1'000'000) / 3;
    }
    while (!(*store)->Commit(group).ok()) std::this_thread::yield();
    written.insert(written.end(), group.begin(), group.end());
  }
}

TEST(PostgresWriters, SumsOfManyWritersEqualThoseOfOneInEveryBit) {
  const std::string url = Server().NewDatabase();
  std::vector<std::vector<SourceUpdate>> written(4);
  {
    std::vector<std::jthread> writers;
    for (size_t i = 0; i < written.size(); ++i)
      writers.emplace_back([&url, &written, i] { Write(url, i + 1, written[i]); });
    for (int i = 0; i < 5; ++i) EndConnections(url);
  }
  const auto memory = *OpenMemoryPriorStore();
  for (const auto& updates : written) ASSERT_TRUE(memory->Commit(updates).ok());
  const auto store = OpenStore(url);
  const auto summed = store->List({}, std::nullopt, 10)->at(0);
  const auto expected = memory->List({}, std::nullopt, 10)->at(0);
  EXPECT_EQ(summed.source_count, expected.source_count);
  ASSERT_EQ(summed.arms.size(), expected.arms.size());
  for (size_t i = 0; i < summed.arms.size(); ++i)
    EXPECT_EQ(summed.arms[i].live, expected.arms[i].live) << summed.arms[i].name;
}

TEST(PostgresWriters, AKilledServerLosesNoCommit) {
  test_support::PostgresServer server;
  const auto store = OpenStore(server.NewDatabase());
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  server.Kill();
  EXPECT_TRUE(absl::IsUnavailable(store->Commit(std::vector{Update("a", 2, {Key("Grid")})})));
  EXPECT_TRUE(absl::IsUnavailable(store->LoadSource("a").status()));
  server.Start();
  EXPECT_EQ(WindowsOf(*store), 1u);
  ASSERT_TRUE(store->Commit(std::vector{Update("a", 2, {Key("Grid")})}).ok());
  EXPECT_EQ(WindowsOf(*store), 2u);
}

}  // namespace
}  // namespace sweepstake::storage
