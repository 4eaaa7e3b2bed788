#include "engine_client/cli/daemon/watch_screen.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace sweepstake::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

v1::WatchPosteriorsResponse PosteriorOf(const std::string& scene, uint64_t source_count) {
  v1::WatchPosteriorsResponse event;
  event.mutable_posterior()->set_project("p");
  event.mutable_posterior()->set_scene(scene);
  event.mutable_posterior()->set_source_count(source_count);
  event.mutable_posterior()->add_arms()->set_arm("SAP");
  return event;
}

v1::WatchPosteriorsResponse ShownDecision(uint64_t id) {
  v1::WatchPosteriorsResponse event;
  v1::DecisionEvent& decision = *event.add_decisions();
  decision.set_session_id("0af3");
  decision.set_scene("arena");
  decision.set_decision_id(id);
  decision.set_active_arm("SAP");
  decision.set_unix_ms(1'700'000'000'000);
  return event;
}

TEST(WatchScreen, InAFilePrintsEachEventOnceWithoutControlCharacters) {
  std::ostringstream out;
  WatchScreen screen(out, false);
  screen.Show(PosteriorOf("arena", 1));
  screen.Show(ShownDecision(5));
  EXPECT_THAT(out.str(), StartsWith("p / arena"));
  EXPECT_THAT(out.str(), HasSubstr("2023-11-14 22:13:20 0af3 of arena: decision 5, SAP"));
  EXPECT_THAT(out.str(), Not(HasSubstr("\x1b")));
  out.str("");
  screen.Show(PosteriorOf("desert", 1));
  EXPECT_THAT(out.str(), Not(HasSubstr("arena")));
}

TEST(WatchScreen, ShowsEachSceneWithTheStandingsOfItsLatestDecision) {
  std::ostringstream out;
  WatchScreen screen(out, false);
  v1::WatchPosteriorsResponse decided = ShownDecision(5);
  decided.mutable_decisions(0)->set_project("p");
  decided.mutable_decisions(0)->set_reward_version(3);
  decided.mutable_decisions(0)->add_arms("Grid");
  decided.mutable_decisions(0)->add_standings()->set_live_window_count(4711);
  screen.Show(decided);
  EXPECT_THAT(out.str(), Not(HasSubstr("4711")));
  screen.Show(PosteriorOf("desert", 1));
  EXPECT_THAT(out.str(), Not(HasSubstr("4711"))) << "the decision is of another scene";
  v1::WatchPosteriorsResponse arena = PosteriorOf("arena", 1);
  arena.mutable_posterior()->set_reward_version(1);
  screen.Show(arena);
  EXPECT_THAT(out.str(), Not(HasSubstr("4711"))) << "the decision has another reward version";
  arena.mutable_posterior()->set_reward_version(3);
  screen.Show(arena);
  EXPECT_THAT(out.str(), HasSubstr("session 0af3 of arena after decision 5"));
  EXPECT_THAT(out.str(), HasSubstr("4711"));
}

TEST(WatchScreen, OnATerminalClearsTheScreenAndDrawsTheLegend) {
  std::ostringstream out;
  WatchScreen screen(out, true);
  screen.Show(PosteriorOf("arena", 1));
  EXPECT_THAT(out.str(), StartsWith("\x1b[H\x1b[2J|: mean"));
  EXPECT_THAT(out.str(), HasSubstr("p / arena"));
}

TEST(WatchScreen, OnATerminalPostponesTheDrawingOfAnEventThatComesTooSoon) {
  std::ostringstream out;
  WatchScreen screen(out, true);
  const WatchScreen::TimePoint start{std::chrono::hours(1)};
  const auto after = [&](int ms) { return start + std::chrono::milliseconds(ms); };
  screen.Show(PosteriorOf("arena", 1), start);
  out.str("");
  screen.Show(PosteriorOf("desert", 1), after(10));
  screen.Redraw(after(149));
  EXPECT_EQ(out.str(), "");
  screen.Redraw(after(150));
  EXPECT_THAT(out.str(), HasSubstr("p / desert"));
  out.str("");
  screen.Redraw(after(1000));
  EXPECT_EQ(out.str(), "") << "nothing has changed";
}

TEST(WatchScreen, OnATerminalRemovesRevokedScenesAndThoseOfAnEarlierWatch) {
  std::ostringstream out;
  WatchScreen screen(out, true);
  const WatchScreen::TimePoint start{std::chrono::hours(1)};
  screen.Show(PosteriorOf("arena", 1), start);
  screen.Show(PosteriorOf("desert", 1), start);
  v1::WatchPosteriorsResponse revoked = PosteriorOf("arena", 0);
  revoked.mutable_posterior()->clear_arms();
  screen.Show(revoked, start);
  out.str("");
  screen.Restart();
  EXPECT_THAT(out.str(), AllOf(HasSubstr("p / desert"), Not(HasSubstr("p / arena"))));
  out.str("");
  screen.DrawAgain();
  screen.Redraw(start + std::chrono::seconds(1));
  EXPECT_FALSE(out.str().empty());
  EXPECT_THAT(out.str(), Not(HasSubstr("p / desert")));
  out.str("");
  screen.Show(PosteriorOf("forest", 1), start + std::chrono::seconds(2));
  EXPECT_THAT(out.str(), AllOf(HasSubstr("p / forest"), Not(HasSubstr("p / desert"))));
}

TEST(WatchScreen, AnEventWithoutContentPrintsNothing) {
  std::ostringstream out;
  WatchScreen screen(out, false);
  screen.Show({});
  EXPECT_EQ(out.str(), "");
}

}  // namespace
}  // namespace sweepstake::cli
