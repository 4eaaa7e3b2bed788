#include "tests/bench/paper_check/paper_game.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engine_client/decider/policy/paper_policy.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/random.h"
#include "tests/laboratory/policies/baselines.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::cli {
namespace {

constexpr int64_t kObservationNs = 900'000'000'000;
constexpr int64_t kWobbleNs = 1'000'000'000;
constexpr double kNoiseRatio = 0.01;
constexpr double kRestMs = 12;
constexpr uint32_t kObjectCount = 1'000;
constexpr uint64_t kPairCount = uint64_t{kObjectCount} * (kObjectCount - 1) / 2;

// A shipped policy without its diagnosis, which affects no decision and takes three quarters of a
// run's time.
template <typename Kind>
class Undiagnosed : public Kind {
 public:
  using Kind::Kind;
  decision::Diagnosis Diagnose() const override { return {}; }
};

template <typename Kind>
decision::PolicyEntry EntryOf(std::string_view name) {
  return {decision::PolicyKindOf(name, decision::ComparedPolicies()),
          [](const decision::PolicySetup& setup) -> std::unique_ptr<decision::Policy> {
            return std::make_unique<Undiagnosed<Kind>>(setup);
          }};
}

decision::PolicyRegistry Policies() {
  static const std::array kPolicies = {EntryOf<decision::ThompsonPolicy>("paper"),
                                       EntryOf<decision::RandomPolicy>("random")};
  return kPolicies;
}

decision::SessionSetup SetupOf(const PaperRules& rules, uint64_t seed) {
  decision::SessionSetup setup;
  setup.options.policy = rules.policy;
  setup.arms.assign(kPaperArms.begin(), kPaperArms.end());
  setup.seed = seed;
  setup.active_arm = static_cast<uint32_t>(seed % kPaperArms.size());
  return setup;
}

class Game {
 public:
  Game(const PaperRules& rules, const PaperCosts& costs, uint32_t fast_arm, uint64_t seed)
      : rules_(rules),
        costs_(costs),
        fast_arm_(fast_arm),
        seed_(seed),
        session_(SetupOf(rules, seed), Policies()),
        arm_(session_.active_arm()) {}

  PaperGame Play() {
    while (!end_ns_ || now_ns_ < *end_ns_) Step();
    const decision::ObservationSummary summary = session_.observation(*end_ns_);
    const auto longest = std::max_element(summary.active_ns.begin(), summary.active_ns.end());
    PaperGame game;
    game.dominant_arm = static_cast<uint32_t>(longest - summary.active_ns.begin());
    game.active_percent = 100 * static_cast<double>(*longest) / static_cast<double>(kObservationNs);
    game.switch_count =
        summary.switch_count(SwitchReason::kPolicy) + summary.switch_count(SwitchReason::kBailOut);
    const decision::BetaPosterior& posterior = session_.posteriors()[game.dominant_arm];
    game.posterior_mean = posterior.mean();
    game.evidence = posterior.evidence();
    return game;
  }

 private:
  void Step() {
    const FrameSample frame = NextFrame();
    now_ns_ += static_cast<int64_t>(frame.frame_time_ns);
    const bool settles = settled_ns_ < session_.setup().options.settling_ns;
    if (frame.flags == 0) settled_ns_ += static_cast<int64_t>(frame.frame_time_ns);
    samples_.push_back(frame);
    if (settles) Deliver();
    if (decision::IsOverBailOutLimit(frame, session_.setup().options.bail_out_ns))
      Execute(session_.ObserveBailOut(frame, now_ns_));
    if (now_ns_ < session_.next_tick_ns()) return;
    if (samples_.size() >= rules_.min_sample_count) Deliver();
    Execute(session_.Tick(now_ns_));
    const std::optional<int64_t> start_ns = session_.observation(now_ns_).start_ns;
    if (start_ns) end_ns_ = *start_ns + kObservationNs;
  }

  void Deliver() {
    session_.ObserveFrames(samples_);
    samples_.clear();
  }

  // Executes the decision's command. The session detects the switch by the epoch of the frames.
  void Execute(const decision::Decision& decision) {
    if (!decision.command) return;
    arm_ = decision.command->arm;
    ++epoch_;
    is_first_frame_ = true;
    settled_ns_ = 0;
    samples_.clear();
  }

  FrameSample NextFrame() {
    const double factor = 1 + kNoiseRatio * Wobble();
    const double detection_ms = costs_.detection_ms + (arm_ == fast_arm_ ? 0 : costs_.gap_ms);
    FrameSample frame{.aabb_check_count = kPairCount / 100,
                      .native_bytes = 4 << 20,
                      .object_count = kObjectCount};
    frame.frame_time_ns = static_cast<uint64_t>((kRestMs + detection_ms) * factor * 1e6);
    frame.detection_time_ns = static_cast<uint64_t>(detection_ms * factor * 1e6);
    frame.arm = arm_;
    frame.switch_epoch = epoch_;
    if (std::exchange(is_first_frame_, false)) frame.flags = kFrameRebuild;
    return frame;
  }

  // Returns a standard normal value, but at least −3. It is constant for each second and arm.
  double Wobble() {
    const int64_t second = now_ns_ / kWobbleNs;
    if (second != wobble_second_ || arm_ != wobble_arm_) {
      decision::RandomStream stream(~seed_, decision::RandomPurpose::kChoice,
                                    static_cast<uint64_t>(second), arm_);
      wobble_ = decision::DrawNormal(stream);
      wobble_second_ = second;
      wobble_arm_ = arm_;
    }
    return std::max(wobble_, -3.0);
  }

  const PaperRules& rules_;
  const PaperCosts& costs_;
  const uint32_t fast_arm_;
  const uint64_t seed_;
  decision::DecisionSession session_;
  std::vector<FrameSample> samples_;  // not passed to the session yet
  uint32_t arm_;
  int64_t now_ns_ = 0;
  std::optional<int64_t> end_ns_;
  uint32_t epoch_ = 0;
  bool is_first_frame_ = true;
  int64_t settled_ns_ = 0;  // time since the end of the epoch's first frame
  int64_t wobble_second_ = -1;
  uint32_t wobble_arm_ = 0;
  double wobble_ = 0;
};

}  // namespace

PaperGame PlayPaperGame(const PaperRules& rules, const PaperCosts& costs, uint32_t fast_arm,
                        uint64_t seed) {
  return Game(rules, costs, fast_arm, seed).Play();
}

}  // namespace sweepstake::cli
