// The session and its AdaptiveBroadPhase in every order of construction and destruction.
#include "sweepstake/adaptive_session.h"

#include <gtest/gtest.h>

#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "sweepstake/scene.h"
#include "tests/support/child_process.h"
#include "tests/support/recording_sink.h"

namespace sweepstake {
namespace {

// At this time scale the decider decides every 2 ms.
Result<std::unique_ptr<Session>> QuickSession() {
  return MakeEmbeddedSession({.policy = "paper", .time_scale = 1000});
}

// Calls of the lane and of the session's thread are likely while these frames run.
class Boxes {
 public:
  template <typename FramePath>
  void Play(FramePath& path, int frame_count = 50) {
    for (int frame = 0; frame < frame_count; ++frame) {
      path.BeginFrame();
      EXPECT_FALSE(path.FindPairs(scene_->aabbs()).empty());
      path.EndFrame({.frame_time_ns = 16'000'000});
      scene_->Step();
      std::this_thread::yield();
    }
  }

  // Makes the calls of three frames from number `first` up to `end`, which is not made.
  template <typename FramePath>
  void Call(FramePath& path, int first, int end) {
    for (int call = first; call < end; ++call) {
      if (call % 3 == 0) path.BeginFrame();
      if (call % 3 == 1) path.FindPairs(scene_->aabbs());
      if (call % 3 == 2) path.EndFrame({.frame_time_ns = 16'000'000});
    }
  }
  static constexpr int kCallCount = 9;

 private:
  std::unique_ptr<Scene> scene_ = std::move(*MakeScene("suite-b", {.object_count = 300}));
};

// Waits until the session's thread has posted a command. The policy "paper" begins by trying every
// arm, so its first decision after 50 frames has one, whatever the frames cost.
void AwaitACommand(const Session& session) {
  while (session.stats().command_count == 0) std::this_thread::yield();
}

const AdaptiveOptions kWithLane = {.shadow = {.enabled = ShadowMode::kOn}};
// Commands are executed in the next frame, because no lane prepares their arms.
const AdaptiveOptions kWithoutLane = {.shadow = {.enabled = ShadowMode::kOff}};

std::unique_ptr<AdaptiveBroadPhase> MakeSearch(Session& session) {
  return std::move(*AdaptiveBroadPhase::Create(kWithLane, &session.sink()));
}

// A session and its broad phase, each of which a test may destroy at any time.
class SessionLifetimeTest : public ::testing::Test {
 protected:
  void Start() {
    ASSERT_TRUE(session_->Start(*search_).ok());
    boxes_.Play(*search_);
    AwaitACommand(*session_);
    boxes_.Play(*search_, 1);  // the lane begins to prepare the commanded arm
  }

  Boxes boxes_;
  std::unique_ptr<Session> session_ = std::move(*QuickSession());
  std::unique_ptr<AdaptiveBroadPhase> search_ = MakeSearch(*session_);
};

TEST_F(SessionLifetimeTest, TheBroadPhaseMayBeDestroyedFirst) {
  Start();
  search_.reset();
  EXPECT_EQ(session_->stats().state, ConnectionState::kClosed);
  EXPECT_TRUE(session_->ExportPriors().ok());
  session_->Stop();
}

TEST_F(SessionLifetimeTest, TheSessionMayBeDestroyedFirstWhileFramesGoOn) {
  Start();
  session_.reset();
  boxes_.Play(*search_);
}

TEST_F(SessionLifetimeTest, FramesMayGoOnAfterAStop) {
  Start();
  session_->Stop();
  boxes_.Play(*search_);
  session_.reset();
  boxes_.Play(*search_);
}

TEST_F(SessionLifetimeTest, ASessionThatNeverStartedMayBeDestroyedFirst) {
  boxes_.Play(*search_);
  session_.reset();
  boxes_.Play(*search_);
}

TEST_F(SessionLifetimeTest, ABroadPhaseThatNeverStartedMayBeDestroyedFirst) {
  boxes_.Play(*search_);
  search_.reset();
  search_ = MakeSearch(*session_);
  Start();
}

TEST_F(SessionLifetimeTest, TheRecordedFlightLivesAsLongAsTheBroadPhase) {
  session_ = std::move(*MakeEmbeddedSession(
      {}, {.flight_recorder = {.memory_mb = 1, .directory = ::testing::TempDir()}}));
  search_ = MakeSearch(*session_);
  ASSERT_TRUE(session_->Start(*search_).ok());
  session_.reset();
  boxes_.Play(*search_);
}

TEST_F(SessionLifetimeTest, OnlyOneRunningSessionUsesABroadPhase) {
  Start();
  const auto other = std::move(*QuickSession());
  EXPECT_EQ(other->Start(*search_).code(), StatusCode::kFailedPrecondition);
  EXPECT_EQ(other->stats().state, ConnectionState::kOffline);
  session_->Stop();
  EXPECT_TRUE(other->Start(*search_).ok());
  search_.reset();
  EXPECT_EQ(other->stats().state, ConnectionState::kClosed);
}

TEST_F(SessionLifetimeTest, ASessionThatFailedToStartDoesNotEndWithTheBroadPhase) {
  auto failing = std::move(*MakeEmbeddedSession({.priors_file = "no/such/file.json"}));
  EXPECT_EQ(failing->Start(*search_).code(), StatusCode::kNotFound);
  EXPECT_TRUE(session_->Start(*search_).ok());
  failing.reset();
  EXPECT_EQ(session_->stats().state, ConnectionState::kEmbedded);
}

// Where a game may return early: after any number of calls.
class EarlyReturnTest : public ::testing::TestWithParam<int> {
 protected:
  Boxes boxes_;
};

INSTANTIATE_TEST_SUITE_P(After, EarlyReturnTest, ::testing::Range(0, Boxes::kCallCount + 1));

TEST_P(EarlyReturnTest, EndsTheObjectThatOwnsBoth) {
  auto game = AdaptiveSession::Create(QuickSession(), kWithLane);
  ASSERT_TRUE(game.ok());
  boxes_.Call(*game, 0, GetParam());
}

TEST_P(EarlyReturnTest, MayFollowAMove) {
  std::optional<AdaptiveSession> game =
      std::move(*AdaptiveSession::Create(QuickSession(), kWithLane));
  boxes_.Call(*game, 0, GetParam());
  AdaptiveSession moved = std::move(*game);
  game.reset();
  boxes_.Call(moved, GetParam(), Boxes::kCallCount);
}

TEST_P(EarlyReturnTest, DestroysTheBroadPhaseFirst) {
  const auto session = std::move(*QuickSession());
  const auto search = MakeSearch(*session);
  ASSERT_TRUE(session->Start(*search).ok());
  boxes_.Call(*search, 0, GetParam());
}

TEST_P(EarlyReturnTest, DestroysTheSessionFirstWhileTheFrameGoesOn) {
  auto session = std::move(*QuickSession());
  const auto search = MakeSearch(*session);
  ASSERT_TRUE(session->Start(*search).ok());
  boxes_.Call(*search, 0, GetParam());
  session.reset();
  boxes_.Call(*search, GetParam(), Boxes::kCallCount);
}

TEST(AdaptiveSessionTest, DecidesAndEndsByItself) {
  auto game = AdaptiveSession::Create(QuickSession(), kWithoutLane);
  ASSERT_TRUE(game.ok()) << game.status().message();
  Boxes boxes;
  boxes.Play(*game);
  AwaitACommand(game->session());
  boxes.Play(*game, 1);
  EXPECT_GT(game->broad_phase().switch_epoch(), 0U);
}

TEST(AdaptiveSessionTest, TheLaneRestsWithAPolicyThatDoesNotUseIt) {
  const auto state = [](const std::string& policy, ShadowMode mode) {
    const auto game =
        AdaptiveSession::Create(MakeEmbeddedSession({.policy = policy}), {.shadow = {mode}});
    EXPECT_TRUE(game.ok()) << game.status().message();
    return game->broad_phase().shadow_stats().state;
  };
  EXPECT_EQ(state("paper", ShadowMode::kAuto), ShadowState::kPaused);
  EXPECT_NE(state("paper", ShadowMode::kOn), ShadowState::kPaused);
  EXPECT_NE(state("adaptive", ShadowMode::kAuto), ShadowState::kPaused);
}

TEST(AdaptiveSessionTest, MayBeMovedWhileItRuns) {
  Boxes boxes;
  std::optional<AdaptiveSession> game =
      std::move(*AdaptiveSession::Create(QuickSession(), kWithoutLane));
  boxes.Play(*game);
  AdaptiveSession moved = std::move(*game);
  game.reset();
  AwaitACommand(moved.session());
  boxes.Play(moved, 1);
  AdaptiveSession other = std::move(*AdaptiveSession::Create(QuickSession()));
  boxes.Play(other);
  other = std::move(moved);
  boxes.Play(other);
  EXPECT_GT(other.broad_phase().switch_epoch(), 0U);
  std::vector<AdaptiveSession> games;
  games.push_back(std::move(other));
  games.push_back(std::move(*AdaptiveSession::Create(QuickSession())));
  for (AdaptiveSession& each : games) boxes.Play(each);
}

TEST(AdaptiveSessionTest, ReturnsTheErrorOfEachPart) {
  EXPECT_EQ(AdaptiveSession::Create(MakeEmbeddedSession({}, {.queue_frames = 3})).status().code(),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(AdaptiveSession::Create(std::unique_ptr<Session>()).status().code(),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(AdaptiveSession::Create(QuickSession(), {.arms = {"Tree"}}).status().code(),
            StatusCode::kNotFound);
  EXPECT_EQ(AdaptiveSession::Create(MakeEmbeddedSession({.priors_file = "no/such/file.json"}))
                .status()
                .code(),
            StatusCode::kNotFound);
}

#if SWEEPSTAKE_CAN_FORK
// A child has neither the session's thread nor the lane's. Some of the forks happen while one of
// them holds a lock.
TEST(AdaptiveSessionTest, AForkedChildDestroysItWithoutWaiting) {
  Boxes boxes;
  auto game = AdaptiveSession::Create(QuickSession(), kWithLane);
  ASSERT_TRUE(game.ok());
  std::optional<AdaptiveSession> owned = std::move(*game);
  for (int round = 0; round < 20; ++round) {
    boxes.Play(*owned, 5);
    ASSERT_EQ(test_support::StatusOfChild([&] { owned.reset(); }), 0);
  }
}
#endif

TEST(AdaptiveBroadPhaseModes, AreReportedToTheSinkByEveryChange) {
  test_support::RecordingSink sink;
  const auto search = std::move(*AdaptiveBroadPhase::Create({}, &sink));
  search->SetMode(Mode::kManual);
  search->SetMode(Mode::kAi);
  search->Freeze();
  ASSERT_EQ(sink.mode_changes.size(), 3U);
  EXPECT_EQ(sink.mode_changes[0].mode, Mode::kManual);
  EXPECT_EQ(sink.mode_changes[0].active_arm, search->active_arm());
  EXPECT_EQ(sink.mode_changes[1].mode, Mode::kAi);
  EXPECT_EQ(sink.mode_changes[2].mode, Mode::kManual);
}

}  // namespace
}  // namespace sweepstake
