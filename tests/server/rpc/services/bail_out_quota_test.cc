// Tests the limit of bail-outs per player, network or token that count as evidence, over any number
// of sessions.
#include <string>

#include "engine_client/decider/audit/rederive.h"
#include "tests/engine_client/decider/audit/stored_audit.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/rpc/services/prompt_daemon.h"

namespace sweepstake::rpc {
namespace {

constexpr uint64_t kOfASession = decision::BailOutBudget::kBurst;
constexpr uint64_t kAtOnce = 20;

class BailOutQuotaTest : public ::testing::Test {
 protected:
  // Begins sessions one after the other, each with the maximum number of bail-outs at once.
  void BailOutOfSessions(int count, const std::string& address, int64_t token_id,
                         const v1::Hello& hello = OneArmHello()) {
    for (int i = 0; i < count; ++i) {
      PromptStream stream(daemon_, address + ":1", CallerOf(token_id));
      stream.Send(Request(hello));
      for (uint64_t sequence = 1; sequence <= kOfASession; ++sequence)
        EXPECT_TRUE(stream.Send(BailOut(sequence, sequence)));
      stream.Send(Goodbye());
    }
  }
  static auth::Principal CallerOf(int64_t token_id) {
    auth::Principal caller;
    caller.token_id = token_id;
    return caller;
  }
  priors::Evidence Stored() {
    const auto scene = *daemon_.store.store.LoadScene({"game", "harbour", "", 1});
    return scene ? scene->arms.at(0).live : priors::Evidence{};
  }

  PromptDaemon daemon_;
};

TEST_F(BailOutQuotaTest, ANetworkWithManyShortSessionsHardlyChangesThePriors) {
  const priors::PriorRecord others = LearntInHours();
  ASSERT_TRUE(daemon_.store.store.Import({&others, 1}).status().ok());
  for (int host = 0; host < 100; ++host)
    BailOutOfSessions(1, "ipv4:192.0.2." + std::to_string(host), 7);
  const priors::Evidence stored = Stored();
  EXPECT_EQ(stored.bail_out_count, kAtOnce);
  EXPECT_GT(stored.alpha / (stored.alpha + stored.beta), 0.88);
  EXPECT_EQ(daemon_.counters.decision_count, 100 * kOfASession);
  EXPECT_EQ(daemon_.counters.surplus_bail_out_count, 100 * kOfASession - kAtOnce);
}

TEST_F(BailOutQuotaTest, ANetworkHasOneLimitForAllItsTokensAndOthersAreNotAffected) {
  for (int64_t token = 1; token <= 10; ++token) BailOutOfSessions(1, "ipv4:192.0.2.7", token);
  EXPECT_EQ(Stored().bail_out_count, kAtOnce);
  BailOutOfSessions(10, "ipv4:198.51.100.8", 0);
  EXPECT_EQ(Stored().bail_out_count, 2 * kAtOnce);
  BailOutOfSessions(1, "ipv4:203.0.113.9", 1);
  EXPECT_EQ(Stored().bail_out_count, 2 * kAtOnce + kOfASession);
}

TEST_F(BailOutQuotaTest, TheOwnMachineHasNoLimitBecauseOfProxies) {
  BailOutOfSessions(10, "ipv4:127.0.0.1", 0);
  EXPECT_EQ(Stored().bail_out_count, 10 * kOfASession);
  BailOutOfSessions(10, "ipv4:127.0.0.1", 7);
  EXPECT_EQ(Stored().bail_out_count, 10 * kOfASession + kAtOnce) << "the token has a limit";
}

TEST_F(BailOutQuotaTest, TheBudgetIsRefilledWithTime) {
  BailOutOfSessions(2, "ipv4:192.0.2.7", 7);
  EXPECT_EQ(Stored().bail_out_count, kAtOnce);
  daemon_.Advance(kSecondNs);
  BailOutOfSessions(2, "ipv4:192.0.2.7", 7);
  EXPECT_EQ(Stored().bail_out_count, kAtOnce + 2);
}

TEST_F(BailOutQuotaTest, ASingleGameStaysWithinTheLimitForAnyBailOutTime) {
  uint64_t count = 0;
  for (const int64_t bail_out_ns : {kSecondNs / 10, 5 * kSecondNs, 60 * kSecondNs}) {
    daemon_.options.decision.bail_out_ns = bail_out_ns;
    PromptStream stream(daemon_, "ipv4:192.0.2.7:1", CallerOf(7));
    stream.Send(Request(OneArmHello()));
    for (uint64_t sequence = 1; sequence <= 100; ++sequence) {
      if (sequence > kOfASession) daemon_.Advance(bail_out_ns);
      v1::StreamTelemetryRequest request = BailOut(sequence, sequence);
      request.mutable_bail_out()->set_frame_time_ns(61 * kSecondNs);
      request.mutable_bail_out()->set_detection_time_ns(60 * kSecondNs);
      ASSERT_TRUE(stream.Send(request));
    }
    stream.Send(Goodbye());
    EXPECT_EQ(Stored().bail_out_count, count += 100);
    daemon_.Advance(60 * kSecondNs);
  }
}

TEST_F(BailOutQuotaTest, BailOutsThatASessionDoesNotUseAreNotCounted) {
  PromptStream stream(daemon_, "ipv4:192.0.2.7:1", CallerOf(7));
  stream.Send(Request(OneArmHello()));
  for (uint64_t sequence = 1; sequence <= 10 * kOfASession; ++sequence)
    ASSERT_TRUE(stream.Send(BailOut(sequence, sequence)));
  stream.Send(Goodbye());
  EXPECT_EQ(Stored().bail_out_count, kOfASession);
  BailOutOfSessions(1, "ipv4:192.0.2.8", 7);
  EXPECT_EQ(Stored().bail_out_count, kAtOnce);
}

TEST_F(BailOutQuotaTest, BailOutsAboveTheLimitAreAnsweredAndLoggedAsNoEvidence) {
  BailOutOfSessions(2, "ipv4:192.0.2.7", 7);
  const uint64_t before = daemon_.counters.switch_command_count;
  BailOutOfSessions(2, "ipv4:192.0.2.7", 7, HelloMessage());
  EXPECT_GE(daemon_.counters.switch_command_count, before + 2);
  EXPECT_EQ(Stored().bail_out_count, kAtOnce);
  const decision::AuditReport report =
      decision::Rederive(*test_support::StoredAudit(daemon_.store.store));
  EXPECT_FALSE(report.difference) << report.difference->Text();
  EXPECT_EQ(report.decision_count, 4 * kOfASession);
}

}  // namespace
}  // namespace sweepstake::rpc
