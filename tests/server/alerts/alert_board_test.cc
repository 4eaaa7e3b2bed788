// Tests the life of alerts and silences.
#include "server/alerts/alert_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sweepstake::alerts {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr int64_t kSecondNs = 1'000'000'000;
constexpr int64_t kUnixMs = 1'700'000'000'000;

AlertKey KeyOf(Rule rule, const std::string& scene = "harbour") {
  return {.rule = rule, .check = {}, .scene = {"game", scene, "", 3}};
}
const AlertKey kDegradedKey = KeyOf(Rule::kDegraded);

class AlertBoardTest : public ::testing::Test {
 protected:
  // Looks `seconds` after the previous look.
  AlertChanges Look(int64_t seconds, const std::map<AlertKey, Finding>& findings) {
    seconds_ += seconds;
    return board_.Update(findings, seconds_ * kSecondNs, UnixNowMs());
  }
  int64_t UnixNowMs() const { return kUnixMs + seconds_ * 1000; }
  absl::Status Silence(const AlertKey& key, int64_t for_s = 0) {
    return board_.Add({.id = IdOf(key),
                       .unix_until_ms = for_s == 0 ? 0 : UnixNowMs() + for_s * 1000,
                       .comment = "known",
                       .silenced_by = "alice"},
                      seconds_ * kSecondNs);
  }

  AlertBoard board_;
  int64_t seconds_ = 100;
};

std::vector<std::string> ScenesOf(const std::vector<Alert>& alerts) {
  std::vector<std::string> scenes;
  for (const Alert& alert : alerts) scenes.push_back(alert.key.scene.scene);
  return scenes;
}

TEST_F(AlertBoardTest, AnAlertBeginsOnceAndEndsWhenItsConditionIsGone) {
  EXPECT_EQ(Look(0, {{kDegradedKey, {}}}).begun.size(), 1u);
  EXPECT_THAT(Look(5, {{kDegradedKey, {}}}).begun, IsEmpty());
  EXPECT_THAT(Look(29, {}).ended, IsEmpty());
  const AlertChanges changes = Look(1, {});
  ASSERT_EQ(changes.ended.size(), 1u);
  EXPECT_EQ(changes.ended[0].id, IdOf(kDegradedKey));
  EXPECT_EQ(changes.ended[0].unix_since_ms, kUnixMs + 100'000);
  EXPECT_THAT(board_.ranked(), IsEmpty());
}

TEST_F(AlertBoardTest, AConditionThatComesAndGoesIsOneAlert) {
  Look(0, {{kDegradedKey, {}}});
  for (int i = 0; i < 10; ++i) {
    const AlertChanges gone = Look(20, {});
    const AlertChanges back = Look(5, {{kDegradedKey, {}}});
    EXPECT_TRUE(gone.begun.empty() && gone.ended.empty() && back.begun.empty() &&
                back.ended.empty());
  }
}

TEST_F(AlertBoardTest, AnAmbiguousSceneIsAnAlertAfterAMinute) {
  const AlertKey key = KeyOf(Rule::kAmbiguous);
  EXPECT_THAT(Look(0, {{key, {}}}).begun, IsEmpty());
  EXPECT_THAT(Look(59, {{key, {}}}).begun, IsEmpty());
  EXPECT_THAT(board_.ranked(), IsEmpty());
  const AlertChanges changes = Look(1, {{key, {}}});
  ASSERT_EQ(changes.begun.size(), 1u);
  EXPECT_EQ(changes.begun[0].unix_since_ms, kUnixMs + 100'000);
}

TEST_F(AlertBoardTest, AWaitingAlertStartsAgainIfItsConditionIsInterrupted) {
  const AlertKey key = KeyOf(Rule::kLostSessions);
  Look(0, {{key, {}}});
  Look(25, {});
  EXPECT_THAT(Look(5, {{key, {}}}).begun, IsEmpty());
  EXPECT_EQ(Look(30, {{key, {}}}).begun.size(), 1u);
}

TEST_F(AlertBoardTest, SeriousAlertsComeFirstThenTheHighestLossThenTheMostSessions) {
  Look(0, {{KeyOf(Rule::kManual, "none"), {.session_count = 1}},
           {KeyOf(Rule::kManual, "many"), {.session_count = 9}},
           {KeyOf(Rule::kManual, "dear"), {.session_count = 1, .loss_us = 70}},
           {KeyOf(Rule::kManual, "cheap"), {.session_count = 5, .loss_us = 3}},
           {KeyOf(Rule::kDegraded, "slow"), {.severity = Severity::kSerious}}});
  EXPECT_THAT(ScenesOf(board_.ranked()), ElementsAre("slow", "dear", "cheap", "many", "none"));
  ASSERT_TRUE(Silence(KeyOf(Rule::kDegraded, "slow")).ok());
  EXPECT_THAT(ScenesOf(board_.ranked()), ElementsAre("dear", "cheap", "many", "none", "slow"));
}

TEST_F(AlertBoardTest, CountsTellSilencedAlertsFromOthers) {
  Look(0, {{KeyOf(Rule::kManual, "a"), {}}, {KeyOf(Rule::kManual, "b"), {}}, {kDegradedKey, {}}});
  ASSERT_TRUE(Silence(KeyOf(Rule::kManual, "a")).ok());
  const AlertCounts counts = board_.Counts();
  EXPECT_EQ(counts.announced[static_cast<size_t>(Rule::kManual)], 1u);
  EXPECT_EQ(counts.silenced[static_cast<size_t>(Rule::kManual)], 1u);
  EXPECT_EQ(counts.announced[static_cast<size_t>(Rule::kDegraded)], 1u);
}

TEST_F(AlertBoardTest, ASilencedAlertStaysInTheListAndItsEndIsStillAnnounced) {
  Look(0, {{kDegradedKey, {}}});
  ASSERT_TRUE(Silence(kDegradedKey).ok());
  ASSERT_NE(board_.Find(IdOf(kDegradedKey)), nullptr);
  EXPECT_EQ(board_.Find(IdOf(kDegradedKey))->silence->comment, "known");
  EXPECT_EQ(Look(30, {}).ended.size(), 1u);
}

TEST_F(AlertBoardTest, ASilenceWithoutTimeEndsWithItsAlert) {
  Look(0, {{kDegradedKey, {}}});
  ASSERT_TRUE(Silence(kDegradedKey).ok());
  Look(30, {});
  EXPECT_EQ(Look(5, {{kDegradedKey, {}}}).begun.size(), 1u);
  EXPECT_EQ(board_.Find(IdOf(kDegradedKey))->silence, std::nullopt);
}

TEST_F(AlertBoardTest, ATimedSilenceCoversLaterAlertsAndIsAnnouncedWhenItEnds) {
  Look(0, {{kDegradedKey, {}}});
  ASSERT_TRUE(Silence(kDegradedKey, 3600).ok());
  Look(30, {});
  EXPECT_THAT(Look(5, {{kDegradedKey, {}}}).begun, IsEmpty());
  EXPECT_TRUE(board_.ranked().at(0).silence.has_value());
  EXPECT_EQ(Look(3600, {{kDegradedKey, {}}}).begun.size(), 1u);
}

TEST_F(AlertBoardTest, AnAnnouncedAlertIsAnnouncedAgainWhenItsSilenceEnds) {
  EXPECT_EQ(Look(0, {{kDegradedKey, {}}}).begun.size(), 1u);
  ASSERT_TRUE(Silence(kDegradedKey, 3600).ok());
  EXPECT_THAT(Look(5, {{kDegradedKey, {}}}).begun, IsEmpty());
  EXPECT_EQ(Look(3600, {{kDegradedKey, {}}}).begun.size(), 1u);
  EXPECT_THAT(Look(5, {{kDegradedKey, {}}}).begun, IsEmpty());
}

TEST_F(AlertBoardTest, AnAlertThatWasNeverAnnouncedEndsQuietly) {
  Look(0, {{kDegradedKey, {}}});
  ASSERT_TRUE(Silence(kDegradedKey, 3600).ok());
  Look(30, {});
  Look(5, {{kDegradedKey, {}}});
  EXPECT_THAT(Look(30, {}).ended, IsEmpty());
}

TEST_F(AlertBoardTest, TheEndOfASilenceCanBeOrdered) {
  Look(0, {{kDegradedKey, {}}});
  EXPECT_FALSE(board_.Unsilence(IdOf(kDegradedKey)));
  ASSERT_TRUE(Silence(kDegradedKey).ok());
  EXPECT_TRUE(board_.Unsilence(IdOf(kDegradedKey)));
  EXPECT_EQ(board_.Find(IdOf(kDegradedKey))->silence, std::nullopt);
}

TEST_F(AlertBoardTest, SilencesSurviveInTheirText) {
  Look(0, {{kDegradedKey, {}}, {KeyOf(Rule::kManual), {}}});
  ASSERT_TRUE(Silence(kDegradedKey).ok());
  ASSERT_TRUE(Silence(KeyOf(Rule::kManual), 10).ok());
  EXPECT_TRUE(board_.TakeSilencesChanged());
  EXPECT_FALSE(board_.TakeSilencesChanged());
  const std::string text = board_.SilencesText();

  board_ = {};
  seconds_ += 60;  // the timed silence ends meanwhile
  ASSERT_TRUE(board_.Restore(text, seconds_ * kSecondNs, UnixNowMs()).ok());
  EXPECT_EQ(Look(0, {{kDegradedKey, {}}, {KeyOf(Rule::kManual), {}}}).begun.size(), 1u);
  const Alert* alert = board_.Find(IdOf(kDegradedKey));
  ASSERT_NE(alert, nullptr);
  ASSERT_TRUE(alert->silence.has_value());
  EXPECT_EQ(alert->silence->silenced_by, "alice");
}

TEST_F(AlertBoardTest, ASilenceWhoseAlertDoesNotReturnIsForgotten) {
  Look(0, {{kDegradedKey, {}}});
  ASSERT_TRUE(Silence(kDegradedKey).ok());
  const std::string text = board_.SilencesText();
  board_ = {};
  ASSERT_TRUE(board_.Restore(text, seconds_ * kSecondNs, UnixNowMs()).ok());
  Look(AlertBoard::kForgetSilenceNs / kSecondNs, {});
  EXPECT_TRUE(board_.TakeSilencesChanged());
  EXPECT_EQ(Look(5, {{kDegradedKey, {}}}).begun.size(), 1u);
}

TEST_F(AlertBoardTest, ADamagedTextIsAnErrorAndChangesNothing) {
  Look(0, {{kDegradedKey, {}}});
  ASSERT_TRUE(Silence(kDegradedKey).ok());
  for (const char* text : {"", "{", "[]", "{\"version\": 2, \"silences\": []}",
                           "{\"version\": 1, \"silences\": [{\"id\": 7}]}"}) {
    EXPECT_TRUE(absl::IsDataLoss(board_.Restore(text, 0, UnixNowMs()))) << text;
  }
  EXPECT_TRUE(board_.Find(IdOf(kDegradedKey))->silence.has_value());
}

TEST_F(AlertBoardTest, TheNumberOfSilencesIsBounded) {
  std::string silences;
  for (size_t i = 0; i <= AlertBoard::kMaxSilences; ++i) {
    silences += std::string(i == 0 ? "" : ",") + "{\"id\":\"" + std::to_string(i) +
                "\",\"unix_until_ms\":0,\"comment\":\"\",\"silenced_by\":\"\"}";
  }
  const std::string text = "{\"version\":1,\"silences\":[" + silences + "]}";
  ASSERT_TRUE(board_.Restore(text, seconds_ * kSecondNs, UnixNowMs()).ok());
  Look(0, {{kDegradedKey, {}}});
  EXPECT_TRUE(absl::IsResourceExhausted(Silence(kDegradedKey)));
  EXPECT_TRUE(board_.Unsilence("0"));
  EXPECT_TRUE(Silence(kDegradedKey).ok());
}

TEST_F(AlertBoardTest, TheNumberOfAlertsIsBounded) {
  std::map<AlertKey, Finding> first;
  std::map<AlertKey, Finding> second;
  for (size_t i = 0; i < AlertBoard::kMaxAlerts; ++i) {
    first[KeyOf(Rule::kManual, std::to_string(i))] = {};
    second[KeyOf(Rule::kDegraded, std::to_string(i))] = {};
  }
  Look(0, first);
  EXPECT_THAT(Look(5, second).begun, IsEmpty());
  EXPECT_EQ(board_.ranked().size(), AlertBoard::kMaxAlerts);
  Look(25, second);
  EXPECT_EQ(Look(5, second).begun.size(), AlertBoard::kMaxAlerts);
}

}  // namespace
}  // namespace sweepstake::alerts
