// Tests rows that were changed on the disk: they are detected, and do not count as evidence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_store.h"
#include "server/storage/sqlite_schema.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

using ::testing::HasSubstr;

class DamagedRowsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    store_ = *OpenSqlitePriorStore(path_);
    ASSERT_TRUE(store_
                    ->Commit(std::vector{Update("a", 1, {Key("Grid"), Key("SAP")}),
                                         Update("b", 1, {Key("Grid"), Key("Grid", "desert")})})
                    .ok());
  }
  // Changes rows without updating their hashes, as disk damage does.
  void Damage(const std::string& change) {
    const absl::Status status = Raw().Execute("UPDATE " + change);
    ASSERT_TRUE(status.ok()) << status;
  }
  int64_t DamagedRowCount() {
    auto database = Raw();
    return *CountDamagedRows(database);
  }
  absl::Status LoadHarbour() { return LoadSums(*store_, {Key("Grid"), Key("SAP")}).status(); }
  SqliteDatabase Raw() {
    return *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting);
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path path_ = directory_.path() / "priors.db";
  std::unique_ptr<PriorStore> store_;
};

TEST_F(DamagedRowsTest, EveryWriteOfTheStoreKeepsTheHashesCorrect) {
  ASSERT_TRUE(store_->Commit(std::vector{Update("a", 2, {Key("Grid"), Key("DBVT")})}).ok());
  ASSERT_TRUE(store_
                  ->Import(std::vector{Record("i", 1, Key("Grid"), 4.0),
                                       Record("j", 1, Key("KDTree", "canyon"), -0.0)})
                  .ok());
  ASSERT_TRUE(store_->Import(std::vector{Record("i", 2, Key("Grid"), 5.5)}).ok());
  ASSERT_TRUE(store_
                  ->Quarantine(std::vector{Record("i", 3, Key("Grid"), 6.0),
                                           Record("k", 1, Key("Grid", "quay"), 0.25)},
                               9)
                  .ok());
  ASSERT_TRUE(store_->Quarantine(std::vector{Record("k", 2, Key("Grid", "quay"), 1.5)}, 9).ok());
  ASSERT_TRUE(store_->Promote({.id = "k"}, false).ok());
  ASSERT_TRUE(store_->Quarantine(std::vector{Record("l", 1, Key("Grid"), 3.0)}, 9).ok());
  ASSERT_TRUE(store_->Commit(std::vector{Update("i", 9, {Key("Grid")})}).ok());
  ASSERT_TRUE(store_->Revoke({.id = "b"}, false).ok());
  ASSERT_TRUE(store_->Revoke({.id = "nobody"}, false).ok());
  EXPECT_EQ(DamagedRowCount(), 0);
  EXPECT_TRUE(VerifyStore(path_).ok()) << VerifyStore(path_).status();
}

TEST_F(DamagedRowsTest, ASceneWithADamagedRowHasNoPriorsAndOthersHaveTheirs) {
  for (const char* change : {"evidence_key SET alpha_sum = alpha_sum + 1 WHERE arm = 'SAP'",
                             "evidence_key SET window_sum = 9 WHERE arm = 'SAP'",
                             "scene SET source_count = 7 WHERE scene = 'harbour'"}) {
    EXPECT_TRUE(LoadHarbour().ok());
    auto raw = Raw();
    ASSERT_TRUE(raw.Execute("CREATE TABLE undone AS SELECT * FROM evidence_key").ok());
    Damage(change);
    EXPECT_EQ(DamagedRowCount(), 1) << change;
    EXPECT_TRUE(absl::IsDataLoss(LoadHarbour())) << change;
    EXPECT_THAT(std::string(LoadHarbour().message()), HasSubstr("scene harbour of project game"));
    EXPECT_TRUE(absl::IsDataLoss(store_->LoadScene({"game", "harbour", "desktop", 1}).status()));
    EXPECT_EQ(store_->List({}, std::nullopt, 9)->size(), 1u) << change;
    EXPECT_TRUE(absl::IsDataLoss(store_->Export({}, {}, 9).status()) ||
                std::string_view(change).starts_with("scene"));
    EXPECT_TRUE(LoadSums(*store_, {Key("Grid", "desert")}).ok());
    EXPECT_EQ(store_->Export({.project = "", .scene = "desert"}, {}, 9)->records.size(), 1u);
    ASSERT_TRUE(raw.Execute("UPDATE evidence_key AS k SET alpha_sum = u.alpha_sum, window_sum = "
                            "u.window_sum FROM undone u WHERE u.id = k.id; DROP TABLE undone;"
                            "UPDATE scene SET source_count = 2 WHERE scene = 'harbour'")
                    .ok());
  }
}

TEST_F(DamagedRowsTest, ASourceWithADamagedRowIsNotResumed) {
  Damage("source SET message_sequence = 1000000 WHERE name = 'a'");
  EXPECT_TRUE(absl::IsDataLoss(store_->LoadSource("a").status()));
  EXPECT_TRUE(store_->LoadSource("b").ok());
  Damage("evidence SET bail_out_count = 3 WHERE source_id = 2");
  EXPECT_TRUE(absl::IsDataLoss(store_->LoadSource("b").status()));
}

TEST_F(DamagedRowsTest, NewEvidenceIsAcceptedAndDoesNotHideADamagedRow) {
  Damage("evidence SET alpha = 1000 WHERE source_id = 1");
  Damage("evidence_key SET alpha_sum = 1000 WHERE arm = 'Grid'");
  Damage("scene SET source_count = 7 WHERE scene = 'harbour'");
  Damage("source SET frame_count = 7 WHERE name = 'a'");
  const int64_t damaged = DamagedRowCount();
  EXPECT_EQ(damaged, 6);
  ASSERT_TRUE(store_
                  ->Commit(std::vector{Update("a", 2, {Key("Grid"), Key("SAP")}),
                                       Update("c", 1, {Key("Grid")})})
                  .ok());
  EXPECT_EQ(DamagedRowCount(), damaged);
  EXPECT_TRUE(absl::IsDataLoss(LoadHarbour()));
}

TEST_F(DamagedRowsTest, RecomputedSumsOmitDamagedEvidence) {
  Damage("evidence SET alpha = 1000 WHERE source_id = 1");
  ASSERT_TRUE(store_->Import(std::vector{Record("i", 1, Key("Grid"), 4.0)}).ok());
  const auto sums = LoadSums(*store_, {Key("Grid")});
  ASSERT_TRUE(sums.ok()) << sums.status();
  EXPECT_EQ(sums->sums[0].evidence.alpha, 4.75);
  EXPECT_EQ(sums->sums[0].source_count, 2u);
}

TEST_F(DamagedRowsTest, DamagedRecordsInQuarantineAreNotPromoted) {
  ASSERT_TRUE(store_
                  ->Quarantine(std::vector{Record("i", 1, Key("Grid", "quay"), 4.0),
                                           Record("j", 1, Key("Grid"), 1.0)},
                               9)
                  .ok());
  Damage("quarantined_evidence SET alpha = 1000 WHERE source_id = 3");
  EXPECT_EQ(DamagedRowCount(), 1);
  EXPECT_TRUE(absl::IsDataLoss(store_->ExportQuarantined({}, {}, 9).status()));
  EXPECT_EQ(store_->Promote({}, false)->record_count, 1u);
  EXPECT_EQ(LoadSums(*store_, {Key("Grid")})->sums[0].evidence.alpha, 2.5);
  EXPECT_EQ(DamagedRowCount(), 1);
  const std::filesystem::path copy = directory_.path() / "copy.db";
  const auto kept = BackUpStore(directory_.path(), copy);
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(kept->damaged_row_count, 1);
}

TEST_F(DamagedRowsTest, AnIndexThatLacksRowsIsDetectedAtTheStart) {
  store_.reset();
  ASSERT_TRUE(Raw()
                  .Execute("PRAGMA writable_schema = ON;"
                           "UPDATE sqlite_schema SET sql = replace(sql, 'UNIQUE (project, scene, "
                           "machine_class', 'UNIQUE (scene, project, machine_class')")
                  .ok());
  const absl::Status status = OpenSqlitePriorStore(path_).status();
  EXPECT_TRUE(absl::IsDataLoss(status)) << status;
}

TEST_F(DamagedRowsTest, AChangedBitThatSqliteDoesNotDetectIsDetected) {
  constexpr double kAlpha = 123 + 478'987 / 0x1p20;  // a multiple of 2^-20, as in stores
  ASSERT_TRUE(store_->Import(std::vector{Record("i", 1, Key("Grid", "canyon"), kAlpha)}).ok());
  store_.reset();
  std::string content;
  {
    std::ifstream file(path_, std::ios::binary);
    content.assign(std::istreambuf_iterator<char>(file), {});
  }
  std::string bytes(sizeof(kAlpha), '\0');
  std::memcpy(bytes.data(), &kAlpha, sizeof(kAlpha));
  std::reverse(bytes.begin(), bytes.end());  // SQLite files are big-endian
  const size_t place = content.find(bytes);
  ASSERT_NE(place, std::string::npos);
  content[place + 3] ^= 0x10;
  std::ofstream(path_, std::ios::binary) << content;
  EXPECT_EQ(*Raw().QueryText("PRAGMA integrity_check"), "ok");
  EXPECT_EQ(DamagedRowCount(), 1);
  EXPECT_THAT(std::string(VerifyStore(path_).status().message()),
              HasSubstr("1 rows were changed on the disk"));
}

}  // namespace
}  // namespace sweepstake::storage
