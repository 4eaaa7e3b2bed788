// Tests the prior of a session whose scene has many sources.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/policy/log_cost.h"
#include "sweepstake/embedded_decider.h"
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

  // Returns a record of a source's measurement in 50 lane visits.
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
  // Stores the source's evidence about Grid and SAP.
  void PutSource(const std::string& source, double grid_us, double sap_us,
                 const std::function<void(priors::PriorRecord&)>& change = {}) {
    std::vector<priors::PriorRecord> records = {RecordOf(source, "Grid", grid_us),
                                                RecordOf(source, "SAP", sap_us)};
    for (priors::PriorRecord& record : records) {
      if (change) change(record);
    }
    Put(records);
  }
  // The prior in the welcome message: the cost of SAP ÷ the cost of Grid, and the standard
  // deviation of SAP.
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

TEST_F(SourceStartTest, MachinesOfDifferentSpeedAgreeIfTheirCostRatiosAgree) {
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

// A change of the scene changes which arm is cheapest. The latest sources are used, and sources of
// the new build have more weight.
TEST_F(SourceStartTest, EvidenceFromBeforeAChangeOfTheSceneFades) {
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
  EXPECT_GT(widest, 0.5) << "the prior is wide while the sources disagree";
}

// Nine of ten sources are honest; the tenth reports the opposite a million times.
TEST_F(SourceStartTest, ASourceWithManyRecordsDoesNotOutweighTheOthers) {
  for (int i = 0; i < 9; ++i) PutSource("honest " + std::to_string(i), 100, 200);
  const double honest = Begin().ratio;
  PutSource("hostile", 5e6, 0.01, [](priors::PriorRecord& record) {
    record.evidence.alpha *= 1e6;
    record.evidence.beta *= 1e6;
  });
  EXPECT_NEAR(Begin().ratio, honest, 0.1);
}

class SamePriorTest : public SourceStartTest {
 protected:
  // Returns a record of a live window.
  static priors::PriorRecord WindowOf(const std::string& source, const std::string& arm,
                                      double alpha, double beta) {
    priors::PriorRecord record = RecordOf(source, arm, 100);
    record.key.measured_by.clear();
    record.evidence = priors::InUnits({.alpha = alpha, .beta = beta, .window_count = 4});
    return record;
  }

  // Starts a session of the daemon and an embedded decider from the same evidence, and compares
  // their priors bit by bit.
  void ExpectSamePriors(std::vector<priors::PriorRecord> records, const std::string& policy) {
    for (priors::PriorRecord& record : records)
      record.evidence = priors::InUnits(record.evidence);  // as stores keep it
    Put(records);
    v1::Hello hello = Hello();
    hello.set_policy(policy);
    const v1::Welcome welcome = TelemetryClient(channel_).Open(hello);
    std::vector<std::string> arms;
    std::vector<uint32_t> versions;
    for (const v1::Arm& arm : hello.arms()) {
      arms.push_back(arm.name());
      versions.push_back(arm.backend_version());
    }
    EmbeddedOptions options;
    options.project = hello.project();
    options.scene = hello.scene();
    options.machine_class = hello.machine_class();
    options.build = hello.build();
    options.policy = policy;
    options.priors_data = FormatPriors(records);
    const auto decider = EmbeddedDecider::Create(options, arms, versions, 0);
    ASSERT_TRUE(decider.ok()) << decider.status().message();
    EXPECT_EQ((*decider)->prior_source_count(), welcome.prior_source_count());
    ASSERT_EQ(static_cast<size_t>(welcome.priors_size()), (*decider)->beliefs().size());
    size_t best = 0;
    for (size_t arm = 0; arm < arms.size(); ++arm) {
      const v1::BetaPosterior& prior = welcome.priors(static_cast<int>(arm));
      EXPECT_EQ(prior.alpha(), (*decider)->beliefs()[arm].alpha) << arms[arm];
      EXPECT_EQ(prior.beta(), (*decider)->beliefs()[arm].beta) << arms[arm];
      EXPECT_GT(prior.alpha(), 1) << "the evidence says nothing about " << arms[arm];
      const auto mean = [&](size_t i) {
        const v1::BetaPosterior& of_arm = welcome.priors(static_cast<int>(i));
        return of_arm.alpha() / (of_arm.alpha() + of_arm.beta());
      };
      if (mean(arm) > mean(best)) best = arm;
    }
    // `sweepstake priors arm` must select the same arm.
    EXPECT_EQ(*EmbeddedDecider::ArmOfPriors(options, arms, versions), arms[best]);
  }
};

TEST_F(SamePriorTest, ForSourcesThatDifferInBuildMachineClassAndVersion) {
  std::vector<priors::PriorRecord> records;
  int n = 0;
  for (const char* build : {"1.1", "1.0", ""}) {
    for (const char* machine_class : {"desktop", "laptop"}) {
      for (const uint32_t version : {1u, 2u, 3u}) {
        // Add only a few sources of another machine class, because a store returns only a few of
        // them.
        if (machine_class == std::string("laptop") && version != 2) continue;
        const std::string source = "z" + std::to_string(97 * ++n % 31);
        for (priors::PriorRecord record :
             {RecordOf(source, "Grid", 100 + n), RecordOf(source, "SAP", 190 + 3 * n),
              RecordOf(source, "KDTree", 140 - n), WindowOf(source, "Grid", 10 + n, 11.3)}) {
          record.build = build;
          record.key.machine_class = machine_class;
          if (record.key.arm == "SAP") record.key.backend_version = version;
          records.push_back(record);
        }
      }
    }
  }
  ExpectSamePriors(records, "adaptive");
}

TEST_F(SamePriorTest, ForASourceWithSeveralVersionsOfAnArm) {
  std::vector<priors::PriorRecord> records = {
      RecordOf("a", "Grid", 100), RecordOf("a", "Grid", 300), RecordOf("a", "SAP", 150),
      RecordOf("a", "SAP", 250), RecordOf("a", "KDTree", 90)};
  records[1].key.backend_version = 2;
  records[2].key.backend_version = 2;
  records[3].key.backend_version = 3;
  ExpectSamePriors(records, "adaptive");
}

TEST_F(SamePriorTest, ForTheSceneAndOtherScenes) {
  std::vector<priors::PriorRecord> records = {RecordOf("a", "Grid", 100)};
  for (const char* scene : {"desert", "forest", "mine"}) {
    for (const char* arm : {"Grid", "SAP", "KDTree"}) {
      records.push_back(RecordOf("b", arm, 100 + 10 * static_cast<double>(records.size())));
      records.back().key.scene = scene;
      records.push_back(RecordOf("c", arm, 70));
      records.back().key.scene = scene;
      records.back().key.machine_class = "laptop";
    }
  }
  ExpectSamePriors(records, "adaptive");
}

TEST_F(SamePriorTest, ForSeveralRegimes) {
  std::vector<priors::PriorRecord> records;
  for (const char* regime : {"", "13/-4/0", "13/-14/3"}) {
    for (const char* arm : {"Grid", "SAP", "KDTree"}) {
      records.push_back(RecordOf("a", arm, 100 + 10 * static_cast<double>(records.size())));
      records.back().key.regime = regime;
    }
  }
  ExpectSamePriors(records, "adaptive");
}

TEST_F(SamePriorTest, ForOtherScenesOnly) {
  std::vector<priors::PriorRecord> records;
  for (const char* source : {"a", "b"}) {
    for (const char* arm : {"Grid", "SAP", "KDTree"}) {
      records.push_back(RecordOf(source, arm, 100 + 10 * static_cast<double>(records.size())));
      records.back().key.scene = "desert";
      records.back().key.machine_class = "laptop";
    }
  }
  ExpectSamePriors(records, "adaptive");
}

TEST_F(SamePriorTest, ForSummedRewards) {
  std::vector<priors::PriorRecord> records;
  for (const char* source : {"a", "b", "c"}) {
    for (const char* arm : {"Grid", "SAP", "KDTree"}) {
      const auto n = static_cast<double>(records.size());
      records.push_back(WindowOf(source, arm, 3.7 + n, 9.1 / (1 + n)));
      records.back().key.reward_version = 1;
    }
  }
  ExpectSamePriors(records, "paper");
}

}  // namespace
}  // namespace sweepstake::rpc
