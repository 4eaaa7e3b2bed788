#include "server/sessions/scene_quota.h"

#include <gmock/gmock.h>

#include "engine_client/telemetry/daemon_channel.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/sessions/session_start.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

class SceneQuotaTest : public RpcTest {
 protected:
  SceneQuotaTest() {
    options_.max_scenes = 3;
    options_.max_projects = 3;
  }
  static v1::Hello HelloOf(const std::string& project) {
    v1::Hello hello = OneArmHello();
    hello.set_project(project);
    return hello;
  }

  // Stores one window of evidence about the scene, or returns why the session may not begin.
  grpc::Status Play(v1::Hello hello, const std::string& scene) {
    hello.set_scene(scene);
    TelemetryClient client(channel_);
    client.Send(Request(hello));
    const auto welcome = client.Read();
    if (!welcome) return client.Finish();
    client.Send(Frames(1, 30));
    EXPECT_TRUE(Applied(++played_));
    Tick();
    client.AwaitAcknowledgement(1);
    client.Send(Goodbye());
    return client.Finish();
  }
  grpc::Status Import(const std::vector<std::pair<std::string, std::string>>& scenes_and_arms,
                      const std::string& project = "game", bool promote = true) {
    const auto stub = v1::PriorsService::NewStub(channel_);
    grpc::ClientContext context;
    v1::ImportPriorsResponse response;
    const auto writer = stub->ImportPriors(&context, &response);
    v1::ImportPriorsRequest request;
    request.set_promote(promote);
    for (const auto& [scene, arm] : scenes_and_arms) {
      v1::PriorRecord& record = *request.add_records();
      record.set_project(project);
      record.set_scene(scene);
      record.set_arm(arm);
      record.set_backend_version(1);
      record.set_reward_version(1);
      record.set_source_id("elsewhere");
      record.set_source_sequence(1);
      record.set_alpha_increment(1);
    }
    writer->Write(request);
    writer->WritesDone();
    return writer->Finish();
  }

  uint64_t played_ = 0;
};

TEST_F(SceneQuotaTest, RefusesAHelloForOneSceneTooManyAndAcceptsKnownScenes) {
  for (const char* scene : {"a", "b", "c"}) EXPECT_TRUE(Play(OneArmHello(), scene).ok());
  for (int i = 0; i < 1'000; ++i) {
    const grpc::Status status = Play(OneArmHello(), "scene " + std::to_string(i));
    ASSERT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    ASSERT_EQ(ReasonOf(status), v1::ERROR_REASON_TOO_MANY_SCENES);
    ASSERT_THAT(status.error_message(), HasSubstr("--max-scenes"));
  }
  EXPECT_TRUE(Play(OneArmHello(), "b").ok());
  v1::Hello laptop = OneArmHello();
  laptop.set_machine_class("laptop");
  EXPECT_TRUE(Play(laptop, "b").ok()) << "another machine class of a known scene";
  EXPECT_TRUE(Play(HelloOf("other"), "a").ok()) << "each project has its own quota";
}

TEST_F(SceneQuotaTest, RefusesAHelloForOneProjectTooManyAndAcceptsKnownProjects) {
  for (const char* project : {"a", "b"}) EXPECT_TRUE(Play(HelloOf(project), "s").ok());
  EXPECT_TRUE(Import({{"s", "x"}}, "c").ok());
  for (int i = 0; i < 100; ++i) {
    const grpc::Status status = Play(HelloOf("project " + std::to_string(i)), "s");
    ASSERT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    ASSERT_EQ(ReasonOf(status), v1::ERROR_REASON_TOO_MANY_PROJECTS);
    ASSERT_THAT(status.error_message(), HasSubstr("--max-projects"));
  }
  for (const char* project : {"a", "b", "c"})
    EXPECT_TRUE(Play(HelloOf(project), "another").ok()) << "a new scene of a known project";
  options_.max_projects = 4;
  server_->Adjust(options_);
  EXPECT_TRUE(Play(HelloOf("d"), "s").ok());
}

TEST_F(SceneQuotaTest, ARefusedImportHoldsNoScenesAndAnAcceptedOneCountsOnce) {
  const auto opens = [&](TelemetryClient& game, const std::string& scene) {
    v1::Hello hello = OneArmHello();
    hello.set_scene(scene);
    game.Send(Request(hello));
    return game.Read().has_value();
  };
  TelemetryClient first(channel_), second(channel_), third(channel_), fourth(channel_);
  ASSERT_TRUE(opens(first, "a"));
  EXPECT_EQ(ReasonOf(Import({{"w", "x"}, {"x", "x"}, {"y", "x"}, {"z", "x"}})),
            v1::ERROR_REASON_TOO_MANY_SCENES);
  EXPECT_TRUE(opens(second, "b"));
  EXPECT_TRUE(Import({{"a", "x"}, {"b", "x"}}).ok()) << "the sessions have not stored anything yet";
  EXPECT_TRUE(opens(third, "c"));
  EXPECT_FALSE(opens(fourth, "d"));
}

TEST_F(SceneQuotaTest, AnImportOfOneProjectTooManyImportsNothing) {
  EXPECT_TRUE(Import({{"s", "x"}}, "a").ok());
  EXPECT_TRUE(Import({{"s", "x"}}, "b").ok());
  EXPECT_TRUE(Import({{"s", "x"}, {"t", "x"}}, "c").ok());
  EXPECT_EQ(ReasonOf(Import({{"s", "x"}}, "d")), v1::ERROR_REASON_TOO_MANY_PROJECTS);
  EXPECT_TRUE(Import({{"s", "x"}, {"t", "y"}}, "b").ok());
}

TEST_F(SceneQuotaTest, RecordsInQuarantineDoNotCountUntilPromoted) {
  const auto promote = [&](bool preview = false) {
    grpc::ClientContext context;
    v1::PromotePriorsRequest request;
    request.mutable_sources()->set_project("game");
    request.set_preview(preview);
    v1::PromotePriorsResponse response;
    return v1::PriorsService::NewStub(channel_)->PromotePriors(&context, request, &response);
  };
  EXPECT_TRUE(Import({{"a", "x"}, {"b", "x"}}, "game", false).ok());
  EXPECT_TRUE(Import({{"c", "x"}, {"d", "x"}}, "game", false).ok());
  for (const char* scene : {"w", "z"}) EXPECT_TRUE(Play(OneArmHello(), scene).ok());
  EXPECT_EQ(ReasonOf(promote(/*preview=*/true)), v1::ERROR_REASON_TOO_MANY_SCENES);
  EXPECT_EQ(ReasonOf(promote()), v1::ERROR_REASON_TOO_MANY_SCENES);
  EXPECT_TRUE(Play(OneArmHello(), "v").ok()) << "the third";
  options_.max_scenes = 7;
  server_->Adjust(options_);
  EXPECT_TRUE(promote().ok());
  EXPECT_EQ(ReasonOf(Play(OneArmHello(), "one more")), v1::ERROR_REASON_TOO_MANY_SCENES);
}

TEST_F(SceneQuotaTest, RefusesOneArmTooMany) {
  v1::Hello hello = OneArmHello();
  for (int round = 0; round < 4; ++round) {
    hello.clear_arms();
    for (int i = 0; i < 8; ++i) {
      v1::Arm& arm = *hello.add_arms();
      arm.set_name("arm " + std::to_string(8 * round + i));
      arm.set_backend_version(1);
    }
    EXPECT_TRUE(Import({{"a", hello.arms(0).name()}}).ok());
    for (const v1::Arm& arm : hello.arms()) EXPECT_TRUE(Import({{"a", arm.name()}}).ok());
  }
  hello.set_scene("a");
  EXPECT_TRUE(Play(hello, "a").ok()) << "32 arms are known";
  EXPECT_EQ(ReasonOf(Play(OneArmHello(), "a")), v1::ERROR_REASON_TOO_MANY_ARMS);
}

TEST_F(SceneQuotaTest, AnImportBeyondTheQuotaImportsNothing) {
  EXPECT_EQ(ReasonOf(Import({{"a", "x"}, {"b", "x"}, {"a", "y"}, {"c", "x"}, {"d", "x"}})),
            v1::ERROR_REASON_TOO_MANY_SCENES);
  std::vector<std::pair<std::string, std::string>> arms;
  for (int i = 0; i < 33; ++i) arms.emplace_back("a", "arm " + std::to_string(i));
  EXPECT_EQ(ReasonOf(Import(arms)), v1::ERROR_REASON_TOO_MANY_ARMS);
  EXPECT_TRUE(Stored("a").arms.empty());
  EXPECT_TRUE(Import({{"a", "x"}, {"b", "x"}, {"c", "x"}}).ok());
  EXPECT_TRUE(Import({{"a", "x"}, {"a", "y"}}).ok());
}

// Records how often scenes and projects are counted.
class CountedStore final : public storage::ForwardingStore {
 public:
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override {
    ++count_;
    return ForwardingStore::CountScenes(project);
  }
  int count() const { return count_; }

 private:
  int count_ = 0;
};

TEST_F(SceneQuotaTest, ANewSceneIsCountedOnceAndOnlyByCountScene) {
  CountedStore store;
  options_.max_scenes = 0;
  const sessions::SessionRequest hello = FromProto(OneArmHello());
  sessions::StoredStart start =
      sessions::LoadStart(store, hello, options_, /*is_writing_thread=*/false);
  EXPECT_TRUE(start.new_scene);
  EXPECT_TRUE(start.refusal.ok());
  EXPECT_EQ(store.count(), 0);
  sessions::CountScene(store, hello, options_, start);
  EXPECT_EQ(ReasonOfRefusal(start.refusal), v1::ERROR_REASON_TOO_MANY_SCENES);
  EXPECT_EQ(store.count(), 1);
}

// Returns an error for every read of a scene.
class UnreadableStore final : public storage::ForwardingStore {
 public:
  explicit UnreadableStore(absl::Status error) : error_(std::move(error)) {}
  absl::StatusOr<std::optional<priors::SceneEvidence>> LoadScene(
      const priors::SceneKey& /*key*/) override {
    return error_;
  }

 private:
  const absl::Status error_;
};

TEST_F(SceneQuotaTest, TheProjectOfAnUnreadableSceneCountsAsStoredOnlyIfTheSceneIsDamaged) {
  const auto project_count = [&](const absl::Status& error) {
    UnreadableStore store(error);
    sessions::SceneQuota quota(store, options_);
    EXPECT_TRUE(quota.Add({"game", "a", "desktop", 1}, "Grid", 1).ok());
    return quota.unstored()->project_count;
  };
  EXPECT_EQ(project_count(absl::UnavailableError("the disk does not answer")), 0u);
  EXPECT_EQ(project_count(absl::DataLossError("a row is wrong")), std::nullopt);
}

}  // namespace
}  // namespace sweepstake::rpc
