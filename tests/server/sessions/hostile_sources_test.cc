// A tenth of a game's clients sends false evidence, as strong as the store accepts. The priors of
// other sessions hardly change. After these clients are revoked the priors are as if they had never
// existed. The clients have tokens of their own, or share one and differ by ticket or network.
#include <cmath>
#include <future>
#include <string>
#include <utility>
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
constexpr int64_t kSharedToken = 7;
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
  // Stores the evidence of a new session: `visits` visits of each arm of Hello() at these costs.
  void Teach(const std::string& scene, priors::SourceOrigin origin,
             const std::vector<double>& costs_us, double visits) {
    const v1::Hello hello = Hello(scene);
    priors::SourceUpdate update;
    update.progress.source_id = scene + " " + std::to_string(++source_count_);
    update.progress.commit_sequence = 1;
    update.unix_time_s = 100;
    update.origin = std::move(origin);
    update.origin.build = hello.build();
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
    TeachHonestly(scene, client, {.build = "", .token_id = kFirstHonestToken + client});
  }
  void TeachHonestly(const std::string& scene, int client, const priors::SourceOrigin& origin) {
    decision::RandomStream random(7, decision::RandomPurpose::kChoice,
                                  static_cast<uint64_t>(client), 0);
    const double speed = std::exp(random.NextUniform() - 0.5);
    const double noise = std::exp(0.2 * (random.NextUniform() - 0.5));
    Teach(scene, origin, {100 * speed, 110 * speed * noise, 400 * speed}, 50);
  }
  void Lie(const std::string& scene, int client) {
    Lie(scene, {.build = "", .token_id = kFirstHostileToken + client});
  }
  void Lie(const std::string& scene, const priors::SourceOrigin& origin) {
    Teach(scene, origin, {5e6, 0.01, 0.001}, 5e7);
  }
  // The origin of a game of these players, who share one token.
  static priors::SourceOrigin AtNetwork(int player, int network = 0) {
    return {.build = "",
            .token_id = kSharedToken,
            .player = "",
            .network = "10." + std::to_string(network) + "." + std::to_string(player) + ".0/24"};
  }
  static priors::SourceOrigin WithTicket(int number) {
    return {.build = "",
            .token_id = kSharedToken,
            .player = "player-" + std::to_string(number),
            .network = "203.0.113.0/24"};
  }
  // Each honest player begins one session. Then each hostile one begins `sessions` sessions from
  // three networks, or three sessions with the same ticket.
  void PlayWithOneToken(bool with_tickets, int sessions) {
    const auto origin = [&](int player, int network) {
      return with_tickets ? WithTicket(player) : AtNetwork(player, network);
    };
    for (int client = 0; client < kHonest; ++client) {
      TeachHonestly("honest", client, origin(client, 0));
      TeachHonestly("attacked", client, origin(client, 0));
    }
    for (int session = 0; session < sessions; ++session) {
      for (int client = kHonest; client < kHonest + kHostile; ++client) {
        for (int network = 0; network < 3; ++network) Lie("attacked", origin(client, network));
      }
    }
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
  void Revoke(const v1::SourceFilter& sources) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer all-token");
    v1::RevokePriorsRequest request;
    *request.mutable_sources() = sources;
    v1::RevokePriorsResponse response;
    const auto service = v1::PriorsService::NewStub(channel_);
    EXPECT_TRUE(service->RevokePriors(&context, request, &response).ok());
    EXPECT_GT(response.source_count(), 0u);
  }
  void RevokeTheHostile() {
    for (int client = 0; client < kHostile; ++client) {
      v1::SourceFilter sources;
      sources.set_token_id(kFirstHostileToken + client);
      Revoke(sources);
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

TEST_F(HostileSourcesTest, ATenthOfThePlayersWithTicketsHardlyChangesPriorsUntilRevoked) {
  PlayWithOneToken(/*with_tickets=*/true, /*sessions=*/10);
  ExpectHardlyMoved("attacked");
  for (int client = kHonest; client < kHonest + kHostile; ++client) {
    v1::SourceFilter sources;
    sources.set_player(WithTicket(client).player);
    Revoke(sources);
  }
  ExpectRestored("attacked");
}

TEST_F(HostileSourcesTest, ATenthOfThePlayersOnThreeNetworksHardlyChangesPriorsUntilRevoked) {
  PlayWithOneToken(/*with_tickets=*/false, /*sessions=*/10);
  ExpectHardlyMoved("attacked");
  for (int client = kHonest; client < kHonest + kHostile; ++client) {
    for (int network = 0; network < 3; ++network) {
      v1::SourceFilter sources;
      sources.set_network(AtNetwork(client, network).network);
      Revoke(sources);
    }
  }
  ExpectRestored("attacked");
}

TEST_F(HostileSourcesTest, OneClientWithThreeHundredSessionsOfTheSharedTokenGainsNothing) {
  for (int client = 0; client < 64; ++client) {
    TeachHonestly("honest", client, AtNetwork(client));
    TeachHonestly("attacked", client, AtNetwork(client));
  }
  for (int session = 0; session < 300; ++session) Lie("attacked", AtNetwork(200));
  ExpectHardlyMoved("attacked");
}

// The places that honest parties leave free must not go to one party.
TEST_F(HostileSourcesTest, OneClientGainsNothingInASceneWithFewSourcesEither) {
  for (int client = 0; client < 15; ++client) {
    TeachHonestly("honest", client, AtNetwork(client));
    TeachHonestly("attacked", client, AtNetwork(client));
  }
  for (int session = 0; session < 16; ++session) Lie("attacked", AtNetwork(200));
  ExpectHardlyMoved("attacked");
}

// The policy `paper` begins with the sum over the same chosen sources.
TEST_F(HostileSourcesTest, InAPolicyWithSumsOneClientGainsNothingEither) {
  v1::Hello hello = Hello("attacked");
  hello.set_policy("paper");
  const auto commit = [&](const priors::SourceOrigin& origin, double alpha, double beta) {
    priors::SourceUpdate update;
    update.progress.source_id = "paper " + std::to_string(++source_count_);
    update.progress.commit_sequence = 1;
    update.unix_time_s = 100;
    update.origin = origin;
    update.increments.push_back(
        {EvidenceKeyOf(FromProto(hello).scene, hello.arms(0).name(),
                       hello.arms(0).backend_version(), {}),
         {.alpha = alpha, .beta = beta, .window_count = 50, .bail_out_count = 0}});
    std::promise<absl::Status> done;
    thread_.Commit(update, [&](const absl::Status& status) { done.set_value(status); });
    EXPECT_TRUE(done.get_future().get().ok());
  };
  for (int client = 0; client < 64; ++client) commit(AtNetwork(client), 40, 10);
  for (int session = 0; session < 300; ++session) commit(AtNetwork(200), 10, 40);
  const v1::Welcome welcome = TelemetryClient(channel_, "all-token").Open(hello);
  EXPECT_EQ(welcome.prior_source_count(), priors::kSourcesOfScene);
  const v1::BetaPosterior& prior = welcome.priors(0);
  // One of the sources is the hostile client's.
  EXPECT_NEAR(prior.alpha() / (prior.alpha() + prior.beta()), 0.8 - 0.6 / priors::kSourcesOfScene,
              0.001);
}

}  // namespace
}  // namespace sweepstake::rpc
