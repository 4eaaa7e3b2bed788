// Tests which conditions of sessions and health checks become findings.
#include "server/alerts/alert_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sweepstake::alerts {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr size_t kNoLimit = 1'000;

const priors::SceneKey kHarbour = {"game", "harbour", "desktop", 3};
const std::string kId = "5e55";

// A session of mode AI that is connected and has a stable verdict.
SessionFacts Healthy(const std::string& id = kId, const priors::SceneKey& scene = kHarbour) {
  return {.id = id,
          .scene = scene,
          .is_connected = true,
          .mode = Mode::kAi,
          .verdict = Verdict::kStable,
          .leader_us = 200,
          .active_us = 200};
}

std::map<AlertKey, Finding> FindingsOf(const std::vector<SessionFacts>& sessions) {
  Findings findings;
  for (const SessionFacts& session : sessions) findings.Add(session);
  return findings.Take(kNoLimit);
}

std::vector<Rule> RulesOf(const std::map<AlertKey, Finding>& findings) {
  std::vector<Rule> rules;
  for (const auto& [key, finding] : findings) rules.push_back(key.rule);
  return rules;
}

TEST(AlertRulesTest, AHealthySessionNeedsNobody) {
  EXPECT_THAT(FindingsOf({Healthy()}), IsEmpty());
  SessionFacts tied = Healthy();
  tied.verdict = Verdict::kTie;
  EXPECT_THAT(FindingsOf({tied}), IsEmpty());
}

TEST(AlertRulesTest, EachConditionOfASessionIsAFinding) {
  SessionFacts session = Healthy();
  session.bailed_out = true;
  session.dropped_frames = true;
  session.verdict = Verdict::kDegraded;
  EXPECT_THAT(RulesOf(FindingsOf({session})),
              ElementsAre(Rule::kDegraded, Rule::kBailOuts, Rule::kDroppedFrames));
}

TEST(AlertRulesTest, DegradedScenesAndBailOutsAreSerious) {
  SessionFacts session = Healthy();
  session.bailed_out = true;
  session.verdict = Verdict::kDegraded;
  for (const auto& [key, finding] : FindingsOf({session}))
    EXPECT_EQ(finding.severity, Severity::kSerious) << NameOf(key.rule);
}

TEST(AlertRulesTest, TheLossOfAnAmbiguousSceneIsAddedOverItsSessions) {
  SessionFacts first = Healthy();
  first.verdict = Verdict::kAmbiguous;
  first.expected_loss_ratio = 0.05;
  SessionFacts second = first;
  second.expected_loss_ratio = 0.1;
  SessionFacts untried = first;
  untried.verdict = Verdict::kUnknown;
  const auto findings = FindingsOf({first, second, untried});
  ASSERT_EQ(findings.size(), 1u);
  const auto& [key, finding] = *findings.begin();
  EXPECT_EQ(key, (AlertKey{.rule = Rule::kAmbiguous, .check = {}, .scene = kHarbour}));
  EXPECT_EQ(finding.severity, Severity::kNotice);
  EXPECT_EQ(finding.session_count, 3u);
  EXPECT_NEAR(finding.loss_us.value_or(0), 30, 1e-9);
  EXPECT_EQ(finding.text,
            "No algorithm is clearly the best yet; the leader is expected to cost up to 10 % more "
            "than the best one, on average 15 µs per frame in 3 sessions.");
}

TEST(AlertRulesTest, ALargeExpectedLossIsSerious) {
  SessionFacts session = Healthy();
  session.verdict = Verdict::kAmbiguous;
  session.expected_loss_ratio = 1.44;
  const auto findings = FindingsOf({session});
  EXPECT_EQ(findings.begin()->second.severity, Severity::kSerious);
  EXPECT_THAT(findings.begin()->second.text, HasSubstr("up to 144 %"));
}

TEST(AlertRulesTest, ASessionThatHasLearntNothingIsUnsettled) {
  SessionFacts session = Healthy();
  session.verdict = Verdict::kUnknown;
  const auto findings = FindingsOf({session});
  ASSERT_THAT(RulesOf(findings), ElementsAre(Rule::kAmbiguous));
  EXPECT_EQ(findings.begin()->second.loss_us, std::nullopt);
  EXPECT_EQ(findings.begin()->second.text,
            "Nothing is known about the algorithms yet; 1 session waits for measurements.");
}

TEST(AlertRulesTest, AManualSessionLosesWhatItsArmCostsMoreThanTheLeader) {
  SessionFacts session = Healthy();
  session.mode = Mode::kManual;
  session.active_us = 500;
  const auto findings = FindingsOf({session});
  ASSERT_THAT(RulesOf(findings), ElementsAre(Rule::kManual));
  EXPECT_NEAR(findings.begin()->second.loss_us.value_or(0), 300, 1e-9);
}

TEST(AlertRulesTest, OfALostSessionOnlyTheLossCounts) {
  SessionFacts session = Healthy();
  session.is_connected = false;
  session.is_lost = true;
  session.verdict = Verdict::kDegraded;
  EXPECT_THAT(RulesOf(FindingsOf({session})), ElementsAre(Rule::kLostSessions));
}

TEST(AlertRulesTest, AFindingNamesAtMostThreeSessions) {
  const std::vector<std::string> ids = {"a", "b", "c", "d"};
  std::vector<SessionFacts> sessions;
  for (const std::string& id : ids) {
    sessions.push_back(Healthy(id));
    sessions.back().mode = Mode::kManual;
  }
  const auto findings = FindingsOf(sessions);
  EXPECT_EQ(findings.begin()->second.session_count, 4u);
  EXPECT_THAT(findings.begin()->second.session_ids, ElementsAre("a", "b", "c"));
}

TEST(AlertRulesTest, MachineClassesAndRewardVersionsAreDifferentScenes) {
  const priors::SceneKey laptop = {"game", "harbour", "laptop", 3};
  const priors::SceneKey old = {"game", "harbour", "desktop", 1};
  std::vector<SessionFacts> sessions = {Healthy(), Healthy(kId, laptop), Healthy(kId, old)};
  for (SessionFacts& session : sessions) session.bailed_out = true;
  EXPECT_EQ(FindingsOf(sessions).size(), 3u);
}

TEST(AlertRulesTest, AFailedCheckIsSeriousAndARemarkIsANotice) {
  Findings findings;
  findings.Add({.name = "tls", .problem = "", .remark = ""});
  findings.Add({.name = "store", .problem = "the disk is full", .remark = "old damage"});
  findings.Add({.name = "other", .problem = "", .remark = "a remark"});
  const auto found = findings.Take(kNoLimit);
  ASSERT_EQ(found.size(), 2u);
  const Finding& store = found.at({.rule = Rule::kCheck, .check = "store", .scene = {}});
  EXPECT_EQ(store.severity, Severity::kSerious);
  EXPECT_EQ(store.text, "Health check store: the disk is full.");
  EXPECT_EQ(found.at({.rule = Rule::kCheck, .check = "other", .scene = {}}).severity,
            Severity::kNotice);
}

TEST(AlertRulesTest, AboveTheLimitTheMostUrgentFindingsRemain) {
  Findings findings;
  const priors::SceneKey cheap = {"game", "cheap", "", 3};
  const priors::SceneKey dear = {"game", "dear", "", 3};
  const priors::SceneKey slow = {"game", "slow", "", 3};
  SessionFacts session = Healthy(kId, cheap);
  session.verdict = Verdict::kAmbiguous;
  session.expected_loss_ratio = 0.01;
  findings.Add(session);
  SessionFacts costly = Healthy(kId, dear);
  costly.verdict = Verdict::kAmbiguous;
  costly.expected_loss_ratio = 0.1;
  findings.Add(costly);
  SessionFacts degraded = Healthy(kId, slow);
  degraded.verdict = Verdict::kDegraded;
  findings.Add(degraded);
  EXPECT_THAT(RulesOf(findings.Take(2)), ElementsAre(Rule::kDegraded, Rule::kAmbiguous));
  EXPECT_THAT(findings.Take(2), IsEmpty());
}

TEST(AlertRulesTest, TheIdOfAnAlertDependsOnEveryPartOfItsKeyAndNeverChanges) {
  const AlertKey key = {.rule = Rule::kAmbiguous, .check = {}, .scene = kHarbour};
  EXPECT_EQ(IdOf(key), "6dc4036c92af9117");
  AlertKey other = key;
  other.scene.machine_class = "laptop";
  EXPECT_NE(IdOf(other), IdOf(key));
  other = key;
  other.rule = Rule::kDegraded;
  EXPECT_NE(IdOf(other), IdOf(key));
  other = key;
  other.scene.reward_version = 1;
  EXPECT_NE(IdOf(other), IdOf(key));
}

}  // namespace
}  // namespace sweepstake::alerts
