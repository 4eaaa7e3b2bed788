// Tests the daemon's comparison of the measurements of two builds.
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class CompareBuildsTest : public RpcTest {
 protected:
  // Adds a source that ran an arm in a scene, and was seen at this time.
  void Add(const std::string& build, const std::string& scene, const std::string& arm, double alpha,
           const std::string& measured_by = "", const std::string& regime = "") {
    v1::PriorRecord& record = *request_.add_records();
    record.set_project("game");
    record.set_scene(scene);
    record.set_measured_by(measured_by);
    record.set_regime(regime);
    record.set_arm(arm);
    record.set_backend_version(1);
    record.set_machine_class("pc");
    record.set_reward_version(3);
    record.set_source_id("source " + build);
    record.set_source_sequence(1);
    record.set_alpha_increment(alpha);
    record.set_beta_increment(1000 - alpha);
    record.set_window_count(4);
    record.set_build(build);
    record.set_unix_last_seen_s(build == "1.1" ? 100 : 200);
  }
  void Import(bool promote) {
    request_.set_promote(promote);
    grpc::ClientContext context;
    v1::ImportPriorsResponse response;
    const auto writer = stub()->ImportPriors(&context, &response);
    writer->Write(request_);
    writer->WritesDone();
    ASSERT_TRUE(writer->Finish().ok());
    EXPECT_EQ(response.applied_count(), static_cast<uint64_t>(request_.records_size()));
    request_.clear_records();
  }
  std::vector<v1::SceneComparison> Compare(const v1::CompareBuildsRequest& request) {
    grpc::ClientContext context;
    const auto reader = stub()->CompareBuilds(&context, request);
    std::vector<v1::SceneComparison> scenes;
    for (v1::CompareBuildsResponse part; reader->Read(&part);)
      scenes.insert(scenes.end(), part.scenes().begin(), part.scenes().end());
    EXPECT_TRUE(reader->Finish().ok());
    return scenes;
  }
  std::unique_ptr<v1::PriorsService::Stub> stub() { return v1::PriorsService::NewStub(channel_); }

  v1::ImportPriorsRequest request_;
};

TEST_F(CompareBuildsTest, TheScenesInWhichAnArmChangesAreNamed) {
  for (const char* scene : {"arena", "cave", "harbour"}) {
    for (const char* build : {"1.1", "1.2"}) {
      Add(build, scene, "Grid", 600);
      const bool is_changed = std::string(build) == "1.2" && std::string(scene) == "cave";
      Add(build, scene, "SAP", is_changed ? 650 : 570);
    }
  }
  Add("1.1", "bridge", "SAP", 600);
  Import(/*promote=*/true);
  Add("1.2", "quay", "SAP", 600);
  Import(/*promote=*/false);
  v1::CompareBuildsRequest request;
  request.mutable_before()->set_build("1.1");
  request.mutable_after()->set_build("1.2");
  request.set_changes_only(true);
  const std::vector<v1::SceneComparison> changes = Compare(request);
  ASSERT_THAT(changes, SizeIs(2)) << "what waits in quarantine does not count";
  EXPECT_EQ(changes[0].scene(), "bridge");
  EXPECT_FALSE(changes[0].known_in_both());
  const v1::SceneComparison& cave = changes[1];
  EXPECT_EQ(cave.project(), "game");
  EXPECT_EQ(cave.scene(), "cave");
  EXPECT_EQ(cave.machine_class(), "pc");
  EXPECT_EQ(cave.reward_version(), 3u);
  EXPECT_TRUE(cave.known_in_both());
  EXPECT_TRUE(cave.leader_changed());
  EXPECT_THAT(cave.builds(), ElementsAre("1.2", "1.1")) << "the latest first";
  ASSERT_EQ(cave.arms_size(), 2);
  EXPECT_TRUE(cave.arms(1).changed());
  EXPECT_EQ(cave.arms(1).after().cost_ratio().median(), 1);
  EXPECT_GT(cave.arms(1).before().cost_ratio().median(), 1.5);
  EXPECT_NEAR(cave.largest_log_change(), std::log(cave.arms(0).after().cost_ratio().median()),
              1e-9);
  request.clear_changes_only();
  const std::vector<v1::SceneComparison> all = Compare(request);
  ASSERT_THAT(all, SizeIs(4));
  EXPECT_EQ(all[0].arms(0).after().posterior().high_95(), 0) << "intervals are only for one scene";
  request.set_scene("cave");
  const std::vector<v1::SceneComparison> one = Compare(request);
  ASSERT_THAT(one, SizeIs(1));
  const v1::RewardPosterior& live = one[0].arms(0).after().live();
  EXPECT_LT(live.low_95(), live.low_50());
  EXPECT_LT(live.low_50(), live.high_50());
  EXPECT_LT(live.high_50(), live.high_95());
  request.set_project("another");
  EXPECT_THAT(Compare(request), IsEmpty());
}

TEST_F(CompareBuildsTest, WindowsAndVisitsOfAllBuildsStandBesideTheEvidenceOfTheOthers) {
  Add("1.1", "arena", "Grid", 600);
  Add("1.2", "arena", "Grid", 500);
  Add("1.2", "arena", "SAP", 400, "lane");
  Import(/*promote=*/true);
  v1::CompareBuildsRequest request;
  request.mutable_before()->set_build("1.2");
  request.mutable_before()->set_others(true);
  const std::vector<v1::SceneComparison> scenes = Compare(request);
  ASSERT_THAT(scenes, SizeIs(1));
  ASSERT_EQ(scenes[0].arms_size(), 2);
  const v1::ArmComparison& grid = scenes[0].arms(0);
  EXPECT_EQ(grid.before().posterior().alpha(), 601);
  EXPECT_EQ(grid.after().posterior().alpha(), 1101);
  EXPECT_EQ(grid.after().live().beta(), 901);
  EXPECT_FALSE(grid.after().has_lane());
  const v1::ArmComparison& sap = scenes[0].arms(1);
  EXPECT_FALSE(sap.has_before());
  EXPECT_FALSE(sap.after().has_live());
  EXPECT_EQ(sap.after().lane().alpha(), 401);
  EXPECT_LT(sap.after().posterior().alpha(), sap.after().lane().alpha() - 50)
      << "the unknown bias of the lane limits the evidence";
}

TEST_F(CompareBuildsTest, TheRegimesOfANamedSceneCountTogether) {
  Add("1.1", "arena", "Grid", 600);
  Add("1.1", "arena", "Grid", 500, "", "6/0/0");
  Add("1.1", "arena", "SAP", 400, "lane", "8/1/0");
  Import(/*promote=*/true);
  std::vector<std::string> regimes;
  for (const v1::SceneComparison& scene : Compare({})) regimes.push_back(scene.regime());
  EXPECT_THAT(regimes, ElementsAre("", "6/0/0", "8/1/0"));
  v1::CompareBuildsRequest request;
  request.set_scene("arena");
  const std::vector<v1::SceneComparison> scenes = Compare(request);
  ASSERT_THAT(scenes, SizeIs(1));
  EXPECT_EQ(scenes[0].regime(), "");
  ASSERT_EQ(scenes[0].arms_size(), 2);
  EXPECT_EQ(scenes[0].arms(0).after().live().alpha(), 1101);
  EXPECT_EQ(scenes[0].arms(1).after().lane().alpha(), 401);
}

}  // namespace
}  // namespace sweepstake::rpc
