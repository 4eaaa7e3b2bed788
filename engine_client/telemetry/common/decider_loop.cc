#include "engine_client/telemetry/common/decider_loop.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "engine_client/broad_phase/host/hook_points.h"

namespace sweepstake {
namespace {

// Maximum number of frames in one call of the decider. It limits the size of the buffer. TakeQueue
// takes more frames by calling the decider several times.
constexpr size_t kFrameRun = 256;

LastDecision Summary(const DecisionEvent& event) {
  LastDecision summary{.decision_id = event.decision_id,
                       .time_ns = event.time_ns,
                       .active_arm = event.active_arm,
                       .outcome = event.outcome,
                       .candidate_arm = event.candidate_arm,
                       .command = event.command,
                       .expected_loss_ratio = event.expected_loss_ratio,
                       .verdict = event.verdict,
                       .arm_count = event.best_probability.size()};
  std::copy(event.best_probability.begin(), event.best_probability.end(),
            summary.best_probability.begin());
  return summary;
}

}  // namespace

DeciderLoop::DeciderLoop(SampleQueue& queue, AdaptiveBroadPhase& adaptive,
                         std::unique_ptr<EmbeddedDecider> decider)
    : queue_(queue), adaptive_(adaptive), decider_(std::move(decider)) {
  frames_.reserve(kFrameRun);
  adaptive_.SetDeciderPresent(true);
  adaptive_.SetSettling(decider_->settling_ns());
  adaptive_.SetLaneUse(decider_->uses_shadow());
}

uint64_t DeciderLoop::TakeQueue(uint64_t now_ns) {
  const Zone zone(kZoneDecide);
  frame_count_ = 0;
  while (const std::optional<QueuedItem> item = queue_.Pop()) Take(*item, now_ns);
  FlushFrames(now_ns);
  while (const std::optional<ShadowSample> sample = queue_.PopShadow()) {
    decider_->Observe({&*sample, 1});
  }
  return frame_count_;
}

void DeciderLoop::Take(const QueuedItem& item, uint64_t now_ns) {
  if (const auto* frame = std::get_if<FrameSample>(&item)) {
    frames_.push_back(*frame);
    if (frames_.size() == kFrameRun) FlushFrames(now_ns);
    return;
  }
  FlushFrames(now_ns);
  if (const auto* outcome = std::get_if<SwitchOutcome>(&item)) decider_->Observe(*outcome, now_ns);
  if (const auto* descriptor = std::get_if<SceneDescriptor>(&item)) decider_->Observe(*descriptor);
  if (const auto* change = std::get_if<ModeChange>(&item)) {
    decider_->SetMode(change->mode, change->active_arm, now_ns);
  }
}

void DeciderLoop::FlushFrames(uint64_t now_ns) {
  if (frames_.empty()) return;
  decider_->Observe(frames_, now_ns);
  frame_count_ += frames_.size();
  frames_.clear();
}

std::optional<SwitchCommand> DeciderLoop::Decide(uint64_t now_ns) {
  const Zone zone(kZoneDecide);
  const std::optional<SwitchCommand> command = decider_->Poll(now_ns);
  if (command) adaptive_.mailbox().Post(*command);
  return command;
}

void DeciderLoop::PublishBeliefs() {
  published_decision_count_ = decider_->decision_count();
  SetPosteriorMeans(decider_->beliefs(), adaptive_);
  adaptive_.SetVerdict(decider_->verdict());
  if (decider_->last_decision()) adaptive_.SetLastDecision(Summary(*decider_->last_decision()));
}

void SetPosteriorMeans(const std::vector<ArmBelief>& beliefs, AdaptiveBroadPhase& adaptive) {
  std::vector<double> means;
  means.reserve(beliefs.size());
  for (const ArmBelief& belief : beliefs) {
    means.push_back(belief.alpha / (belief.alpha + belief.beta));
  }
  adaptive.SetPosteriorMeans(means);
}

}  // namespace sweepstake
