// Tests that the weight shown for a source equals the weight that a new session gives it.
#include "server/sessions/source_weights.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"
#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::sessions {
namespace {

using priors::PriorRecord;

PriorRecord RecordOf(const std::string& source, const std::string& build, uint64_t last_seen_unix_s,
                     uint32_t backend_version = 1) {
  return {.key = {.project = "game",
                  .scene = "harbour",
                  .measured_by = "",
                  .arm = "Grid",
                  .backend_version = backend_version,
                  .machine_class = "desktop",
                  .reward_version = decision::kLogCostRewardVersion},
          .source_id = source,
          .source_sequence = 1,
          .evidence = {.alpha = 3, .beta = 1, .window_count = 4, .bail_out_count = 0},
          .build = build,
          .last_seen_unix_s = last_seen_unix_s};
}

class SourceWeightsTest : public ::testing::Test {
 protected:
  void Import(const std::vector<PriorRecord>& records) { ASSERT_TRUE(store_.Import(records).ok()); }
  double WeightOf(const PriorRecord& record) { return *SourceWeights(store_).Of(record); }

  storage::ForwardingStore store_;
};

TEST_F(SourceWeightsTest, TheLatestBuildHasTwiceTheWeightOfOthers) {
  const PriorRecord newest = RecordOf("a", "1.1", 70);
  const PriorRecord older = RecordOf("b", "1.0", 60);
  PriorRecord other_class = RecordOf("c", "1.0", 90);
  other_class.key.machine_class = "laptop";
  Import({newest, older, other_class});
  EXPECT_EQ(WeightOf(newest), 0.5);
  EXPECT_EQ(WeightOf(older), 0.25);
  EXPECT_EQ(WeightOf(other_class), 0.5) << "in a session on its own class";
}

TEST_F(SourceWeightsTest, AnOldBackendVersionHasLittleWeightUnlessItsSourceHasTheNewOne) {
  const PriorRecord old_version = RecordOf("a", "1.0", 60, 1);
  const PriorRecord both_old = RecordOf("b", "1.0", 60, 1);
  const PriorRecord both_new = RecordOf("b", "1.0", 60, 2);
  Import({old_version, both_old, both_new});
  EXPECT_EQ(WeightOf(old_version), 0.5 * 0.04);
  EXPECT_EQ(WeightOf(both_old), 0);
  EXPECT_EQ(WeightOf(both_new), 0.5);
}

TEST_F(SourceWeightsTest, EvidenceThatNoSessionUsesHasNoWeight) {
  std::vector<PriorRecord> records;
  for (uint32_t i = 0; i <= priors::kSourcesOfScene; ++i)
    records.push_back(RecordOf(std::to_string(i), "1.0", 60));
  Import(records);
  EXPECT_EQ(WeightOf(records.front()), 0) << "newer sources take all places";
  EXPECT_EQ(WeightOf(records.back()), 0.5);
  PriorRecord waiting = records.back();
  waiting.is_quarantined = true;
  EXPECT_EQ(WeightOf(waiting), 0);
}

TEST_F(SourceWeightsTest, RewardsThatAreNotCostsAreSummed) {
  PriorRecord old_version = RecordOf("a", "1.0", 60, 1);
  PriorRecord new_version = RecordOf("b", "1.1", 70, 2);
  old_version.key.reward_version = new_version.key.reward_version = 1;
  Import({old_version, new_version});
  EXPECT_EQ(WeightOf(old_version), 0);
  EXPECT_EQ(WeightOf(new_version), 1);
}

}  // namespace
}  // namespace sweepstake::sessions
