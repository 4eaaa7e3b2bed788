#include "engine_client/decider/embedded/evidence_ledger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sweepstake {
namespace {

const std::vector<std::string> kLedgerArms = {"SAP", "DBVT"};
const std::vector<uint32_t> kLedgerVersions = {1, 4};

EvidenceLedger::Key KeyOfPlayer(const std::string& source) {
  return {.project = "game",
          .scene = "harbour",
          .machine_class = "phone",
          .reward_version = 2,
          .source_id = source,
          .compares_sources = false};
}

EvidenceLedger LedgerOf(std::vector<PriorRecord> given, const std::string& source = "player") {
  return {std::move(given), KeyOfPlayer(source), kLedgerArms, kLedgerVersions};
}

// Returns evidence for the arm SAP.
PriorRecord RecordOf(const std::string& source, uint64_t sequence, double alpha) {
  PriorRecord record;
  record.project = "game";
  record.scene = "harbour";
  record.arm = "SAP";
  record.backend_version = 1;
  record.machine_class = "phone";
  record.reward_version = 2;
  record.source_id = source;
  record.source_sequence = sequence;
  record.alpha_increment = alpha;
  record.window_count = 1;
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
  EXPECT_EQ(dbvt.project, "game");
  EXPECT_EQ(dbvt.scene, "harbour");
  EXPECT_EQ(dbvt.machine_class, "phone");
  EXPECT_EQ(dbvt.reward_version, 2U);
  EXPECT_EQ(dbvt.arm, "DBVT");
  EXPECT_EQ(dbvt.backend_version, 4U);
  EXPECT_EQ(dbvt.source_id, "player");
  EXPECT_EQ(dbvt.source_sequence, 2U);
  EXPECT_EQ(dbvt.alpha_increment, 3);
  EXPECT_EQ(dbvt.beta_increment, 3.5);
  EXPECT_EQ(dbvt.window_count, 1U);
  EXPECT_EQ(dbvt.bail_out_count, 1U);
  EXPECT_EQ(ledger.records()[1].source_sequence, 3U);
}

TEST(EvidenceLedger, GoesOnWithTheRecordOfItsSourceUnderALaterSequence) {
  PriorRecord elsewhere = RecordOf("player", 9, 5);
  elsewhere.scene = "desert";
  EvidenceLedger ledger = LedgerOf({RecordOf("player", 7, 10), elsewhere});
  ledger.Add(Window({.arm = 0, .alpha = 1, .window_count = 1}));
  ASSERT_EQ(ledger.records().size(), 2U);
  EXPECT_EQ(ledger.records()[0].source_sequence, 10U) << "later than all records of the source";
  EXPECT_EQ(ledger.records()[0].alpha_increment, 11);
  EXPECT_EQ(ledger.records()[0].window_count, 2U);
  EXPECT_EQ(ledger.records()[1].source_sequence, 9U);
  EXPECT_EQ(ledger.records()[1].alpha_increment, 5);
}

TEST(EvidenceLedger, LeavesTheRecordsOfOthersAsTheyAre) {
  EvidenceLedger ledger = LedgerOf({RecordOf("studio", 7, 10)});
  ledger.Add(Window({.arm = 0, .alpha = 1, .window_count = 1}));
  ASSERT_EQ(ledger.records().size(), 2U);
  EXPECT_EQ(ledger.records()[0].alpha_increment, 10);
  EXPECT_EQ(ledger.records()[0].source_sequence, 7U);
  EXPECT_EQ(ledger.records()[1].source_id, "player");
  EXPECT_EQ(ledger.prior_source_count(), 1U);
}

TEST(EvidenceLedger, SumsWhatAppliesOnTopOfBetaOneOne) {
  std::vector<PriorRecord> given(7, RecordOf("studio", 1, 10));
  given[1].source_id = "player";
  given[2].scene = "desert";
  given[3].machine_class = "desktop";
  given[4].reward_version = 1;
  given[5].backend_version = 2;
  given[6].arm = "Grid";
  const EvidenceLedger ledger = LedgerOf(given);
  EXPECT_EQ(ledger.priors()[0].alpha, 21);
  EXPECT_EQ(ledger.priors()[0].beta, 1);
  EXPECT_EQ(ledger.priors()[1].alpha, 1);
  EXPECT_EQ(ledger.prior_source_count(), 2U);
}

TEST(EvidenceLedger, KeepsTheLanesVisitsApartAndLearnsFromThem) {
  EvidenceLedger ledger = LedgerOf({});
  decision::Decision decision = Window({.arm = 0, .alpha = 6, .beta = 4, .window_count = 1});
  decision.lane_increments = {{.arm = 0, .alpha = 6, .beta = 4, .window_count = 1},
                              {.arm = 1, .alpha = 8, .beta = 2, .window_count = 1}};
  ledger.Add(decision);
  ledger.Add(decision);
  ASSERT_EQ(ledger.records().size(), 3U);
  EXPECT_EQ(ledger.records()[0].measured_by, "");
  EXPECT_EQ(ledger.records()[0].alpha_increment, 12);
  EXPECT_EQ(ledger.records()[2].measured_by, "lane");
  EXPECT_EQ(ledger.records()[2].arm, "DBVT");
  EXPECT_EQ(ledger.records()[2].window_count, 2U);
  const auto priors = LedgerOf(ledger.records()).priors();
  EXPECT_GT(priors[1].mean(), priors[0].mean()) << "DBVT was never live";
}

// In four scenes SAP costs twice as much as DBVT; a fifth scene differs.
TEST(EvidenceLedger, BeginsASceneWithoutEvidenceWithWhatTheProjectsOthersHaveInCommon) {
  std::vector<PriorRecord> given;
  for (const char* scene : {"desert", "forest", "mine", "tower", "sea"}) {
    PriorRecord sap = RecordOf("studio", 1, 50'000);
    sap.scene = scene;
    sap.measured_by = "lane";
    sap.beta_increment = 50'000;
    given.push_back(sap);
    sap.arm = "DBVT";
    sap.backend_version = 4;
    const double shift = scene == std::string("sea") ? -0.03 : 0.03;
    sap.alpha_increment *= 1 + shift;
    sap.beta_increment *= 1 - shift;
    given.push_back(sap);
  }
  EvidenceLedger::Key key = KeyOfPlayer("player");
  key.compares_sources = true;
  const EvidenceLedger ledger(given, key, kLedgerArms, kLedgerVersions);
  EXPECT_EQ(ledger.prior_source_count(), 5U);
  EXPECT_GT(ledger.priors()[1].mean(), ledger.priors()[0].mean());
  key.scene = "desert";
  EXPECT_LT(ledger.priors()[1].evidence(),
            EvidenceLedger(given, key, kLedgerArms, kLedgerVersions).priors()[1].evidence())
      << "priors of another scene differ";
  key.scene = "harbour";

  EXPECT_EQ(LedgerOf(given).prior_source_count(), 0U) << "not used for policies that sum rewards";
  given.push_back(RecordOf("studio", 1, 10));
  given.back().beta_increment = 10;
  const EvidenceLedger known(given, key, kLedgerArms, kLedgerVersions);
  EXPECT_EQ(known.prior_source_count(), 1U);
  EXPECT_GT(known.priors()[1].mean(), known.priors()[0].mean())
      << "the priors of the other scenes still count";
}

// Another machine, twice as fast as the player's, has evidence about DBVT too.
TEST(EvidenceLedger, ComparesSourcesOfOtherMachinesBuildsAndVersions) {
  const auto lane = [](PriorRecord record, double reward) {
    record.measured_by = "lane";
    record.alpha_increment = 1e5 * reward;
    record.beta_increment = 1e5 * (1 - reward);
    return record;
  };
  PriorRecord dbvt = RecordOf("studio", 2, 0);
  dbvt.arm = "DBVT";
  dbvt.backend_version = 3;
  std::vector<PriorRecord> given = {lane(RecordOf("studio", 1, 0), 0.50), lane(dbvt, 0.53),
                                    lane(RecordOf("player", 1, 0), 0.47)};
  EvidenceLedger::Key key = KeyOfPlayer("player");
  key.compares_sources = true;
  const auto evidence_of_dbvt = [&] {
    const auto priors = EvidenceLedger(given, key, kLedgerArms, kLedgerVersions).priors();
    EXPECT_GT(priors[1].mean(), priors[0].mean());
    EXPECT_LT(priors[1].mean(), 0.51) << "scaled to the player's machine";
    return priors[1].evidence();
  };
  double other_version = evidence_of_dbvt();
  given[1].backend_version = 4;
  const double same_version = evidence_of_dbvt();
  EXPECT_GT(same_version, 2 * other_version);
  given[0].build = given[1].build = "1.0";
  const double other_build = evidence_of_dbvt();
  EXPECT_LT(other_build, same_version);
  given[0].machine_class = given[1].machine_class = "desktop";
  EXPECT_LT(evidence_of_dbvt(), other_build);
}

TEST(EvidenceLedger, UnitesRecordsOfWhichTheLaterCounts) {
  const auto united = Unite({RecordOf("a", 2, 20), RecordOf("b", 1, 1), RecordOf("d", 5, 7)},
                            {RecordOf("a", 1, 10), RecordOf("b", 2, 5), RecordOf("c", 1, 3)});
  std::vector<std::pair<std::string, double>> found;
  for (const PriorRecord& record : united) {
    found.emplace_back(record.source_id, record.alpha_increment);
  }
  EXPECT_THAT(found, ::testing::ElementsAre(std::pair("a", 20.0), std::pair("b", 5.0),
                                            std::pair("d", 7.0), std::pair("c", 3.0)));
}

}  // namespace
}  // namespace sweepstake
