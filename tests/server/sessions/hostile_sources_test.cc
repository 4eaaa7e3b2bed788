// A tenth of a game's clients sends false evidence, as strong as the store accepts. The priors of
// other sessions hardly change. After their tokens are revoked the priors are as if these clients
// had never existed.
#include <cmath>
#include <future>
#include <string>
#include <vector>

#include "engine_client/decider/policy/diagnosis.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/math/random.h"
#include "server/rpc/common/proto_conversion.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

constexpr int kHonest = 90;
constexpr int kHostile = 10;
constexpr int64_t kFirstHonestToken = 100;
constexpr int64_t kFirstHostileToken = 1000;

class HostileSourcesTest : public RpcTest {
 protected:
  HostileSourcesTest() {
    options_.tokens = &tokens_;
    tokens_.Add("all", auth::Role::kAdmin);
  }

  static v1::Hello Hello(const std::string& scene) {
    v1::Hello hello = HelloMessage();
    hello.set_scene(scene);
    hello.set_policy("adaptive");
    hello.set_build("1.1");
    return hello;
  }
  // Stores the evidence of a new session with this token: `visits` visits of each arm of Hello() at
  // these costs.
  void Teach(const std::string& scene, int64_t token_id, const std::vector<double>& costs_us,
             double visits) {
    const v1::Hello hello = Hello(scene);
    priors::SourceUpdate update;
    update.progress.source_id = scene + " " + std::to_string(++source_count_);
    update.progress.commit_sequence = 1;
    update.unix_time_s = 100;
    update.origin = {hello.build(), token_id};
    for (int arm = 0; arm < hello.arms_size(); ++arm) {
      const double reward = decision::RewardOf(std::log(costs_us[static_cast<size_t>(arm)]));
      const auto visit = decision::LogCostIncrement(0, reward, /*noise=*/0.02 * 0.02);
      update.increments.push_back({EvidenceKeyOf(FromProto(hello).scene, hello.arms(arm).name(),
                                                 hello.arms(arm).backend_version(), "lane"),
                                   {.alpha = visits * visit.alpha,
                                    .beta = visits * visit.beta,
                                    .window_count = static_cast<uint64_t>(visits)}});
    }
    std::promise<absl::Status> done;
    thread_.Commit(update, [&](const absl::Status& status) { done.set_value(status); });
    EXPECT_TRUE(done.get_future().get().ok());
  }
  // Stores honest evidence from machines of different speeds. SAP is mostly worse than Grid, and
  // KDTree always is.
  void TeachHonestly(const std::string& scene, int client) {
    decision::RandomStream random(7, decision::RandomPurpose::kChoice,
                                  static_cast<uint64_t>(client), 0);
    const double speed = std::exp(random.NextUniform() - 0.5);
    const double noise = std::exp(0.2 * (random.NextUniform() - 0.5));
    Teach(scene, kFirstHonestToken + client, {100 * speed, 110 * speed * noise, 400 * speed}, 50);
  }
  void Lie(const std::string& scene, int client) {
    Teach(scene, kFirstHostileToken + client, {5e6, 0.01, 0.001}, 5e7);
  }

  std::vector<decision::BetaPosterior> BeginsWith(const std::string& scene) {
    const v1::Welcome welcome = TelemetryClient(channel_, "all-token").Open(Hello(scene));
    std::vector<decision::BetaPosterior> priors;
    for (const v1::BetaPosterior& prior : welcome.priors())
      priors.push_back({prior.alpha(), prior.beta()});
    return priors;
  }
  // Returns the probability of each arm to be the best at the start of a new session.
  std::vector<double> BestProbabilities(const std::string& scene) {
    std::vector<double> means;
    std::vector<double> variances;
    for (const decision::BetaPosterior& prior : BeginsWith(scene)) {
      means.push_back(decision::BeliefOf(prior).mean);
      variances.push_back(decision::BeliefOf(prior).variance);
    }
    return decision::DiagnoseLogCosts(means, variances).best_probability;
  }
  void ExpectHardlyMoved(const std::string& attacked) {
    const std::vector<double> honest = BestProbabilities("honest");
    EXPECT_GT(honest[0], 0.5);
    EXPECT_LT(honest[0], 0.95) << "a more certain prior could hardly be moved";
    const std::vector<double> moved = BestProbabilities(attacked);
    for (size_t arm = 0; arm < honest.size(); ++arm) EXPECT_NEAR(moved[arm], honest[arm], 0.05);
  }
  void RevokeTheHostile() {
    const auto service = v1::PriorsService::NewStub(channel_);
    for (int client = 0; client < kHostile; ++client) {
      grpc::ClientContext context;
      context.AddMetadata("authorization", "Bearer all-token");
      v1::RevokePriorsRequest request;
      request.mutable_sources()->set_token_id(kFirstHostileToken + client);
      v1::RevokePriorsResponse response;
      EXPECT_TRUE(service->RevokePriors(&context, request, &response).ok());
      EXPECT_GT(response.source_count(), 0u);
    }
  }
  void ExpectRestored(const std::string& attacked) {
    const auto honest = BeginsWith("honest");
    const auto restored = BeginsWith(attacked);
    ASSERT_EQ(restored.size(), honest.size());
    for (size_t arm = 0; arm < honest.size(); ++arm) {
      EXPECT_EQ(restored[arm].alpha, honest[arm].alpha) << "equal in every bit";
      EXPECT_EQ(restored[arm].beta, honest[arm].beta);
    }
  }

  ScriptedTokens tokens_;
  int source_count_ = 0;
};

TEST_F(HostileSourcesTest, ATenthOfHostileTokensHardlyChangesPriorsUntilRevoked) {
  for (int client = 0; client < kHonest; ++client) {
    TeachHonestly("honest", client);
    TeachHonestly("attacked", client);
    if (client % 9 == 4) Lie("attacked", client / 9);
  }
  ExpectHardlyMoved("attacked");
  RevokeTheHostile();
  ExpectRestored("attacked");
}

TEST_F(HostileSourcesTest, ATenthOfHostileTokensGainsNothingByTheLatestEvidence) {
  for (int client = 0; client < kHonest; ++client) {
    TeachHonestly("honest", client);
    TeachHonestly("attacked", client);
  }
  for (int client = 0; client < kHostile; ++client) Lie("attacked", client);
  ExpectHardlyMoved("attacked");
  RevokeTheHostile();
  ExpectRestored("attacked");
}

TEST_F(HostileSourcesTest, ATokenWithEndlessSessionsGainsNothing) {
  for (int client = 0; client < kHonest; ++client) {
    TeachHonestly("honest", client);
    TeachHonestly("attacked", client);
    if (client % 9 == 4) Lie("attacked", client / 9);
  }
  for (int session = 0; session < 200; ++session) Lie("attacked", 0);
  ExpectHardlyMoved("attacked");
  RevokeTheHostile();
  ExpectRestored("attacked");
}

}  // namespace
}  // namespace sweepstake::rpc
