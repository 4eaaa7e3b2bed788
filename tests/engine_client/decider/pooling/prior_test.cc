#include "engine_client/decider/pooling/prior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "engine_client/decider/session/session_setup.h"

namespace sweepstake::decision {
namespace {

PriorKey Session() {
  return {.project = "game",
          .scene = "harbour",
          .machine_class = "phone",
          .reward_version = 2,
          .source = "player",
          .arms = {"SAP", "DBVT"},
          .backend_versions = {1, 4}};
}

PriorKey ComparingSession() {
  PriorKey key = Session();
  key.compares_sources = true;
  return key;
}

// Returns a record of SAP that belongs to the session's scene.
ArmRecord RecordOf(std::string_view source, double alpha) {
  return {.project = "game",
          .scene = "harbour",
          .machine_class = "phone",
          .reward_version = 2,
          .source = source,
          .build = {},
          .arm = "SAP",
          .backend_version = 1,
          .evidence = {.live = {.alpha = alpha}}};
}

// Returns a record of the lane's visits of an arm.
ArmRecord VisitsOf(std::string_view source, std::string_view arm, double reward) {
  ArmRecord record = RecordOf(source, 0);
  record.arm = arm;
  record.backend_version = arm == "SAP" ? 1 : 4;
  record.evidence = {.lane = {1e5 * reward, 1e5 * (1 - reward)}};
  return record;
}

TEST(PriorFor, WithoutEvidenceIsUnknown) {
  const Prior prior = PriorFor({}, ComparingSession());
  EXPECT_EQ(prior.source_count, 0u);
  EXPECT_TRUE(prior.posteriors().empty());
}

TEST(PriorFor, SumsTheSourcesOfTheSceneOnTopOfBetaOneOne) {
  std::vector<ArmRecord> records(8, RecordOf("studio", 10));
  records[1].source = "player";
  records[2].scene = "desert";
  records[3].machine_class = "desktop";
  records[4].reward_version = 1;
  records[5].backend_version = 2;
  records[6].arm = "Grid";
  records[7].project = "other";
  const Prior prior = PriorFor(records, Session());
  EXPECT_EQ(prior.posteriors()[0].alpha, 21);
  EXPECT_EQ(prior.posteriors()[0].beta, 1);
  EXPECT_EQ(prior.posteriors()[1].alpha, 1);
  EXPECT_EQ(prior.source_count, 2u);
}

TEST(PriorFor, DoesNotDependOnTheOrderOfRecords) {
  std::vector<ArmRecord> records;
  const char* names[] = {"a", "b", "c", "d", "e"};
  for (int i = 0; i < 5; ++i) {
    records.push_back(VisitsOf(names[i], "SAP", 0.5 + 0.013 * i));
    records.push_back(VisitsOf(names[i], "DBVT", 0.5 + 0.007 * i * i));
  }
  const Prior forward = PriorFor(records, ComparingSession());
  std::reverse(records.begin(), records.end());
  const Prior backward = PriorFor(records, ComparingSession());
  for (size_t arm = 0; arm < 2; ++arm) {
    EXPECT_EQ(forward.evidence[arm].alpha, backward.evidence[arm].alpha);
    EXPECT_EQ(forward.evidence[arm].beta, backward.evidence[arm].beta);
  }
}

// SAP costs twice as much as DBVT in four scenes, and half as much in the fifth.
TEST(PriorFor, FillsASceneWithoutEvidenceFromTheOtherScenesOfTheProject) {
  std::vector<ArmRecord> records;
  for (const char* scene : {"desert", "forest", "mine", "tower", "sea"}) {
    for (ArmRecord record :
         {VisitsOf("studio", "SAP", 0.5),
          VisitsOf("studio", "DBVT", scene == std::string("sea") ? 0.47 : 0.53)}) {
      record.scene = scene;
      records.push_back(record);
    }
  }
  PriorKey key = ComparingSession();
  const Prior prior = PriorFor(records, key);
  EXPECT_EQ(prior.source_count, 5u);
  EXPECT_EQ(prior.other_scene_count, 5u);
  EXPECT_GT(prior.posteriors()[1].mean(), prior.posteriors()[0].mean());
  for (ArmRecord record : {VisitsOf("player", "SAP", 0.5), VisitsOf("player", "DBVT", 0.53)}) {
    record.scene = "desert";
    records.push_back(record);
  }
  key.scene = "desert";
  EXPECT_LT(prior.posteriors()[1].evidence(), PriorFor(records, key).posteriors()[1].evidence())
      << "evidence of other scenes is less certain";

  EXPECT_EQ(PriorFor(records, Session()).source_count, 0u) << "policies that sum rewards ignore it";
  records.push_back(RecordOf("studio", 10));
  records.back().evidence.live.beta = 10;
  const Prior known = PriorFor(records, ComparingSession());
  EXPECT_EQ(known.source_count, 1u);
  EXPECT_GT(known.posteriors()[1].mean(), known.posteriors()[0].mean());
}

TEST(PriorFor, UsesOtherScenesOfTheMachineClassIfThereAreAny) {
  std::vector<ArmRecord> records = {VisitsOf("a", "SAP", 0.5), VisitsOf("a", "DBVT", 0.52),
                                    VisitsOf("b", "SAP", 0.5), VisitsOf("b", "DBVT", 0.45)};
  for (ArmRecord& record : records) record.scene = "desert";
  records[2].machine_class = records[3].machine_class = "desktop";
  const Prior of_class = PriorFor(records, ComparingSession());
  EXPECT_EQ(of_class.other_scene_count, 1u);
  EXPECT_GT(of_class.evidence[1].alpha, of_class.evidence[1].beta);
  records.erase(records.begin(), records.begin() + 2);
  EXPECT_EQ(PriorFor(records, ComparingSession()).other_scene_count, 1u);
}

TEST(PriorFor, CountsASumOfManySourcesAsThatMany) {
  std::vector<ArmRecord> records = {VisitsOf("", "SAP", 0.5), VisitsOf("", "DBVT", 0.52)};
  for (ArmRecord& record : records) record.source_count = 7;
  EXPECT_EQ(PriorFor(records, Session()).source_count, 7u);
}

// A machine of the studio, twice as fast as the player's, also measured DBVT.
TEST(PriorFor, WeighsSourcesByBuildMachineClassAndVersion) {
  std::vector<ArmRecord> records = {VisitsOf("studio", "SAP", 0.50),
                                    VisitsOf("studio", "DBVT", 0.53),
                                    VisitsOf("player", "SAP", 0.47)};
  const auto evidence_of_dbvt = [&] {
    const auto priors = PriorFor(records, ComparingSession()).posteriors();
    EXPECT_GT(priors[1].mean(), priors[0].mean());
    EXPECT_LT(priors[1].mean(), 0.51) << "at the level of the player's machine";
    return priors[1].evidence();
  };
  records[1].backend_version = 3;
  const double other_version = evidence_of_dbvt();
  records[1].backend_version = 4;
  const double same_version = evidence_of_dbvt();
  EXPECT_GT(same_version, 2 * other_version);
  records[0].build = records[1].build = "1.0";
  const double other_build = evidence_of_dbvt();
  EXPECT_LT(other_build, same_version);
  records[0].machine_class = records[1].machine_class = "desktop";
  EXPECT_LT(evidence_of_dbvt(), other_build);
}

TEST(PriorFor, OwnEvidenceCountsOnlyWithTheSessionsVersion) {
  std::vector<ArmRecord> records = {VisitsOf("player", "SAP", 0.5)};
  EXPECT_EQ(PriorFor(records, ComparingSession()).source_count, 1u);
  records[0].backend_version = 2;
  EXPECT_FALSE(PriorFor(records, ComparingSession()).is_known());
}

TEST(PriorFor, GroupsTheSourcesByWeight) {
  PriorKey key = ComparingSession();
  key.build = "2";
  std::vector<ArmRecord> records = {VisitsOf("a", "SAP", 0.5), VisitsOf("b", "SAP", 0.5),
                                    VisitsOf("c", "SAP", 0.5)};
  records[1].build = records[2].build = "2";
  const Prior prior = PriorFor(records, key);
  ASSERT_EQ(prior.groups.size(), 2u);
  EXPECT_EQ(prior.groups[0].build, "2");
  EXPECT_EQ(prior.groups[0].source_count, 2u);
  EXPECT_EQ(prior.groups[0].weight, 0.5);
  EXPECT_EQ(prior.groups[1].weight, 0.25);
}

ArmRecord VisitsIn(std::string_view regime, std::string_view arm, double reward) {
  ArmRecord record = VisitsOf("studio", arm, reward);
  record.regime = regime;
  record.evidence.visit_count = 1;
  return record;
}

TEST(PriorFor, GivesEachRegimeItsOwnEvidence) {
  const std::vector<ArmRecord> records = {
      VisitsIn("1/1/1", "SAP", 0.5),  VisitsIn("1/1/1", "DBVT", 0.6),
      VisitsIn("2/2/2", "SAP", 0.55), VisitsIn("2/2/2", "DBVT", 0.45),
      VisitsIn("2/2/2", "SAP", 0.55), VisitsIn("", "SAP", 0.5)};
  const Prior prior = PriorFor(records, ComparingSession());
  EXPECT_EQ(prior.regimes.buckets, (std::vector<std::string>{"2/2/2", "1/1/1"}))
      << "most evidence first; the unknown regime has no prior of its own";
  EXPECT_EQ(prior.regimes.stored_count, 2u);
  EXPECT_NEAR(prior.regimes.Of(0)[0].mean(), 0.55, 1e-3);
  EXPECT_NEAR(prior.regimes.Of(0)[1].mean(), 0.45, 1e-3);
  EXPECT_NEAR(prior.regimes.Of(1)[0].mean(), 0.5, 1e-3);
  EXPECT_NEAR(prior.regimes.Of(1)[1].mean(), 0.6, 1e-3);
  EXPECT_LT(prior.posteriors()[0].mean(), 0.54) << "all regimes together";
  EXPECT_TRUE(PriorFor(records, Session()).regimes.buckets.empty());
}

TEST(PriorFor, FillsInARegimesArmsFromOtherRegimesAndFromTheSameRegimeOfOtherScenes) {
  std::vector<ArmRecord> records = {VisitsIn("1/1/1", "SAP", 0.5), VisitsIn("2/2/2", "SAP", 0.55),
                                    VisitsIn("2/2/2", "DBVT", 0.45)};
  const auto first_regime = [&] {
    const RegimePriors regimes = PriorFor(records, ComparingSession()).regimes;
    const auto found = std::find(regimes.buckets.begin(), regimes.buckets.end(), "1/1/1");
    const auto arms = regimes.Of(static_cast<size_t>(found - regimes.buckets.begin()));
    return std::vector<BetaPosterior>(arms.begin(), arms.end());
  };
  const auto from_regime = first_regime();
  EXPECT_NEAR(from_regime[1].mean(), 0.4, 1e-2) << "DBVT is as much worse as in the other regime";
  EXPECT_LT(from_regime[1].evidence(), from_regime[0].evidence());
  for (const char* arm : {"SAP", "DBVT"}) {
    records.push_back(VisitsIn("1/1/1", arm, arm == std::string("SAP") ? 0.5 : 0.7));
    records.back().scene = "desert";
    records.push_back(VisitsIn("3/3/3", arm, 0.5));
    records.back().scene = "desert";
  }
  EXPECT_EQ(first_regime(), from_regime) << "the scene itself knows all arms";
  records.erase(records.begin() + 2);  // the scene's evidence about DBVT
  EXPECT_GT(first_regime()[1].mean(), 0.6) << "the same regime of the other scene counts";
  const RegimePriors regimes = PriorFor(records, ComparingSession()).regimes;
  EXPECT_EQ(regimes.stored_count, 2u);
  EXPECT_EQ(regimes.buckets[2], "3/3/3") << "a regime that only another scene has";
}

TEST(PriorFor, LimitsTheNumberOfRegimes) {
  std::vector<std::string> names;
  for (int i = 0; i < 40; ++i) names.push_back(std::to_string(i) + "/0/0");
  std::vector<ArmRecord> records;
  for (int i = 0; i < 40; ++i) {
    records.push_back(VisitsIn(names[static_cast<size_t>(i)], "SAP", 0.5));
    if (i >= 20) records.back().scene = "desert";
  }
  const RegimePriors regimes = PriorFor(records, ComparingSession()).regimes;
  EXPECT_EQ(regimes.stored_count, kMaxStoredRegimes);
  EXPECT_EQ(regimes.buckets.size(), kMaxRegimePriors);
}

TEST(PriorFor, ScalesDownEvidenceThatASessionWouldNotAccept) {
  const std::vector<ArmRecord> records(3, RecordOf("studio", 9e14));
  const auto posteriors = PriorFor(records, Session()).posteriors();
  EXPECT_LT(posteriors[0].alpha, kMaxPriorEvidence);
}

TEST(BestVersion, IsTheSessionsVersionElseTheLatest) {
  EXPECT_EQ(BestVersion(2, 1, 5), 2u);
  EXPECT_EQ(BestVersion(1, 2, 5), 2u);
  EXPECT_EQ(BestVersion(1, 2, 1), 1u);
  EXPECT_EQ(BestVersion(2, 1, 1), 1u);
  EXPECT_EQ(BestVersion(1, 0, 0), 1u) << "any version is better than none";
  EXPECT_EQ(BestVersion(2, 2, 2), 2u);
}

}  // namespace
}  // namespace sweepstake::decision
