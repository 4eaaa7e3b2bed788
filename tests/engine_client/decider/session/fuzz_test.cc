// Makes random sequences of calls with absurd values from seeds, and checks that the invariants
// hold for every policy.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/random.h"
#include "tests/engine_client/decider/scripted_client.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {
namespace {

std::string PolicyOfSeed(uint64_t seed) {
  const auto names = PolicyNames(StudyPolicies());
  return std::string(names[seed % names.size()]);
}

class Fuzzer {
 public:
  explicit Fuzzer(uint64_t seed)
      : random_(seed, RandomPurpose::kChoice, 0, 0),
        setup_(MakeSetup(seed)),
        session_(setup_, StudyPolicies()) {
    now_ns_ = last_event_ns_ = setup_.start_ns;
    active_arm_ = setup_.active_arm;
    epoch_ = setup_.switch_epoch;
  }

  void Run(int steps) {
    for (int i = 0; i < steps && !testing::Test::HasFatalFailure(); ++i) Step();
  }

 private:
  uint32_t Below(uint32_t bound) { return random_.NextBelow(bound); }
  bool OneIn(uint32_t n) { return Below(n) == 0; }
  uint32_t AnyArm() { return Below(static_cast<uint32_t>(setup_.arms.size())); }

  SessionSetup MakeSetup(uint64_t seed) {
    SessionSetup setup = PlainSetup(1 + Below(32));
    setup.seed = seed;
    setup.options.explore = OneIn(2);
    setup.options.cooldown_ns = static_cast<int64_t>(Below(60)) * kSecond;
    setup.options.settling_ns = static_cast<int64_t>(Below(4)) * kSecond;
    setup.options.exploration_warm_up_ns = static_cast<int64_t>(Below(3)) * kSecond;
    if (OneIn(3)) setup.priors = AnyPriors(setup.arms.size());
    setup.start_ns = OneIn(3) ? -1'000 * kSecond : static_cast<int64_t>(Below(1'000'000));
    setup.switch_epoch = OneIn(3) ? ~0u - 3 : Below(5);
    setup.active_arm = Below(static_cast<uint32_t>(setup.arms.size()));
    setup.mode = OneIn(6) ? Mode::kManual : Mode::kAi;
    setup.options.policy = PolicyOfSeed(seed);
    return setup;
  }

  std::vector<BetaPosterior> AnyPriors(size_t arm_count) {
    std::vector<BetaPosterior> priors(arm_count);
    for (BetaPosterior& prior : priors) prior = {AnyPseudoCount(), AnyPseudoCount()};
    return priors;
  }

  double AnyPseudoCount() {
    constexpr std::array<double, 5> kCounts = {1, 5e-324, 0.3, 40, kMaxPriorEvidence / 2};
    return kCounts[Below(kCounts.size())];
  }

  float AnyDescription() {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr std::array<float, 7> kValues = {0, 0.4F, 3'000, -1, 3e38F, kInfinity, kNan};
    return OneIn(3) ? -1 : kValues[Below(kValues.size())];
  }

  SceneDescriptor AnyDescriptor() {
    return {.object_count = AnyDescription(),
            .density_ratio = AnyDescription(),
            .size_spread = AnyDescription(),
            .speed_mean = AnyDescription(),
            .speed_spread = AnyDescription(),
            .clustering_ratio = AnyDescription(),
            .static_ratio = AnyDescription()};
  }

  uint64_t AnyNumber() {
    switch (Below(6)) {
      case 0:
        return 0;
      case 1:
        return std::numeric_limits<uint64_t>::max() - Below(3);
      case 2:
        return random_.NextBits();
      default:
        return Below(40'000'000);
    }
  }

  FrameSample AnyFrame() {
    FrameSample frame{
        .frame_time_ns = AnyNumber(),
        .detection_time_ns = AnyNumber(),
        .aabb_check_count = AnyNumber(),
        .native_bytes = AnyNumber(),
        .object_count = OneIn(4) ? Below(3) : static_cast<uint32_t>(random_.NextBits())};
    frame.arm = OneIn(10) ? static_cast<uint32_t>(random_.NextBits()) : session_.active_arm();
    frame.switch_epoch = OneIn(50) ? epoch_ + Below(6) - 3 : epoch_;  // reports may lag behind
    frame.flags = OneIn(3) ? Below(16) : 0;
    return frame;
  }

  void Step() {
    now_ns_ += Below(500) * kMillisecond;
    switch (Below(20)) {
      case 0:
        Check(session_.ObserveBailOut(AnyFrame(), now_ns_), true);
        break;
      case 1:
        Switch(AnyArm());
        break;
      case 2:
        if (OneIn(10)) session_.SetMode(OneIn(3) ? Mode::kManual : Mode::kAi, AnyArm(), now_ns_);
        break;
      case 3:
      case 4:
        if (pending_) Switch(*pending_);
        break;
      case 5:
        session_.ObserveDescriptor(AnyDescriptor());
        break;
      case 6:
      case 7:
        ObserveShadow(Below(4));
        break;
      default:
        ObserveSome(Below(5));
    }
    if (now_ns_ >= session_.next_tick_ns()) Check(session_.Tick(now_ns_), false);
  }

  void ObserveSome(uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
      const FrameSample frame = AnyFrame();
      session_.ObserveFrames({&frame, 1});
    }
  }

  void ObserveShadow(uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
      const ShadowSample sample{.first_frame_index = AnyNumber(),
                                .detection_time_ns = AnyNumber(),
                                .build_time_ns = AnyNumber(),
                                .arm = OneIn(10) ? 77 : AnyArm(),
                                .object_count = Below(5'000),
                                .frame_count = Below(6),
                                .flags = Below(4)};
      session_.ObserveShadow({&sample, 1});
    }
  }

  // Notes a switch if the active arm has changed since the previous event, at that event's time.
  void NoteSwitch() {
    if (session_.active_arm() != active_arm_) last_switch_ns_ = last_event_ns_;
    active_arm_ = session_.active_arm();
    last_event_ns_ = now_ns_;
  }

  void ChangeMode() {
    const Mode mode = OneIn(3) ? Mode::kManual : Mode::kAi;
    session_.SetMode(mode, AnyArm(), now_ns_);
    NoteSwitch();
  }

  void Switch(uint32_t arm) {
    SwitchCost cost = {.rebuild_time_ns = AnyNumber(), .settling_cost_ns = AnyNumber()};
    if (OneIn(3)) cost.ended_trial = {.arm = AnyArm(), .detection_time_ns = AnyNumber()};
    session_.ObserveSwitch(arm, ++epoch_, static_cast<SwitchReason>(Below(7)), now_ns_, cost);
    pending_.reset();
    NoteSwitch();
  }

  void Check(const Decision& decision, bool bail_out) {
    NoteSwitch();
    const DecisionRecord& record = decision.record;
    ASSERT_EQ(record.decision_id, ++decision_count_);
    ASSERT_EQ(record.posteriors.size(), setup_.arms.size());
    for (const BetaPosterior& posterior : record.posteriors) {
      ASSERT_TRUE(std::isfinite(posterior.alpha) && posterior.alpha > 0);
      ASSERT_TRUE(std::isfinite(posterior.beta) && posterior.beta > 0);
    }
    if (record.reward) {
      ASSERT_GE(*record.reward, 0);
      ASSERT_LE(*record.reward, 1);
    }
    for (const double draw : record.draws) ASSERT_TRUE(std::isfinite(draw));
    if (!record.draws.empty()) {
      ASSERT_EQ(record.draws.size(), setup_.arms.size());
      ASSERT_TRUE(record.candidate);
    }
    ASSERT_LT(record.candidate.value_or(0), setup_.arms.size());
    ASSERT_TRUE(record.propensity > 0 && record.propensity <= 1);
    if (record.gate) {
      const GateTerms& gate = *record.gate;
      ASSERT_TRUE(std::isfinite(gate.gain) && gate.gain >= 0);
      ASSERT_TRUE(std::isfinite(gate.loss) && gate.loss >= 0);
      ASSERT_TRUE(std::isfinite(gate.horizon_s + gate.cooldown_s + gate.cost_s));
    }
    if (session_.mode() == Mode::kManual) {
      ASSERT_FALSE(decision.increment || decision.command);
    }
    CheckDiagnosis(record.diagnosis);
    if (decision.command) CheckCommand(decision, bail_out);
    ASSERT_GT(session_.next_tick_ns(), bail_out ? std::numeric_limits<int64_t>::min() : now_ns_);
  }

  void CheckDiagnosis(const Diagnosis& diagnosis) {
    ASSERT_EQ(diagnosis.best_probability.empty(), diagnosis.verdict == Verdict::kUnknown);
    if (diagnosis.best_probability.empty()) return;
    ASSERT_EQ(diagnosis.best_probability.size(), setup_.arms.size());
    double sum = 0;
    for (const double p : diagnosis.best_probability) {
      ASSERT_TRUE(p >= 0 && p <= diagnosis.best_probability[diagnosis.leader]);
      sum += p;
    }
    ASSERT_NEAR(sum, 1, 1e-9);
    ASSERT_TRUE(diagnosis.expected_loss_ratio >= 0 && std::isfinite(diagnosis.expected_loss_ratio));
    ASSERT_TRUE(diagnosis.entropy >= 0 && std::isfinite(diagnosis.entropy));
  }

  void CheckCommand(const Decision& decision, bool bail_out) {
    ASSERT_EQ(decision.command->command_id, ++command_count_);
    ASSERT_LT(decision.command->arm, setup_.arms.size());
    ASSERT_NE(decision.command->arm, session_.active_arm());
    ASSERT_EQ(decision.command->reason == SwitchReason::kBailOut, bail_out);
    if (decision.command->reason == SwitchReason::kPolicy && last_switch_ns_ && !OwnCooldown()) {
      ASSERT_GE(now_ns_ - *last_switch_ns_, setup_.options.cooldown_ns);
    }
    pending_ = decision.command->arm;
  }

  // Returns whether the policy uses its own cooldown instead of the options' cooldown.
  bool OwnCooldown() const {
    PolicySetup setup{.options = setup_.options, .arms = setup_.arms, .priors = {}};
    setup.priors.resize(setup.arms.size());
    return MakePolicy(setup, StudyPolicies())->cooldown_ns().has_value();
  }

  RandomStream random_;
  SessionSetup setup_;
  DecisionSession session_;
  int64_t now_ns_;
  int64_t last_event_ns_ = 0;
  uint32_t active_arm_;
  uint32_t epoch_;
  uint64_t decision_count_ = 0;
  uint64_t command_count_ = 0;
  std::optional<int64_t> last_switch_ns_;
  std::optional<uint32_t> pending_;
};

TEST(Fuzz, InvariantsHoldUnderRandomCallSequences) {
  for (uint64_t seed = 1; seed <= 400 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", policy " + PolicyOfSeed(seed));
    Fuzzer(seed).Run(1'500);
  }
}

}  // namespace
}  // namespace sweepstake::decision
