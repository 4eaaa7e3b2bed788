#include "engine_client/cli/game/game_run.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "engine_client/decider/types.h"

namespace sweepstake::cli {
namespace {

constexpr size_t kMaxOutcomes = 65'536;

}  // namespace

ShadowOptions ScaledShadow(ShadowMode mode, double time_scale) {
  ShadowOptions options{.enabled = mode};
  options.sweep_interval_min_ns =
      static_cast<uint64_t>(static_cast<double>(options.sweep_interval_min_ns) / time_scale);
  return options;
}

std::string ReasonName(SwitchReason reason) {
  return decision::NameOf(decision::kSwitchReasonNames, reason);
}

std::string VerdictName(Verdict verdict) {
  return decision::NameOf(decision::kVerdictNames, verdict);
}

GameRun::GameRun(Scene& scene, FrameSink& sink, uint64_t frame_interval_ns)
    : scene_(scene), sink_(sink), frame_interval_ns_(frame_interval_ns) {
  // Reserve the memory now, because OnSwitch must not allocate on the frame thread.
  outcomes_.reserve(kMaxOutcomes);
}

Result<std::unique_ptr<GameRun>> GameRun::Create(const AdaptiveOptions& options, Scene& scene,
                                                 FrameSink& sink, uint64_t frame_interval_ns) {
  std::unique_ptr<GameRun> run(new GameRun(scene, sink, frame_interval_ns));
  auto adaptive = AdaptiveBroadPhase::Create(options, run.get());
  if (!adaptive.ok()) return adaptive.status();
  run->adaptive_ = std::move(*adaptive);
  run->arm_ = run->adaptive_->active_arm();
  run->activities_.resize(run->adaptive_->arms().size());
  run->start_ns_ = SteadyClock().NowNs();
  return run;
}

bool GameRun::Frame() {
  const uint64_t begin_ns = SteadyClock().NowNs();
  scene_.Step();
  const uint64_t stepped_ns = SteadyClock().NowNs();
  adaptive_->BeginFrame();
  pairs_ = adaptive_->FindPairs(scene_.aabbs());
  const uint64_t work_end_ns = SteadyClock().NowNs();
  const uint64_t frame_end_ns = Pace(work_end_ns);
  adaptive_->EndFrame({.frame_time_ns = frame_end_ns - begin_ns + end_cost_ns_});
  end_cost_ns_ = SteadyClock().NowNs() - frame_end_ns;
  Account(stepped_ns - begin_ns, work_end_ns - stepped_ns, adaptive_->last_sample());
  return Note(adaptive_->last_sample());
}

uint64_t GameRun::Pace(uint64_t now_ns) {
  if (frame_interval_ns_ == 0) return now_ns;
  // After a late frame, the next frames keep their full interval; they are not shortened to catch
  // up.
  next_frame_ns_ = std::max(next_frame_ns_ + frame_interval_ns_, now_ns);
  std::this_thread::sleep_for(std::chrono::nanoseconds(next_frame_ns_ - now_ns));
  return SteadyClock().NowNs();
}

SwitchOutcome OutcomeOf(std::span<const SwitchOutcome> outcomes, uint32_t switch_epoch) {
  SwitchOutcome found{};
  for (SwitchOutcome outcome : outcomes) {
    if (outcome.executed == 0 || outcome.switch_epoch != switch_epoch) continue;
    if (found.trial_detection_time_ns > 0) {
      outcome.trial_detection_time_ns = found.trial_detection_time_ns;
      outcome.trial_arm = found.trial_arm;
    }
    found = outcome;
  }
  return found;
}

void GameRun::Account(uint64_t step_ns, uint64_t path_ns, const FrameSample& sample) {
  profile_.step_ns += step_ns;
  const bool rebuilt = (sample.flags & kFrameRebuild) != 0;
  (rebuilt ? profile_.rebuild_ns : profile_.detection_ns) += sample.detection_time_ns;
  profile_.around_ns += path_ns - std::min(path_ns, sample.detection_time_ns);
  profile_.end_ns += end_cost_ns_;
}

uint64_t GameRun::elapsed_ns() const { return SteadyClock().NowNs() - start_ns_; }

bool GameRun::Note(const FrameSample& sample) {
  ++frame_count_;
  NoteVerdict(sample);
  ArmActivity& activity = activities_[sample.arm];
  ++activity.frame_count;
  if ((sample.flags & kFrameSuspended) != 0) {
    ++suspended_frame_count_;
  } else {
    activity.active_ns += sample.frame_time_ns;
    activity.detection_ns += sample.detection_time_ns;
  }
  if (sample.arm == arm_) return false;
  switches_.push_back({.frame_index = sample.frame_index,
                       .time_ns = elapsed_ns(),
                       .from = arm_,
                       .to = sample.arm,
                       .switch_epoch = sample.switch_epoch,
                       .reason = adaptive_->last_switch_reason()});
  arm_ = sample.arm;
  return true;
}

void GameRun::NoteVerdict(const FrameSample& sample) {
  const SceneVerdict verdict = adaptive_->verdict();
  if (verdict.verdict == verdict_) return;
  verdict_ = verdict.verdict;
  verdicts_.push_back(
      {.frame_index = sample.frame_index, .time_ns = elapsed_ns(), .verdict = verdict});
}

void GameRun::OnSwitch(const SwitchOutcome& outcome) noexcept {
  if (outcomes_.size() < kMaxOutcomes) outcomes_.push_back(outcome);
  sink_.OnSwitch(outcome);
}

}  // namespace sweepstake::cli
