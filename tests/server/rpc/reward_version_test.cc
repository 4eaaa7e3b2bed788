// Tests evidence of two reward versions side by side, and evidence of the shadow lane: over the
// stream, in SQLite, and read back.
#include <functional>
#include <utility>
#include <vector>

#include "engine_client/decider/session/policy_registry.h"
#include "server/storage/sqlite_prior_store.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::rpc {
namespace {

std::unique_ptr<priors::PriorStore> OpenStore(const std::filesystem::path& path) {
  auto store = storage::OpenSqlitePriorStore(path);
  if (!store.ok()) ADD_FAILURE() << store.status();
  return *std::move(store);
}

v1::Hello HelloOf(const std::string& policy) {
  v1::Hello hello = OneArmHello();
  hello.set_policy(policy);
  return hello;
}

// A base class, so that the directory exists before the store is opened in it.
class Directory {
 protected:
  test_support::TemporaryDirectory directory_;
};

class RewardVersionTest : public Directory, public RpcTest {
 protected:
  RewardVersionTest() : RpcTest(OpenStore(directory_.path() / "priors.sqlite")) {}

  // Runs a new session that learns one window, and returns its welcome message. `applied` is the
  // number of messages since the server started.
  v1::Welcome Learn(const std::string& policy, uint64_t applied) {
    TelemetryClient client(channel_);
    v1::Welcome welcome = client.Open(HelloOf(policy));
    client.Send(Frames(1, 30));
    EXPECT_TRUE(Applied(applied));
    Tick();
    client.AwaitAcknowledgement(1);
    return welcome;
  }

  // Sends a live window of the first arm and a lane visit of every arm; the third arm is twice as
  // fast. Returns the Hello. REQUIRES: this is the first session of the server.
  v1::Hello LearnInTheLane() {
    v1::Hello hello = HelloMessage();
    hello.set_policy("adaptive");
    TelemetryClient client(channel_);
    client.Open(hello);
    v1::StreamTelemetryRequest request = Frames(1, 30);
    for (uint32_t arm = 0; arm < 3; ++arm) {
      v1::ShadowSample& sample = *request.mutable_frame_batch()->add_shadow_samples();
      sample.set_first_frame_index(1);
      sample.set_arm(arm);
      sample.set_detection_time_ns(arm == 2 ? 2'500'000 : 5'000'000);
      sample.set_frame_count(5);
    }
    client.Send(request);
    EXPECT_TRUE(Applied(1));
    Tick();
    client.AwaitAcknowledgement(1);
    return hello;
  }

  v1::Welcome WelcomeOf(const std::string& policy) {
    return TelemetryClient(channel_).Open(HelloOf(policy));
  }

  std::vector<v1::ScenePosterior> List() {
    grpc::ClientContext context;
    v1::ListPosteriorsResponse response;
    EXPECT_TRUE(
        v1::PosteriorsService::NewStub(channel_)->ListPosteriors(&context, {}, &response).ok());
    return {response.scenes().begin(), response.scenes().end()};
  }

  // Returns the posterior. Reward version 0 means the daemon's default.
  v1::ScenePosterior Get(uint32_t reward_version) {
    v1::GetPosteriorRequest request;
    request.set_project("game");
    request.set_scene("harbour");
    request.set_reward_version(reward_version);
    grpc::ClientContext context;
    v1::GetPosteriorResponse response;
    const grpc::Status status =
        v1::PosteriorsService::NewStub(channel_)->GetPosterior(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.scene();
  }
};

TEST_F(RewardVersionTest, EvidenceOfTwoVersionsIsNeverMerged) {
  Learn("paper", 1);
  const priors::SceneEvidence first = Stored("harbour", 1);
  ASSERT_EQ(first.arms.size(), 1u);
  EXPECT_TRUE(Stored("harbour", 3).arms.empty());

  EXPECT_EQ(WelcomeOf("adaptive").prior_source_count(), 0u);
  Learn("adaptive", 2);
  EXPECT_EQ(Stored("harbour", 1).arms[0].live, first.arms[0].live);
  EXPECT_EQ(Stored("harbour", 1).source_count, 1u);
  EXPECT_EQ(Stored("harbour", 3).arms[0].live.window_count, 1u);

  // Each session continues with the evidence of its own version, also after a restart.
  RestartServer();
  const v1::Welcome paper = WelcomeOf("paper");
  EXPECT_EQ(paper.prior_source_count(), 1u);
  EXPECT_NEAR(paper.priors(0).alpha(), 1 + first.arms[0].live.alpha, 1e-12);
  EXPECT_NEAR(paper.priors(0).beta(), 1 + first.arms[0].live.beta, 1e-12);
  EXPECT_EQ(WelcomeOf("adaptive").prior_source_count(), 1u);
}

// A session that changes its weights is a new one. One that keeps them is resumed with its rules,
// from memory and from the store.
TEST_F(RewardVersionTest, EvidenceOfOwnWeightsIsKeptApart) {
  Learn("paper", 1);
  v1::Hello hello = HelloOf("paper");
  hello.mutable_weights()->set_detection(1);
  hello.set_cooldown_ns(7 * kSecondNs);
  v1::Welcome welcome;
  {
    TelemetryClient client(channel_);
    welcome = client.Open(hello);
    EXPECT_EQ(welcome.prior_source_count(), 0u);
    client.Send(Frames(1, 30));
    EXPECT_TRUE(Applied(2));
    Tick();
    client.AwaitAcknowledgement(1);
  }
  EXPECT_EQ(Stored("harbour", 1).source_count, 1u);
  const std::vector<v1::ScenePosterior> scenes = List();
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_GE(scenes[1].reward_version(), decision::kFirstOwnRewardVersion);
  EXPECT_EQ(WelcomeOf("paper").prior_source_count(), 1u);
  EXPECT_EQ(TelemetryClient(channel_).Open(hello).prior_source_count(), 1u);

  Resume(hello, welcome);
  for (const bool from_store : {false, true}) {
    if (from_store) RestartServer();
    const v1::Welcome resumed = TelemetryClient(channel_).Open(hello);
    EXPECT_TRUE(resumed.resumed());
    EXPECT_EQ(resumed.cooldown_ms(), 7000u);
    EXPECT_EQ(resumed.weights().detection(), 1);
  }
  hello.clear_weights();
  EXPECT_FALSE(TelemetryClient(channel_).Open(hello).resumed());
}

double MeanOf(const v1::BetaPosterior& posterior) {
  return posterior.alpha() / (posterior.alpha() + posterior.beta());
}

// The lane measures the third arm as twice as fast; the arm was never active.
TEST_F(RewardVersionTest, ASessionBeginsWithTheEvidenceOfTheLane) {
  const v1::Hello hello = LearnInTheLane();
  RestartServer();
  const v1::Welcome welcome = TelemetryClient(channel_).Open(hello);
  EXPECT_EQ(welcome.prior_source_count(), 1u);
  EXPECT_NEAR(MeanOf(welcome.priors(0)), MeanOf(welcome.priors(1)), 1e-3);
  EXPECT_GT(MeanOf(welcome.priors(2)), MeanOf(welcome.priors(1)) + 0.02);

  const v1::ScenePosterior shown = Get(3);
  ASSERT_EQ(shown.arms_size(), 3);
  EXPECT_EQ(shown.arms(0).arm(), "Grid");
  EXPECT_EQ(shown.arms(0).window_count(), 1u);
  EXPECT_EQ(shown.arms(1).arm(), "KDTree");
  EXPECT_EQ(shown.arms(1).window_count(), 0u);
  EXPECT_EQ(shown.arms(1).visit_count(), 1u);
  EXPECT_GT(shown.arms(1).effective_window_count(), 0) << "lane visits count as windows";
  EXPECT_LT(shown.arms(1).effective_window_count(), 1);
  EXPECT_GT(shown.arms(1).posterior().alpha(), shown.arms(2).posterior().alpha());
}

TEST_F(RewardVersionTest, ANewSceneBeginsWithTheEvidenceOfOtherScenesOfTheProject) {
  v1::Hello hello = LearnInTheLane();
  hello.set_scene("desert");
  v1::Welcome welcome = TelemetryClient(channel_).Open(hello);
  EXPECT_EQ(welcome.prior_source_count(), 1u);
  EXPECT_GT(MeanOf(welcome.priors(2)), MeanOf(welcome.priors(1)) + 0.02);
  EXPECT_TRUE(Stored("desert", 3).arms.empty()) << "the evidence belongs to another scene";

  {
    TelemetryClient client(channel_);
    client.Open(hello);
    client.Send(Frames(1, 30));
    EXPECT_TRUE(Applied(2));
    Tick();
    client.AwaitAcknowledgement(1);
  }
  welcome = TelemetryClient(channel_).Open(hello);
  EXPECT_EQ(Stored("desert", 3).arms.size(), 1u);
  EXPECT_GT(MeanOf(welcome.priors(2)), MeanOf(welcome.priors(1)) + 0.02)
      << "the first arm has evidence of this scene, and the others that of the other scene";

  for (const auto& change : std::vector<std::function<void(v1::Hello&)>>{
           [](v1::Hello& other) { other.set_project("other"); },
           [](v1::Hello& other) { other.set_policy("paper"); },
           [](v1::Hello& other) { other.set_ignore_priors(true); }}) {
    v1::Hello other = hello;
    other.set_scene("tundra");
    change(other);
    welcome = TelemetryClient(channel_).Open(other);
    EXPECT_EQ(welcome.prior_source_count(), 0u);
    EXPECT_EQ(MeanOf(welcome.priors(2)), MeanOf(welcome.priors(1)));
  }
}

TEST_F(RewardVersionTest, ANewSceneOnANewMachineClassBeginsWithTheEvidenceOfOtherClasses) {
  v1::Hello hello = LearnInTheLane();
  hello.set_scene("desert");
  hello.set_machine_class("phone");
  const v1::Welcome welcome = TelemetryClient(channel_).Open(hello);
  EXPECT_EQ(welcome.prior_source_count(), 1u);
  EXPECT_GT(MeanOf(welcome.priors(2)), MeanOf(welcome.priors(1)) + 0.02);
}

TEST_F(RewardVersionTest, TheWelcomeUsesThePolicyNameOfTheRegistry) {
  EXPECT_EQ(WelcomeOf("default").policy(),
            decision::PolicyKindOf("default", decision::ShippedPolicies()).name);
}

TEST_F(RewardVersionTest, ASceneIsListedAndReadOncePerVersion) {
  Learn("paper", 1);
  Learn("adaptive", 2);
  const std::vector<v1::ScenePosterior> scenes = List();
  ASSERT_EQ(scenes.size(), 2u);
  for (const v1::ScenePosterior& scene : scenes) {
    const uint32_t version = scene.reward_version();
    EXPECT_EQ(version, &scene == &scenes[0] ? 1u : 3u);
    EXPECT_EQ(Get(version).reward_version(), version);
    EXPECT_EQ(Get(version).arms(0).posterior().alpha(), scene.arms(0).posterior().alpha());
  }
  EXPECT_EQ(Get(0).reward_version(),
            decision::PolicyKindOf("default", decision::ShippedPolicies()).reward_version);
}

TEST_F(RewardVersionTest, AWatcherReceivesEachVersion) {
  Learn("paper", 1);
  Learn("adaptive", 2);
  grpc::ClientContext context;
  const auto stub = v1::PosteriorsService::NewStub(channel_);
  const auto watcher = stub->WatchPosteriors(&context, {});
  for (uint32_t version : {1u, 3u}) {
    v1::WatchPosteriorsResponse event;
    ASSERT_TRUE(watcher->Read(&event));
    EXPECT_EQ(event.posterior().reward_version(), version);
  }
  context.TryCancel();
}

TEST_F(RewardVersionTest, AnotherVersionBeginsANewSession) {
  v1::Hello hello = HelloOf("adaptive");
  Resume(hello, Learn("paper", 1));
  for (const bool from_store : {false, true}) {
    if (from_store) RestartServer();
    TelemetryClient client(channel_);
    const v1::Welcome welcome = client.Open(hello);
    EXPECT_FALSE(welcome.resumed());
    EXPECT_NE(welcome.session_id(), hello.session_id());
    EXPECT_EQ(welcome.acknowledged_sequence(), 0u);
    EXPECT_EQ(welcome.policy(), "adaptive");
  }
}

}  // namespace
}  // namespace sweepstake::rpc
