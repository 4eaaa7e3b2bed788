#include "engine_client/decider/embedded/evidence_ledger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sweepstake {
namespace {

decision::PriorKey KeyOfPlayer() {
  return {.project = "game",
          .scene = "harbour",
          .machine_class = "phone",
          .reward_version = 2,
          .source = "player",
          .arms = {"SAP", "DBVT"},
          .backend_versions = {1, 4}};
}

EvidenceLedger LedgerOf(std::vector<PriorRecord> given) {
  return {std::move(given), KeyOfPlayer()};
}

// Returns evidence for the arm SAP.
PriorRecord RecordOf(const std::string& source, uint64_t sequence, double alpha) {
  PriorRecord record;
  record.key.project = "game";
  record.key.scene = "harbour";
  record.key.arm = "SAP";
  record.key.backend_version = 1;
  record.key.machine_class = "phone";
  record.key.reward_version = 2;
  record.source_id = source;
  record.source_sequence = sequence;
  record.evidence.alpha = alpha;
  record.evidence.window_count = 1;
  return record;
}

decision::Decision Window(const decision::Increment& increment) {
  decision::Decision decision;
  decision.increment = increment;
  return decision;
}

TEST(EvidenceLedger, AddsToARecordPerArmUnderItsOwnSource) {
  EvidenceLedger ledger = LedgerOf({});
  ledger.Add(Window({.arm = 1, .alpha = 2, .beta = 0.5, .window_count = 1}));
  ledger.Add(Window({.arm = 1, .alpha = 1, .beta = 3, .bail_out_count = 1}));
  ledger.Add(Window({.arm = 0, .beta = 1, .window_count = 1}));
  ASSERT_EQ(ledger.records().size(), 2U);
  const PriorRecord& dbvt = ledger.records()[0];
  EXPECT_EQ(dbvt.key.project, "game");
  EXPECT_EQ(dbvt.key.scene, "harbour");
  EXPECT_EQ(dbvt.key.machine_class, "phone");
  EXPECT_EQ(dbvt.key.reward_version, 2U);
  EXPECT_EQ(dbvt.key.arm, "DBVT");
  EXPECT_EQ(dbvt.key.backend_version, 4U);
  EXPECT_EQ(dbvt.source_id, "player");
  EXPECT_EQ(dbvt.source_sequence, 2U);
  EXPECT_EQ(dbvt.evidence.alpha, 3);
  EXPECT_EQ(dbvt.evidence.beta, 3.5);
  EXPECT_EQ(dbvt.evidence.window_count, 1U);
  EXPECT_EQ(dbvt.evidence.bail_out_count, 1U);
  EXPECT_EQ(ledger.records()[1].source_sequence, 3U);
}

TEST(EvidenceLedger, HasARecordPerRegime) {
  decision::Decision rest = Window({.arm = 0, .alpha = 2, .window_count = 1});
  rest.regime = "13/-14/3";
  EvidenceLedger ledger = LedgerOf({});
  ledger.Add(rest);
  ledger.Add(Window({.arm = 0, .alpha = 1, .window_count = 1}));
  ledger.Add(rest);
  ASSERT_EQ(ledger.records().size(), 2U);
  EXPECT_EQ(ledger.records()[0].key.regime, "13/-14/3");
  EXPECT_EQ(ledger.records()[0].evidence.alpha, 4);
  EXPECT_EQ(ledger.records()[1].key.regime, "");
  EXPECT_EQ(ledger.records()[1].evidence.alpha, 1);
}

TEST(EvidenceLedger, ContinuesTheRecordOfItsSourceWithALaterSequence) {
  PriorRecord elsewhere = RecordOf("player", 9, 5);
  elsewhere.key.scene = "desert";
  EvidenceLedger ledger = LedgerOf({RecordOf("player", 7, 10), elsewhere});
  ledger.Add(Window({.arm = 0, .alpha = 1, .window_count = 1}));
  ASSERT_EQ(ledger.records().size(), 2U);
  EXPECT_EQ(ledger.records()[0].source_sequence, 10U) << "later than all records of the source";
  EXPECT_EQ(ledger.records()[0].evidence.alpha, 11);
  EXPECT_EQ(ledger.records()[0].evidence.window_count, 2U);
  EXPECT_EQ(ledger.records()[1].source_sequence, 9U);
  EXPECT_EQ(ledger.records()[1].evidence.alpha, 5);
}

TEST(EvidenceLedger, DoesNotChangeRecordsOfOtherSources) {
  EvidenceLedger ledger = LedgerOf({RecordOf("studio", 7, 10)});
  ledger.Add(Window({.arm = 0, .alpha = 1, .window_count = 1}));
  ASSERT_EQ(ledger.records().size(), 2U);
  EXPECT_EQ(ledger.records()[0].evidence.alpha, 10);
  EXPECT_EQ(ledger.records()[0].source_sequence, 7U);
  EXPECT_EQ(ledger.records()[1].source_id, "player");
  EXPECT_EQ(ledger.prior().source_count, 1U);
}

TEST(EvidenceLedger, KeepsVisitsOfTheLaneInSeparateRecordsAndLearnsFromThem) {
  EvidenceLedger ledger = LedgerOf({});
  decision::Decision decision = Window({.arm = 0, .alpha = 6, .beta = 4, .window_count = 1});
  decision.lane_increments = {{.arm = 0, .alpha = 6, .beta = 4, .window_count = 1},
                              {.arm = 1, .alpha = 8, .beta = 2, .window_count = 1}};
  ledger.Add(decision);
  ledger.Add(decision);
  ASSERT_EQ(ledger.records().size(), 3U);
  EXPECT_EQ(ledger.records()[0].key.measured_by, "");
  EXPECT_EQ(ledger.records()[0].evidence.alpha, 12);
  EXPECT_EQ(ledger.records()[2].key.measured_by, "lane");
  EXPECT_EQ(ledger.records()[2].key.arm, "DBVT");
  EXPECT_EQ(ledger.records()[2].evidence.window_count, 2U);
  const auto priors = LedgerOf(ledger.records()).prior().posteriors();
  EXPECT_GT(priors[1].mean(), priors[0].mean()) << "DBVT was never live";
}

TEST(EvidenceLedger, MergedRecordsKeepTheLaterOne) {
  const auto united = Unite({RecordOf("a", 2, 20), RecordOf("b", 1, 1), RecordOf("d", 5, 7)},
                            {RecordOf("a", 1, 10), RecordOf("b", 2, 5), RecordOf("c", 1, 3)});
  std::vector<std::pair<std::string, double>> found;
  for (const PriorRecord& record : united) {
    found.emplace_back(record.source_id, record.evidence.alpha);
  }
  EXPECT_THAT(found, ::testing::ElementsAre(std::pair("a", 20.0), std::pair("b", 5.0),
                                            std::pair("d", 7.0), std::pair("c", 3.0)));
}

}  // namespace
}  // namespace sweepstake
