#include "tests/bench/paper_check/paper_game.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "server/decision/math/random.h"
#include "server/decision/session/decision_session.h"

namespace sweepstake::cli {
namespace {

constexpr int64_t kObservationNs = 900'000'000'000;
constexpr int64_t kStallNs = 6'000'000'000;
constexpr int64_t kWobbleNs = 1'000'000'000;
constexpr uint32_t kObjectCount = 1'000;
constexpr uint64_t kPairCount = uint64_t{kObjectCount} * (kObjectCount - 1) / 2;

decision::SessionSetup SetupOf(uint64_t seed) {
  decision::SessionSetup setup;
  setup.options.policy = "paper";
  setup.arms.assign(kPaperArms.begin(), kPaperArms.end());
  setup.seed = seed;
  setup.active_arm = static_cast<uint32_t>(seed % kPaperArms.size());
  return setup;
}

class Game {
 public:
  Game(const PaperCellFit& fit, uint64_t seed)
      : fit_(fit), seed_(seed), session_(SetupOf(seed)), arm_(session_.active_arm()) {}

  PaperGame Play() {
    while (!end_ns_ || now_ns_ < *end_ns_) Step();
    const decision::ObservationSummary summary = session_.observation(*end_ns_);
    const auto longest = std::max_element(summary.active_ns.begin(), summary.active_ns.end());
    PaperGame game;
    game.dominant_arm = static_cast<uint32_t>(longest - summary.active_ns.begin());
    game.active_percent = 100 * static_cast<double>(*longest) / static_cast<double>(kObservationNs);
    game.switch_count = summary.switch_count(decision::SwitchReason::kPolicy) +
                        summary.switch_count(decision::SwitchReason::kBailOut);
    const decision::BetaPosterior& posterior = session_.posteriors()[game.dominant_arm];
    game.posterior_mean = posterior.mean();
    game.evidence = posterior.evidence();
    return game;
  }

 private:
  void Step() {
    const bool stalls = Stalls();
    const decision::Frame frame = stalls ? StallFrame() : NextFrame();
    now_ns_ += static_cast<int64_t>(frame.frame_time_ns);
    session_.ObserveFrames({&frame, 1});
    if (stalls) session_.ObserveBailOut(frame, now_ns_);
    if (now_ns_ < session_.next_tick_ns()) return;
    if (const auto command = session_.Tick(now_ns_).command) Execute(command->arm);
    const std::optional<int64_t> start_ns = session_.observation(now_ns_).start_ns;
    if (start_ns) end_ns_ = *start_ns + kObservationNs;
  }

  // The session sees it by the frames' epoch.
  void Execute(uint32_t arm) {
    arm_ = arm;
    ++epoch_;
    is_first_frame_ = true;
  }

  bool Stalls() const {
    const auto period_ns = static_cast<int64_t>(fit_.stall_period_s * 1e9);
    const double phase = static_cast<double>(now_ns_ % period_ns) / static_cast<double>(period_ns);
    return phase >= 1 - fit_.stall_ratio;
  }

  decision::Frame StallFrame() {
    decision::Frame frame = NextFrame();
    frame.frame_time_ns = kStallNs;
    return frame;
  }

  decision::Frame NextFrame() {
    const PaperArmFit& arm = fit_.arms[arm_];
    const double factor = 1 + arm.noise_ratio * Wobble();
    decision::Frame frame{.aabb_check_count = kPairCount / 100,
                          .native_bytes = 4 << 20,
                          .object_count = kObjectCount};
    frame.frame_time_ns = static_cast<uint64_t>(arm.frame_ms * factor * 1e6);
    frame.detection_time_ns = static_cast<uint64_t>(arm.detection_ms * factor * 1e6);
    frame.arm = arm_;
    frame.switch_epoch = epoch_;
    if (std::exchange(is_first_frame_, false)) frame.flags = decision::kFrameRebuild;
    return frame;
  }

  // Standard normal, one for each second and arm.
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

  const PaperCellFit& fit_;
  const uint64_t seed_;
  decision::DecisionSession session_;
  uint32_t arm_;
  int64_t now_ns_ = 0;
  std::optional<int64_t> end_ns_;
  uint32_t epoch_ = 0;
  bool is_first_frame_ = true;
  int64_t wobble_second_ = -1;
  uint32_t wobble_arm_ = 0;
  double wobble_ = 0;
};

}  // namespace

PaperGame PlayPaperGame(const PaperCellFit& fit, uint64_t seed) { return Game(fit, seed).Play(); }

}  // namespace sweepstake::cli
