// Tests updates that wait for a shared store: they survive the daemon, and are committed once.
#include "server/storage/outbox/outbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "tests/server/storage/evidence_samples.h"
#include "tests/server/storage/forwarding_store.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class OutboxTest : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return directory_.path() / "outbox.db"; }
  Outbox Open() const { return Outbox::Open(path()).value(); }

  test_support::TemporaryDirectory directory_;
};

SourceUpdate FullUpdate() {
  SourceUpdate update = Update("one", 3, {Key("Grid"), Key("SAP", "Grübel \"1\"\\")});
  update.increments[0].evidence.alpha = 0.1 + 0.2;
  update.increments[0].evidence.beta = std::nextafter(1.0, 2.0);
  update.increments[1].key.measured_by = "lane";
  update.increments[1].key.regime = "13/-4/0";
  update.unix_time_s = 1'764'000'000;
  update.origin = {.build = "1.4", .token_id = -7};
  update.writer = {.id = std::numeric_limits<uint64_t>::max(), .resumed_sequence = 2};
  update.audit = {.segment = 2,
                  .project = "game",
                  .scene = "harbour",
                  .unix_start_ms = 5,
                  .rows = {{.number = 9, .bytes = std::string("\0\xff\n", 3)}}};
  return update;
}

void ExpectEqual(const SourceUpdate& left, const SourceUpdate& right) {
  EXPECT_EQ(left.progress, right.progress);
  EXPECT_EQ(left.unix_time_s, right.unix_time_s);
  EXPECT_EQ(left.increments, right.increments);
  EXPECT_EQ(left.origin, right.origin);
  EXPECT_EQ(left.writer.id, right.writer.id);
  EXPECT_EQ(left.writer.resumed_sequence, right.writer.resumed_sequence);
  EXPECT_EQ(left.audit.segment, right.audit.segment);
  EXPECT_EQ(left.audit.project, right.audit.project);
  EXPECT_EQ(left.audit.scene, right.audit.scene);
  EXPECT_EQ(left.audit.unix_start_ms, right.audit.unix_start_ms);
  EXPECT_EQ(left.audit.rows, right.audit.rows);
}

TEST_F(OutboxTest, KeepsEveryBitOfAnUpdate) {
  Outbox outbox = Open();
  ASSERT_TRUE(outbox.Replace(std::vector{FullUpdate()}).ok());
  const auto read = outbox.Load();
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_THAT(*read, SizeIs(1));
  ExpectEqual(read->front(), FullUpdate());
}

TEST_F(OutboxTest, KeepsTheLatestUpdatesInOrderAfterReopening) {
  {
    Outbox outbox = Open();
    EXPECT_THAT(*outbox.Load(), IsEmpty());
    ASSERT_TRUE(outbox.Replace(std::vector{Update("gone", 1, {Key("Grid")})}).ok());
    ASSERT_TRUE(outbox.Replace(std::vector{FullUpdate(), Update("two", 1, {})}).ok());
  }
  const auto updates = Open().Load();
  ASSERT_TRUE(updates.ok()) << updates.status();
  ASSERT_THAT(*updates, SizeIs(2));
  ExpectEqual(updates->front(), FullUpdate());
  EXPECT_EQ(updates->back().progress.source_id, "two");
}

TEST_F(OutboxTest, OtherUsersCannotReadIt) {
  Open();
  EXPECT_EQ(std::filesystem::status(path()).permissions() & std::filesystem::perms::others_all,
            std::filesystem::perms::none);
}

// Refuses commits of the session "two", as if another daemon had continued it.
class FencedStore final : public ForwardingStore {
 public:
  absl::Status Commit(std::span<const SourceUpdate> updates) override {
    if (updates[0].progress.source_id == "two")
      return absl::FailedPreconditionError("the source has another writer");
    return ForwardingStore::Commit(updates);
  }
};

TEST_F(OutboxTest, DeliversOnceEvenIfTheStoreHasSomeUpdates) {
  FencedStore store;
  const SourceUpdate first = Update("one", 1, {Key("Grid")});
  ASSERT_TRUE(store.Commit(std::vector{first}).ok()) << "the answer was lost";
  Outbox outbox = Open();
  ASSERT_TRUE(outbox
                  .Replace(std::vector{first, Update("two", 1, {Key("Grid")}),
                                       Update("one", 2, {Key("Grid")})})
                  .ok());
  const auto delivery = outbox.DeliverTo(store);
  ASSERT_TRUE(delivery.ok()) << delivery.status();
  EXPECT_EQ(delivery->committed_count, 2u);
  EXPECT_EQ(delivery->refused_count, 1u);
  EXPECT_EQ((*store.LoadScene({"game", "harbour", "desktop", 1}))->arms[0].live.window_count, 2u);
  EXPECT_THAT(*outbox.Load(), IsEmpty());
}

// Accepts one commit, and is unavailable afterwards.
class LeavingStore final : public ForwardingStore {
 public:
  absl::Status Commit(std::span<const SourceUpdate> updates) override {
    if (++commit_count_ > 1) return absl::UnavailableError("the store is unavailable");
    return ForwardingStore::Commit(updates);
  }

 private:
  int commit_count_ = 0;
};

TEST_F(OutboxTest, KeepsAllUpdatesUntilAllAreDelivered) {
  LeavingStore store;
  Outbox outbox = Open();
  const std::vector both = {Update("one", 1, {Key("Grid")}), Update("two", 1, {Key("Grid")})};
  ASSERT_TRUE(outbox.Replace(both).ok());
  EXPECT_TRUE(absl::IsUnavailable(outbox.DeliverTo(store).status()));
  EXPECT_THAT(*outbox.Load(), SizeIs(2));
  ASSERT_TRUE(outbox.DeliverTo(store.behind()).ok());
  const auto scene = *store.behind().LoadScene({"game", "harbour", "desktop", 1});
  EXPECT_EQ(scene->arms[0].live.window_count, 2u) << "each once";
}

TEST_F(OutboxTest, CheckDeliveredReportsUpdatesThatTheSharedStoreLacks) {
  EXPECT_TRUE(CheckDelivered(path()).ok());
  EXPECT_FALSE(std::filesystem::exists(path()));
  const std::vector updates = {Update("one", 1, {Key("Grid")})};
  ASSERT_TRUE(Open().Replace(updates).ok());
  const absl::Status waits = CheckDelivered(path());
  EXPECT_TRUE(absl::IsFailedPrecondition(waits)) << waits;
  EXPECT_THAT(std::string(waits.message()), HasSubstr("1 updates that the shared store lacks"));
  ASSERT_TRUE(Open().Replace({}).ok());
  EXPECT_TRUE(CheckDelivered(path()).ok());
}

TEST_F(OutboxTest, AFileThatIsNotAnOutboxIsNotChanged) {
  std::ofstream(path()) << "not a database, but too long to be empty";
  const absl::Status status = Outbox::Open(path()).status();
  EXPECT_TRUE(absl::IsDataLoss(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("move it away"));
  std::filesystem::remove(path());
  {
    auto database = SqliteDatabase::Open(path().string(), SqliteDatabase::OpenMode::kCreate);
    ASSERT_TRUE(database->Execute("PRAGMA user_version = 2").ok());
  }
  EXPECT_TRUE(absl::IsDataLoss(Outbox::Open(path()).status())) << "written by a newer daemon";
  std::filesystem::remove(path());
  {
    Open();
    auto database = SqliteDatabase::Open(path().string(), SqliteDatabase::OpenMode::kExisting);
    ASSERT_TRUE(database->Execute("INSERT INTO waiting (body) VALUES ('{}')").ok());
  }
  ForwardingStore store;
  const absl::Status damaged = Open().DeliverTo(store).status();
  EXPECT_TRUE(absl::IsDataLoss(damaged)) << damaged;
  EXPECT_THAT(std::string(damaged.message()), HasSubstr(path().string()));
  EXPECT_THAT(std::string(damaged.message()), HasSubstr("move it away"));
}

}  // namespace
}  // namespace sweepstake::storage
