#include "engine_client/adaptive/switch_cost_meter.h"

#include "engine_client/broad_phase/host/float_environment.h"

namespace sweepstake {

std::optional<SwitchOutcome> SwitchCostMeter::Begin(const SwitchCommand& command,
                                                    uint32_t switch_epoch, bool warm) {
  std::optional<SwitchOutcome> unsettled;
  if (running_) unsettled = Finish();
  running_ = SwitchOutcome{.command_id = command.command_id,
                           .arm = command.arm,
                           .switch_epoch = switch_epoch,
                           .reason = command.reason,
                           .executed = 1};
  awaits_rebuild_ = !warm;
  early_ = late_ = Half{};
  return unsettled;
}

void SwitchCostMeter::OnRebuild(uint64_t rebuild_time_ns) {
  if (running_) running_->rebuild_time_ns = rebuild_time_ns;
  awaits_rebuild_ = false;
}

std::optional<SwitchOutcome> SwitchCostMeter::OnFrame(const FrameSample& sample) {
  constexpr uint32_t kSuspendedBuild = kFrameSuspended | kFrameRebuild;
  if (!running_) return std::nullopt;
  if ((sample.flags & kSuspendedBuild) == kSuspendedBuild) running_->rebuild_time_ns = 0;
  if ((sample.flags & kFrameWithoutCost) != 0) return std::nullopt;
  const uint64_t settling_ns = this->settling_ns();
  const uint64_t elapsed_ns = early_.time_ns + late_.time_ns;
  Half& half = elapsed_ns < settling_ns / 2 ? early_ : late_;
  half.time_ns += sample.frame_time_ns;
  ++half.frame_count;
  if (elapsed_ns + sample.frame_time_ns < settling_ns || late_.frame_count == 0) {
    return std::nullopt;
  }
  return Finish();
}

SwitchOutcome SwitchCostMeter::Finish() {
  SwitchOutcome outcome = *running_;
  outcome.settling_cost_ns = SettlingCostNs();
  running_.reset();
  awaits_rebuild_ = false;
  return outcome;
}

uint64_t SwitchCostMeter::SettlingCostNs() const {
  if (late_.frame_count == 0) return 0;
  const FloatEnvironmentScope environment;
  const double settled_mean_ns =
      static_cast<double>(late_.time_ns) / static_cast<double>(late_.frame_count);
  const double lost_ns = static_cast<double>(early_.time_ns) -
                         settled_mean_ns * static_cast<double>(early_.frame_count);
  return lost_ns > 0 ? static_cast<uint64_t>(lost_ns) : 0;
}

}  // namespace sweepstake
