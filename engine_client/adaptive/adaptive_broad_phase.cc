// The frame path, steps 2 to 6, in the order of BeginFrame, FindPairs, EndFrame.
//
// A backend that is not active keeps its buffers, so that a switch back to it need not allocate
// again; only the active one's bytes are reported, since those are what its arm costs.
#include "sweepstake/adaptive_broad_phase.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/adaptive/bail_out_guard.h"
#include "engine_client/adaptive/descriptor_estimator.h"
#include "engine_client/adaptive/switch_cost_meter.h"

namespace sweepstake {
namespace {

// The active arm and its epoch in one word: other threads read both at once.
constexpr uint64_t PackActive(uint32_t arm, uint32_t epoch) { return uint64_t{arm} << 32 | epoch; }

std::string Join(std::span<const std::string> names) {
  std::string joined;
  for (const std::string& name : names) joined += (joined.empty() ? "" : ", ") + name;
  return joined;
}

Status UnknownArm(std::string_view name, std::span<const std::string> arms) {
  return {StatusCode::kNotFound,
          "there is no arm '" + std::string(name) + "' here; the arms are " + Join(arms)};
}

std::optional<uint32_t> IndexOf(std::string_view name, std::span<const std::string> arms) {
  const auto found = std::find(arms.begin(), arms.end(), name);
  if (found == arms.end()) return std::nullopt;
  return static_cast<uint32_t>(found - arms.begin());
}

Status ValidateArms(std::span<const std::string> arms) {
  if (arms.empty() || arms.size() > BailOutGuard::kArmMax) {
    return {StatusCode::kInvalidArgument,
            "arms holds " + std::to_string(arms.size()) + " names; give 1 to 32"};
  }
  for (size_t i = 0; i < arms.size(); ++i) {
    if (IndexOf(arms[i], arms) != i) {
      return {StatusCode::kInvalidArgument, "arm '" + arms[i] + "' is named twice"};
    }
  }
  return {};
}

Status ValidateOptions(const AdaptiveOptions& options) {
  if (options.bail_out_ns == 0) {
    return {StatusCode::kInvalidArgument, "bail_out_ns is 0; give the longest frame in ns"};
  }
  if (options.mode != Mode::kManual && options.mode != Mode::kAi) {
    return {StatusCode::kInvalidArgument, "mode is neither kManual (1) nor kAi (2)"};
  }
  return {};
}

}  // namespace

class AdaptiveBroadPhase::Impl {
 public:
  Impl(const AdaptiveOptions& options, std::vector<std::string> arms,
       std::vector<std::unique_ptr<BroadPhase>> backends, uint32_t initial_arm, FrameSink* sink,
       Clock& clock);

  void BeginFrame();
  std::span<const OverlapPair> FindPairs(std::span<const Aabb> boxes);
  void EndFrame(const FrameEnd& frame);

  Status SelectArm(std::string_view name);

  uint32_t arm() const {
    return static_cast<uint32_t>(active_.load(std::memory_order_relaxed) >> 32);
  }
  uint32_t epoch() const { return static_cast<uint32_t>(active_.load(std::memory_order_relaxed)); }

  const std::vector<std::string> arms;
  std::vector<uint32_t> versions;
  SwitchMailbox mailbox;
  std::atomic<Mode> mode;
  BailOutGuard guard;
  SwitchCostMeter switch_cost;
  FrameSample last_sample{};
  SwitchReason last_switch_reason = SwitchReason::kPolicy;

 private:
  void Obey(const SwitchCommand& command);
  void Execute(const SwitchCommand& command);
  void Refuse(const SwitchCommand& command);
  void UpdateStructure(std::span<const Aabb> boxes, uint64_t start_ns);
  void Rebuild(std::span<const Aabb> boxes, uint64_t start_ns);
  void MeasureDetection(std::span<const Aabb> boxes, uint64_t start_ns);
  void Emit();
  void GuardLocally();
  void Report(const std::optional<SwitchOutcome>& outcome);

  const std::vector<std::unique_ptr<BroadPhase>> backends_;
  FrameSink* const sink_;
  Clock& clock_;
  std::atomic<uint64_t> active_;
  std::optional<SwitchCommand> local_command_;  // SelectArm or the guard, for the next frame
  bool built_ = false;  // the active structure holds the boxes of the latest frame
  PairBuffer pairs_;
  DescriptorEstimator descriptors_;
  FrameSample sample_{};
};

AdaptiveBroadPhase::Impl::Impl(const AdaptiveOptions& options, std::vector<std::string> arm_names,
                               std::vector<std::unique_ptr<BroadPhase>> backends,
                               uint32_t initial_arm, FrameSink* sink, Clock& clock)
    : arms(std::move(arm_names)),
      mode(options.mode),
      guard(options.bail_out_ns, static_cast<uint32_t>(backends.size())),
      switch_cost(options.settling_ns),
      backends_(std::move(backends)),
      sink_(sink),
      clock_(clock),
      active_(PackActive(initial_arm, 0)) {
  for (const auto& backend : backends_) versions.push_back(backend->version());
  sample_.arm = initial_arm;
}

// Step 2: a pending switch, at most one per frame. What was decided here wins over the mailbox.
void AdaptiveBroadPhase::Impl::BeginFrame() {
  const std::optional<SwitchCommand> commanded = mailbox.Take();
  const std::optional<SwitchCommand> local = std::exchange(local_command_, std::nullopt);
  if (local) Execute(*local);
  if (commanded && local) Refuse(*commanded);
  if (commanded && !local) Obey(*commanded);
  sample_.arm = arm();
  sample_.switch_epoch = epoch();
}

void AdaptiveBroadPhase::Impl::Obey(const SwitchCommand& command) {
  const bool allowed =
      mode.load(std::memory_order_relaxed) == Mode::kAi || command.reason == SwitchReason::kManual;
  if (allowed && command.arm < arms.size() && command.arm != arm()) {
    Execute(command);
  } else {
    Refuse(command);
  }
}

void AdaptiveBroadPhase::Impl::Execute(const SwitchCommand& command) {
  const uint32_t next_epoch = epoch() + 1;
  active_.store(PackActive(command.arm, next_epoch), std::memory_order_relaxed);
  last_switch_reason = command.reason;
  built_ = false;
  Report(switch_cost.Begin(command, next_epoch));
}

void AdaptiveBroadPhase::Impl::Refuse(const SwitchCommand& command) {
  Report(SwitchOutcome{.command_id = command.command_id,
                       .arm = arm(),
                       .switch_epoch = epoch(),
                       .reason = command.reason,
                       .executed = 0});
}

// Step 3, measured (step 4).
std::span<const OverlapPair> AdaptiveBroadPhase::Impl::FindPairs(std::span<const Aabb> boxes) {
  const uint64_t start_ns = clock_.NowNs();
  UpdateStructure(boxes, start_ns);
  pairs_.Clear();
  backends_[sample_.arm]->FindPairs(pairs_);
  built_ = true;
  MeasureDetection(boxes, start_ns);
  return std::as_const(pairs_).pairs();
}

// A backend that ran out of memory on the way is built anew in the next frame.
void AdaptiveBroadPhase::Impl::UpdateStructure(std::span<const Aabb> boxes, uint64_t start_ns) {
  if (std::exchange(built_, false)) {
    backends_[sample_.arm]->Update(boxes);
  } else {
    Rebuild(boxes, start_ns);
  }
}

void AdaptiveBroadPhase::Impl::Rebuild(std::span<const Aabb> boxes, uint64_t start_ns) {
  backends_[sample_.arm]->Build(boxes);
  sample_.flags |= kFrameRebuild;
  if (switch_cost.awaits_rebuild()) switch_cost.OnRebuild(clock_.NowNs() - start_ns);
}

void AdaptiveBroadPhase::Impl::MeasureDetection(std::span<const Aabb> boxes, uint64_t start_ns) {
  constexpr size_t kCountMax = std::numeric_limits<uint32_t>::max();
  const BroadPhase& backend = *backends_[sample_.arm];
  sample_.detection_time_ns += clock_.NowNs() - start_ns;
  sample_.aabb_check_count += backend.aabb_check_count();
  sample_.native_bytes = backend.native_bytes();
  sample_.pair_count = static_cast<uint32_t>(std::min(pairs_.size(), kCountMax));
  sample_.object_count = static_cast<uint32_t>(boxes.size());
  descriptors_.Observe(boxes);
}

// Steps 4 to 6: the whole frame's sample, its bail-out mark, and out to the sink.
void AdaptiveBroadPhase::Impl::EndFrame(const FrameEnd& frame) {
  sample_.frame_time_ns = frame.frame_time_ns;
  sample_.flags |= frame.flags & (kFramePaused | kFrameLoading);
  if (guard.Exceeds(frame.frame_time_ns)) sample_.flags |= kFrameBailOut;
  last_sample = sample_;
  Emit();
  GuardLocally();
  const uint64_t next_index = sample_.frame_index + 1;
  sample_ = FrameSample{};
  sample_.frame_index = next_index;
  sample_.arm = arm();
  sample_.switch_epoch = epoch();
}

void AdaptiveBroadPhase::Impl::Emit() {
  if (sink_ != nullptr) sink_->OnFrame(last_sample);
  Report(switch_cost.OnFrame(last_sample));
  if (!descriptors_.ready()) return;
  const SceneDescriptor descriptor = descriptors_.Take();
  if (sink_ != nullptr) sink_->OnDescriptor(descriptor);
}

void AdaptiveBroadPhase::Impl::GuardLocally() {
  if (mode.load(std::memory_order_relaxed) != Mode::kAi || local_command_) return;
  const std::optional<uint32_t> refuge = guard.LocalChoice(last_sample);
  if (refuge) local_command_ = SwitchCommand{.arm = *refuge, .reason = SwitchReason::kBailOut};
}

void AdaptiveBroadPhase::Impl::Report(const std::optional<SwitchOutcome>& outcome) {
  if (outcome && sink_ != nullptr) sink_->OnSwitch(*outcome);
}

Status AdaptiveBroadPhase::Impl::SelectArm(std::string_view name) {
  const std::optional<uint32_t> chosen = IndexOf(name, arms);
  if (!chosen) return UnknownArm(name, arms);
  local_command_.reset();
  if (*chosen != arm()) {
    local_command_ = SwitchCommand{.arm = *chosen, .reason = SwitchReason::kManual};
  }
  return {};
}

Result<std::unique_ptr<AdaptiveBroadPhase>> AdaptiveFactory::Make(
    const AdaptiveOptions& options, std::vector<std::unique_ptr<BroadPhase>> backends,
    FrameSink* sink, Clock& clock) {
  std::vector<std::string> arms;
  arms.reserve(backends.size());
  for (const auto& backend : backends) arms.emplace_back(backend->name());
  if (Status status = ValidateArms(arms); !status.ok()) return status;
  if (Status status = ValidateOptions(options); !status.ok()) return status;
  std::optional<uint32_t> initial = 0;
  if (!options.initial_arm.empty()) initial = IndexOf(options.initial_arm, arms);
  if (!initial) return UnknownArm(options.initial_arm, arms);
  auto impl = std::make_unique<AdaptiveBroadPhase::Impl>(
      options, std::move(arms), std::move(backends), *initial, sink, clock);
  return std::unique_ptr<AdaptiveBroadPhase>(new AdaptiveBroadPhase(std::move(impl)));
}

Result<std::unique_ptr<AdaptiveBroadPhase>> AdaptiveBroadPhase::Create(
    const AdaptiveOptions& options, FrameSink* sink, Clock& clock) {
  std::vector<std::string> arms = options.arms;
  if (arms.empty()) arms.assign(BroadPhaseNames().begin(), BroadPhaseNames().end());
  if (Status status = ValidateArms(arms); !status.ok()) return status;
  std::vector<std::unique_ptr<BroadPhase>> backends;
  for (const std::string& arm : arms) {
    Result<std::unique_ptr<BroadPhase>> backend =
        MakeBroadPhase(arm, {.executor = options.executor});
    if (!backend.ok()) return backend.status();
    backends.push_back(std::move(*backend));
  }
  return AdaptiveFactory::Make(options, std::move(backends), sink, clock);
}

AdaptiveBroadPhase::AdaptiveBroadPhase(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
AdaptiveBroadPhase::~AdaptiveBroadPhase() = default;

void AdaptiveBroadPhase::BeginFrame() { impl_->BeginFrame(); }
std::span<const OverlapPair> AdaptiveBroadPhase::FindPairs(std::span<const Aabb> boxes) {
  return impl_->FindPairs(boxes);
}
void AdaptiveBroadPhase::EndFrame(const FrameEnd& frame) { impl_->EndFrame(frame); }

Status AdaptiveBroadPhase::SelectArm(std::string_view arm) { return impl_->SelectArm(arm); }
void AdaptiveBroadPhase::SetMode(Mode mode) { impl_->mode.store(mode, std::memory_order_relaxed); }
void AdaptiveBroadPhase::SetDeciderPresent(bool present) {
  impl_->guard.SetDeciderPresent(present);
}
void AdaptiveBroadPhase::SetPosteriorMeans(std::span<const double> means) {
  impl_->guard.SetPosteriorMeans(means);
}
void AdaptiveBroadPhase::SetSettling(uint64_t settling_ns) {
  impl_->switch_cost.SetSettling(settling_ns);
}

void AdaptiveBroadPhase::SetBailOutLimit(uint64_t limit_ns) { impl_->guard.SetLimit(limit_ns); }

SwitchMailbox& AdaptiveBroadPhase::mailbox() { return impl_->mailbox; }
Mode AdaptiveBroadPhase::mode() const { return impl_->mode.load(std::memory_order_relaxed); }
uint32_t AdaptiveBroadPhase::active_arm() const { return impl_->arm(); }
uint32_t AdaptiveBroadPhase::switch_epoch() const { return impl_->epoch(); }
SwitchReason AdaptiveBroadPhase::last_switch_reason() const { return impl_->last_switch_reason; }
std::span<const std::string> AdaptiveBroadPhase::arms() const { return impl_->arms; }
std::span<const uint32_t> AdaptiveBroadPhase::arm_versions() const { return impl_->versions; }
const FrameSample& AdaptiveBroadPhase::last_sample() const { return impl_->last_sample; }

}  // namespace sweepstake
