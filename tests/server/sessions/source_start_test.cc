// What a session begins with where many sources know its scene.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "engine_client/decider/policy/log_cost.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

class SourceStartTest : public RpcTest {
 protected:
  static v1::Hello Hello() {
    v1::Hello hello = HelloMessage();
    hello.set_policy("adaptive");
    hello.set_machine_class("desktop");
    hello.set_build("1.1");
    return hello;
  }

  // A record of what the source measured in 50 visits of the lane.
  static priors::PriorRecord RecordOf(const std::string& source, const std::string& arm,
                                      double cost_us) {
    const v1::Hello hello = Hello();
    const decision::Increment visit =
        decision::LogCostIncrement(0, decision::RewardOf(std::log(cost_us)), /*noise=*/0.02 * 0.02);
    return {.key = {.project = hello.project(),
                    .scene = hello.scene(),
                    .measured_by = "lane",
                    .arm = arm,
                    .backend_version = 1,
                    .machine_class = hello.machine_class(),
                    .reward_version = decision::kLogCostRewardVersion},
            .source_id = source,
            .source_sequence = 1,
            .evidence = {.alpha = 50 * visit.alpha, .beta = 50 * visit.beta, .window_count = 50},
            .build = "1.1"};
  }
  // The source knows Grid and SAP.
  void PutSource(const std::string& source, double grid_us, double sap_us,
                 const std::function<void(priors::PriorRecord&)>& change = {}) {
    std::vector<priors::PriorRecord> records = {RecordOf(source, "Grid", grid_us),
                                                RecordOf(source, "SAP", sap_us)};
    for (priors::PriorRecord& record : records) {
      if (change) change(record);
    }
    Put(records);
  }
  // SAP's cost ÷ Grid's as the welcome has it, and the deviation of SAP's.
  struct Start {
    double ratio = 1;
    double deviation = 0;
    uint64_t source_count = 0;
  };
  Start Begin() {
    const v1::Welcome welcome = TelemetryClient(channel_).Open(Hello());
    const auto belief = [&](int arm) {
      return decision::BeliefOf({welcome.priors(arm).alpha(), welcome.priors(arm).beta()});
    };
    return {std::exp(belief(1).mean - belief(0).mean), std::sqrt(belief(1).variance),
            welcome.prior_source_count()};
  }
};

TEST_F(SourceStartTest, MachinesOfAnySpeedAgreeWhereTheirArmsDo) {
  PutSource("a", 100, 200);
  PutSource("b", 10, 20);
  PutSource("c", 3000, 6000);
  const Start start = Begin();
  EXPECT_EQ(start.source_count, 3u);
  EXPECT_NEAR(start.ratio, 2, 0.05);
}

TEST_F(SourceStartTest, AnotherBuildClassOrVersionCountsLess) {
  int n = 0;
  const auto deviation_with = [&](const std::function<void(priors::PriorRecord&)>& change) {
    const std::string name = "source " + std::to_string(++n);
    PutSource(name, 100, 200, change);
    const double deviation = Begin().deviation;
    thread_.Submit(
        [&](priors::PriorStore& store) { EXPECT_TRUE(store.Revoke({.id = name}, false).ok()); });
    Flush();
    return deviation;
  };
  const double same = deviation_with({});
  const double build = deviation_with([](auto& record) { record.build = "1.0"; });
  const double machine_class =
      deviation_with([](auto& record) { record.key.machine_class = "laptop"; });
  const double version = deviation_with([](auto& record) { record.key.backend_version = 2; });
  EXPECT_LT(same, build);
  EXPECT_LT(build, machine_class);
  EXPECT_LT(machine_class, version);
}

// Somebody changes the scene, and with it which arm is the cheapest: the latest sources are heard,
// of which those of the new build count the more.
TEST_F(SourceStartTest, WhatABuildTaughtBeforeTheSceneWasChangedFades) {
  for (int i = 0; i < 100; ++i) {
    PutSource("old " + std::to_string(i), 100, 300, [](auto& record) { record.build = "1.0"; });
  }
  EXPECT_NEAR(Begin().ratio, 3, 0.1);
  int sessions = 0;
  double widest = 0;
  for (Start start = Begin(); start.ratio > 1 && sessions < 50; start = Begin()) {
    widest = std::max(widest, start.deviation);
    PutSource("new " + std::to_string(++sessions), 100, 33);
  }
  EXPECT_EQ(sessions, 11) << "11 at 0.5 outweigh 21 at 0.25";
  EXPECT_GT(widest, 0.5) << "while they disagree a session is not sure";
}

// Nine honest sources of ten; the tenth says the opposite a million times.
TEST_F(SourceStartTest, ALoudSourceDoesNotOutshoutTheOthers) {
  for (int i = 0; i < 9; ++i) PutSource("honest " + std::to_string(i), 100, 200);
  const double honest = Begin().ratio;
  PutSource("hostile", 5e6, 0.01, [](priors::PriorRecord& record) {
    record.evidence.alpha *= 1e6;
    record.evidence.beta *= 1e6;
  });
  EXPECT_NEAR(Begin().ratio, honest, 0.1);
}

}  // namespace
}  // namespace sweepstake::rpc
