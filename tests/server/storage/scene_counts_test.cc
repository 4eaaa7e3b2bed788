// Tests the counts of scenes that the store keeps: they always match its rows, and reading them
// visits no rows.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/server/storage/failing_disk.h"
#include "tests/server/storage/instruction_counter.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

using Count = std::pair<uint64_t, uint64_t>;  // numbers of scene names and of scene keys

class SceneCountsTest : public ::testing::Test {
 protected:
  static EvidenceKey KeyOf(const std::string& scene, const std::string& machine_class = "desktop") {
    EvidenceKey key = Key("Grid");
    key.scene = scene;
    key.machine_class = machine_class;
    return key;
  }
  absl::Status Commit(const std::string& source, const std::vector<EvidenceKey>& keys) {
    return store_->Commit(std::vector{Update(source, ++sequence_, keys)});
  }
  // Returns the store's counts, after a comparison with a count of the rows.
  Count Counts() {
    const auto kept = *store_->CountScenes("game");
    const auto counted = *(*OpenSqliteReadConnection(path_))->Begin().CountScenes("game");
    EXPECT_EQ(Count(kept.names, kept.keys), Count(counted.names, counted.keys));
    return {kept.names, kept.keys};
  }

  const test_support::TemporaryDirectory directory_;
  const std::string path_ = (directory_.path() / "priors.db").string();
  FailingDisk disk_;
  InstructionCounter instructions_;
  std::unique_ptr<PriorStore> store_ = *OpenSqlitePriorStore(path_);
  uint64_t sequence_ = 0;
};

TEST_F(SceneCountsTest, MatchTheRowsAfterCommitsImportsAndRevocations) {
  EXPECT_EQ(Counts(), Count(0, 0));
  ASSERT_TRUE(Commit("a", {KeyOf("hall")}).ok());
  EXPECT_EQ(Counts(), Count(1, 1));
  ASSERT_TRUE(Commit("a", {KeyOf("hall"), KeyOf("hall", "laptop"), KeyOf("quay")}).ok());
  EXPECT_EQ(Counts(), Count(2, 3));
  ASSERT_TRUE(Commit("b", {KeyOf("hall"), KeyOf("pier"), KeyOf("pier", "laptop")}).ok());
  EXPECT_EQ(Counts(), Count(3, 5));
  ASSERT_TRUE(store_->Import(std::vector{Record("c", 1, KeyOf("isle"), 1)}).ok());
  EXPECT_EQ(Counts(), Count(4, 6));
  ASSERT_TRUE(store_->Revoke({.id = "b"}, false).ok());
  EXPECT_EQ(Counts(), Count(3, 4));
  ASSERT_TRUE(Commit("a", {KeyOf("pier", "laptop")}).ok());
  EXPECT_EQ(Counts(), Count(4, 5)) << "removed scenes do not count";
}

TEST_F(SceneCountsTest, DoNotChangeIfACommitFails) {
  ASSERT_TRUE(Commit("a", {KeyOf("hall")}).ok());
  EXPECT_EQ(Counts(), Count(1, 1));
  disk_.Set({.write_error = 1});
  EXPECT_FALSE(Commit("a", {KeyOf("quay")}).ok());
  EXPECT_EQ(store_->CountScenes("game")->keys, 1u);
  disk_.Set({});
  ASSERT_TRUE(Commit("a", {KeyOf("pier")}).ok());
  EXPECT_EQ(Counts(), Count(2, 2));
}

TEST_F(SceneCountsTest, AHelloOfANewSceneVisitsEquallyManyRowsWithTenOrTenThousandScenes) {
  const auto teach = [&](int first, int end) {
    std::vector<EvidenceKey> keys;
    for (int i = first; i < end; ++i) keys.push_back(KeyOf("scene " + std::to_string(i)));
    ASSERT_TRUE(Commit("a", keys).ok());
  };
  const auto read = [&](uint64_t scene_count) {
    EXPECT_EQ(*store_->LoadScene({"game", "a new one", "desktop", 1}), std::nullopt);
    EXPECT_TRUE(store_->List({"game", "a new one"}, std::nullopt, 1)->empty());
    EXPECT_EQ(store_->CountScenes("game")->names, scene_count);
  };
  teach(0, 10);
  read(10);
  const uint64_t with_ten = instructions_.During([&] { read(10); });
  EXPECT_GT(with_ten, 0u);
  teach(10, 10'000);
  EXPECT_EQ(instructions_.During([&] { read(10'000); }), with_ten);
}

}  // namespace
}  // namespace sweepstake::storage
