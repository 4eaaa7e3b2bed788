// Tests what watchers and callers receive about the running sessions of a scene and its regimes.
#include <gmock/gmock.h>

#include <cstdint>
#include <string>
#include <vector>

#include "engine_client/decider/audit/rederive.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/policy/regime_memory.h"
#include "server/sessions/common/unix_time.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::ElementsAre;

// Costs of the arms Grid, SAP and KDTree. The first is the best while the scene moves, the second
// while it rests.
constexpr uint64_t kMovingUs[] = {1'000, 1'400, 2'000};
constexpr uint64_t kRestingUs[] = {1'500, 900, 2'100};

v1::Hello AdaptiveHello() {
  v1::Hello hello = HelloMessage();
  hello.set_policy("adaptive");
  return hello;
}

// A game that executes each switch command at once.
class Game {
 public:
  Game(const std::shared_ptr<grpc::Channel>& channel, const v1::Hello& hello) : client(channel) {
    id = client.Open(hello).session_id();
  }

  // Returns a window of frames with their descriptor and a sweep of the lane.
  v1::StreamTelemetryRequest Window(bool rests) {
    const uint64_t* costs_us = rests ? kRestingUs : kMovingUs;
    v1::StreamTelemetryRequest request = Frames(++sequence, 100, 10, arm, epoch);
    v1::FrameBatch& batch = *request.mutable_frame_batch();
    for (uint64_t& time_ns : *batch.mutable_detection_time_ns()) time_ns = 1'000 * costs_us[arm];
    batch.mutable_scene_descriptor()->set_object_count(2'000);
    batch.mutable_scene_descriptor()->set_speed_mean(rests ? 0.001F : 0.1F);
    for (uint32_t i = 0; i < 3; ++i) {
      v1::ShadowSample& visit = *batch.add_shadow_samples();
      visit.set_first_frame_index(100 * sequence);
      visit.set_arm(i);
      visit.set_detection_time_ns(1'000 * costs_us[i]);
      visit.set_object_count(2'000);
      visit.set_frame_count(5);
    }
    return request;
  }
  v1::StreamTelemetryRequest Switch(uint32_t new_arm, uint64_t command_id = 0) {
    arm = new_arm;
    v1::StreamTelemetryRequest request;
    request.set_sequence(++sequence);
    v1::SwitchOutcome& outcome = *request.mutable_switch_outcome();
    outcome.set_command_id(command_id);
    outcome.set_arm(arm);
    outcome.set_switch_epoch(++epoch);
    outcome.set_executed(true);
    outcome.set_reason(command_id == 0 ? v1::SWITCH_REASON_MANUAL : v1::SWITCH_REASON_POLICY);
    return request;
  }
  // Reads until the message is acknowledged, and returns the latest switch command before that.
  // Keeps the latest snapshot.
  std::optional<v1::SwitchCommand> AwaitAnswer() {
    std::optional<v1::SwitchCommand> command;
    for (uint64_t acknowledged = 0; acknowledged < sequence;) {
      const auto response = client.Read();
      if (!response) break;
      if (response->has_switch_command()) command = response->switch_command();
      if (response->has_posterior_snapshot()) snapshot = response->posterior_snapshot();
      if (response->has_acknowledgement()) acknowledged = response->acknowledgement().sequence();
    }
    return command;
  }

  TelemetryClient client;
  std::string id;
  v1::PosteriorSnapshot snapshot;
  uint64_t sequence = 0;
  uint32_t arm = 0;
  uint32_t epoch = 0;
};

class ActivityTest : public RpcTest {
 protected:
  void SetUp() override {
    RpcTest::SetUp();
    posteriors_ = v1::PosteriorsService::NewStub(channel_);
  }
  void TearDown() override {
    posteriors_.reset();
    RpcTest::TearDown();
  }
  void Send(Game& game, const v1::StreamTelemetryRequest& request) {
    game.client.Send(request);
    ASSERT_TRUE(Applied(++applied_count_));
  }
  void Play(Game& game, bool rests, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      Send(game, game.Window(rests));
      Tick();
      const auto command = game.AwaitAnswer();
      if (command) Send(game, game.Switch(command->arm(), command->command_id()));
    }
  }
  v1::ScenePosterior Get(uint32_t reward_version = decision::kLogCostRewardVersion) {
    v1::GetPosteriorRequest request;
    request.set_project("game");
    request.set_scene("harbour");
    request.set_reward_version(reward_version);
    v1::GetPosteriorResponse response;
    grpc::ClientContext context;
    EXPECT_TRUE(posteriors_->GetPosterior(&context, request, &response).ok());
    return response.scene();
  }
  v1::ScenePosterior Listed() {
    v1::ListPosteriorsResponse response;
    grpc::ClientContext context;
    EXPECT_TRUE(posteriors_->ListPosteriors(&context, {}, &response).ok());
    EXPECT_EQ(response.scenes_size(), 1);
    return response.scenes(0);
  }

  std::unique_ptr<v1::PosteriorsService::Stub> posteriors_;
  uint64_t applied_count_ = 0;
};

TEST_F(ActivityTest, HasTheRegimesOfASceneThatChanges) {
  v1::Hello hello = AdaptiveHello();
  hello.set_initial_arm(2);
  Game game(channel_, hello);
  for (const bool rests : {false, true, false, true, false, true}) Play(game, rests, 15);
  const v1::ScenePosterior scene = Get();
  EXPECT_THAT(scene.regime_arms(), ElementsAre("Grid", "SAP")) << "the stored evidence";
  const v1::SceneActivity& activity = scene.activity();
  EXPECT_TRUE(activity.is_changing());
  EXPECT_EQ(activity.session_id(), game.id);
  EXPECT_EQ(activity.active_arm(), "SAP");
  EXPECT_GT(activity.recent_switch_count(), 0u);
  ASSERT_EQ(activity.arms_size(), 3);
  EXPECT_EQ(activity.arms(1), "SAP");
  ASSERT_EQ(activity.regimes_size(), 2);
  const v1::RegimePosterior& moving = activity.regimes(0);
  const v1::RegimePosterior& resting = activity.regimes(1);
  EXPECT_EQ(moving.best_arm(), "Grid");
  EXPECT_EQ(resting.best_arm(), "SAP");
  EXPECT_FALSE(moving.is_present());
  EXPECT_TRUE(resting.is_present());
  EXPECT_NEAR(moving.object_count(), 2'000, 1);
  EXPECT_NEAR(moving.speed_mean(), 0.1, 0.001);
  EXPECT_FALSE(moving.has_static_ratio());
  EXPECT_NEAR(moving.frame_share() + resting.frame_share(), 1, 1e-6);
  ASSERT_EQ(moving.arms_size(), 3);
  EXPECT_NEAR(moving.arms(0).cost_us(), 1'000, 50);
  EXPECT_LT(moving.arms(0).low_us(), 1'000);
  EXPECT_GT(moving.arms(0).high_us(), 1'000);
  EXPECT_GT(moving.arms(0).best_probability(), 0.9);
  EXPECT_GT(resting.arms(1).best_probability(), 0.9);
  const v1::RegimePosterior& total = activity.total();
  EXPECT_TRUE(total.best_arm() == "Grid" || total.best_arm() == "SAP") << total.best_arm();
  EXPECT_FALSE(total.has_object_count());
  EXPECT_GT(total.saved_against_single_us(), 100);
  EXPECT_GT(total.saved_against_reference_us(), 800);
  EXPECT_EQ(activity.initial_arm(), "KDTree");
  EXPECT_EQ(total.saved_against_initial_us(), total.saved_against_reference_us());
  EXPECT_EQ(static_cast<float>(game.snapshot.saved_us()), total.saved_against_initial_us())
      << "the game receives the same figure";
  EXPECT_NEAR(total.ran_us(), 1'000, 100);
  EXPECT_EQ(Listed().activity().regimes_size(), 2);
}

TEST_F(ActivityTest, HasOneRegimeWhileTheSceneIsConstant) {
  Game game(channel_, AdaptiveHello());
  Play(game, false, 20);
  const v1::SceneActivity activity = Get().activity();
  EXPECT_FALSE(activity.is_changing());
  EXPECT_EQ(activity.regimes_size(), 0);
  EXPECT_EQ(activity.total().best_arm(), "Grid");
  EXPECT_NEAR(activity.total().object_count(), 2'000, 1);
  EXPECT_TRUE(activity.total().has_saved_against_single_us());
  EXPECT_LE(activity.total().saved_against_single_us(), 1e-3) << "a trial costs time";
  EXPECT_LE(activity.unix_active_since_ms(), priors::UnixNowMs());
}

TEST_F(ActivityTest, IsChangingWhileASessionSwitchesOftenAlthoughOneArmIsTheBest) {
  const Game calm(channel_, AdaptiveHello());
  Game busy(channel_, AdaptiveHello());
  Play(busy, false, 20);
  EXPECT_EQ(busy.snapshot.verdict(), v1::VERDICT_STABLE);
  EXPECT_EQ(Get().activity().session_id(), calm.id);
  EXPECT_FALSE(Get().activity().is_changing());
  for (uint32_t i = 1; i <= 5; ++i) Send(busy, busy.Switch(i % 2));
  EXPECT_TRUE(Get().activity().is_changing());
}

TEST_F(ActivityTest, IsOfTheSessionThatHasBeenConnectedTheLongest) {
  auto first = std::make_unique<Game>(channel_, AdaptiveHello());
  Play(*first, false, 2);
  Game second(channel_, AdaptiveHello());
  EXPECT_EQ(Get().activity().session_id(), first->id);
  EXPECT_EQ(Get().active_session_count(), 2u);
  first.reset();
  ASSERT_TRUE(Eventually([&] { return Get().active_session_count() == 1; }));
  EXPECT_EQ(Get().activity().session_id(), second.id);
  second.client.Cancel();
  ASSERT_TRUE(Eventually([&] { return Get().active_session_count() == 0; }));
  EXPECT_FALSE(Get().has_activity());
}

// A game in manual mode adds no evidence.
TEST_F(ActivityTest, AWatcherReceivesASwitchWithoutNewEvidence) {
  Put({LearntInHours()});
  v1::Hello hello = HelloMessage();
  hello.set_mode(v1::MODE_MANUAL);
  Game game(channel_, hello);
  grpc::ClientContext context;
  const auto watcher = posteriors_->WatchPosteriors(&context, {});
  v1::WatchPosteriorsResponse event;
  ASSERT_TRUE(watcher->Read(&event));
  EXPECT_EQ(event.posterior().activity().active_arm(), "Grid");
  Send(game, game.Switch(2));
  Get(/*reward_version=*/1);  // passes the loop
  clock_.Advance(events::EventBus::kIntervalNs);
  ASSERT_TRUE(watcher->Read(&event));
  EXPECT_EQ(event.posterior().activity().active_arm(), "KDTree");
  EXPECT_EQ(event.posterior().activity().session_id(), game.id);
  EXPECT_EQ(event.posterior().arms_size(), 1);
  context.TryCancel();
}

// Returns the activity of a session with as many regimes as possible and all figures.
sessions::SceneActivity LargestActivity(uint32_t arm_count) {
  sessions::SceneActivity activity;
  activity.run = {.session_count = 1, .session_id = std::string(32, 'a'), .active_arm = "SAP"};
  activity.unix_active_since_ms = 1'800'000'000'000;
  activity.recent_switch_count = 30;
  activity.is_changing = true;
  for (uint32_t arm = 0; arm < arm_count; ++arm) activity.arms.push_back("BruteForce");
  decision::RegimeReport regime = {.centre = {2'000, 0.1, 0.5},
                                   .is_present = true,
                                   .frame_share = 0.25,
                                   .best_arm = 0,
                                   .ran_us = 100,
                                   .saved_against_single_us = 10,
                                   .saved_against_reference_us = 20,
                                   .saved_against_initial_us = 30};
  for (uint32_t arm = 0; arm < arm_count; ++arm) {
    regime.arms.push_back(
        {.cost = decision::ArmReport::Cost{100, 90, 110}, .best_probability = 0.5});
  }
  activity.report.total = regime;
  activity.report.regimes.resize(decision::RegimeMemory::kMaxRegimes, regime);
  return activity;
}

TEST(SceneActivity, AddsAtMostThisManyBytesToEachEvent) {
  for (const uint32_t arm_count : {7u, 32u}) {
    v1::ScenePosterior scene;
    ToProto(LargestActivity(arm_count), scene);
    EXPECT_LT(scene.ByteSizeLong(), 400 + arm_count * 125) << arm_count;
  }
}

// The evidence of each regime is stored apart. The next session receives a prior per regime, in
// which another arm is the best one, and its decisions can be derived again.
TEST_F(ActivityTest, TheNextSessionHasAPriorForEachRegime) {
  {
    Game game(channel_, AdaptiveHello());
    for (const bool rests : {true, false, true, false}) Play(game, rests, 8);
  }
  Flush();
  const priors::SceneEvidence stored = Stored("harbour", decision::kLogCostRewardVersion);
  ASSERT_EQ(stored.arms.size(), 3u);
  for (const priors::SceneEvidence::Arm& arm : stored.arms) {
    ASSERT_EQ(arm.regimes.size(), 2u) << arm.name;
    const auto& moving = arm.regimes.at("10/-3/-").lane;
    const auto& resting = arm.regimes.at("10/-7/-").lane;
    EXPECT_GT(moving.window_count, 0u);
    EXPECT_GT(resting.window_count, 0u);
    EXPECT_EQ(moving.window_count + resting.window_count, arm.lane.window_count);
  }

  Game next(channel_, AdaptiveHello());
  Play(next, /*rests=*/true, 3);
  v1::ExportDecisionsRequest request;
  request.mutable_filter()->set_session_id(next.id);
  const std::vector<decision::AuditRow> rows = ExportAudit(request);
  ASSERT_FALSE(rows.empty());
  const decision::RegimePriors& regimes = rows[0].setup->setup.regime_priors;
  ASSERT_EQ(regimes.buckets.size(), 2u);
  EXPECT_EQ(regimes.stored_count, 2u);
  for (size_t i = 0; i < 2; ++i) {
    const auto priors = regimes.Of(i);
    const bool prefers_grid = priors[0].mean() > priors[1].mean();
    EXPECT_EQ(prefers_grid, regimes.buckets[i] == "10/-3/-");
  }
  const decision::AuditReport report = decision::Rederive(rows);
  EXPECT_FALSE(report.difference) << report.difference->Text();
}

// Such a session knows the names of the scene's regimes, but no priors of them.
TEST_F(ActivityTest, ASessionThatIgnoresPriorsFilesIntoTheStoredRegimes) {
  {
    Game game(channel_, AdaptiveHello());
    for (const bool rests : {true, false, true, false}) Play(game, rests, 8);
  }
  Flush();
  v1::Hello hello = AdaptiveHello();
  hello.set_ignore_priors(true);
  Game next(channel_, hello);
  Play(next, /*rests=*/true, 3);
  v1::ExportDecisionsRequest request;
  request.mutable_filter()->set_session_id(next.id);
  const std::vector<decision::AuditRow> rows = ExportAudit(request);
  ASSERT_FALSE(rows.empty());
  const decision::SessionSetup& setup = rows[0].setup->setup;
  EXPECT_EQ(setup.regime_priors.stored_count, 2u);
  EXPECT_EQ(setup.regime_priors.buckets, (std::vector<std::string>{"10/-3/-", "10/-7/-"}));
  EXPECT_EQ(setup.regime_priors.posteriors,
            std::vector<decision::BetaPosterior>(2 * setup.arms.size()));
  EXPECT_TRUE(setup.priors.empty());
}

}  // namespace
}  // namespace sweepstake::rpc
