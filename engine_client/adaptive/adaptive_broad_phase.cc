// The implementation of AdaptiveBroadPhase on the frame thread, in the order BeginFrame, FindPairs,
// EndFrame.
//
// Inactive backends keep their buffers, so switching back to them allocates nothing. A sample's
// native_bytes is the memory of the active backend alone, because it is part of the cost of the
// active arm.
#include "engine_client/adaptive/adaptive_impl.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "engine_client/broad_phase/host/core_speed.h"
#include "engine_client/broad_phase/host/exceptions.h"
#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/broad_phase/host/hook_points.h"

namespace sweepstake {
namespace {

// Maximum frame time for which a commanded switch waits for the shadow lane: 500 ms, or 30 frames
// at 60 frames/s. A preparation takes about 5 frames. If one frame of the active arm takes 500 ms
// or more, the switch waits for that frame only.
constexpr uint64_t kMaxPreparationNs = 500'000'000;

// Packs the active arm and its epoch into one word, so that other threads read both together.
constexpr uint64_t PackActive(uint32_t arm, uint32_t epoch) { return uint64_t{arm} << 32 | epoch; }

class ChronoSteadyClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override {
    const auto since_origin = std::chrono::steady_clock::now().time_since_epoch();
    return static_cast<uint64_t>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(since_origin).count());
  }
  uint64_t ThreadCpuNs() noexcept override { return sweepstake::ThreadCpuNs(); }
  uint64_t ProcessCpuNs() noexcept override { return sweepstake::ProcessCpuNs(); }
};

// Returns the state of the lane: kRunning if the options allow a lane, otherwise why there is none.
ShadowState LaneFor(const AdaptiveOptions& options, const LaneParts& lane, size_t arm_count) {
  if (!lane.make || options.shadow.enabled == ShadowMode::kOff) return ShadowState::kOff;
  if (arm_count < 2) return ShadowState::kOneArm;
  return ShadowState::kRunning;
}

// Passes a stop request to a backend for as long as this object lives.
class StopScope {
 public:
  StopScope(BroadPhase& backend, StopRequest& stop) : backend_(backend) { backend_.SetStop(&stop); }
  ~StopScope() { backend_.SetStop(nullptr); }
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  BroadPhase& backend_;
};

size_t EngineThreads(const AdaptiveOptions& options) {
  return options.executor == nullptr ? 1 : options.executor->thread_count();
}

// Gives the lane at most half of the memory budget. The other half is for the frame thread, so
// neither thread needs the other's memory use.
ShadowOptions LaneOptions(const AdaptiveOptions& options) {
  ShadowOptions shadow = options.shadow;
  if (options.memory_budget_bytes == 0) return shadow;
  shadow.memory_cap_bytes = std::min(shadow.memory_cap_bytes, options.memory_budget_bytes / 2);
  return shadow;
}

}  // namespace

Clock& SteadyClock() {
  static ChronoSteadyClock clock;  // It has no state, so all callers share it.
  return clock;
}

AdaptiveBroadPhase::Impl::Impl(const AdaptiveOptions& options, std::vector<std::string> arm_names,
                               std::vector<ArmBackend> backends, uint32_t first_arm,
                               const LaneParts& lane, FrameSink* sink, Clock& clock)
    : arms(std::move(arm_names)),
      initial_arm(first_arm),
      mode(options.mode),
      guard(options.bail_out_ns, static_cast<uint32_t>(backends.size())),
      switch_cost(options.settling_ns),
      backends_(std::move(backends)),
      make_(lane.make),
      max_pairs_(options.max_pairs),
      memory_budget_bytes_(options.memory_budget_bytes),
      sink_(sink),
      shared_sink_(sink == nullptr ? nullptr : sink->weak_from_this().lock()),
      clock_(clock),
      suspension_(clock, EngineThreads(options) > 1),
      active_(PackActive(initial_arm, 0)),
      trial_stop_(clock, EngineThreads(options) == 1 && ThreadTimeNs() > 0),
      lane_state_(LaneFor(options, lane, backends_.size())) {
  for (const ArmBackend& own : backends_) {
    own.Attach(true);
    versions.push_back(own.backend->version());
  }
  if (options.sorted_pairs) sorter_.emplace();
  sample_.arm = initial_arm;
  if (lane_state_ != ShadowState::kRunning) return;
  lane_ = MakeThreadOwned<ShadowLane>(
      ShadowLane::Setup{.options = LaneOptions(options),
                        .arm_count = static_cast<uint32_t>(backends_.size()),
                        .make = lane.make,
                        .sink = sink,
                        .clock = SteadyClock(),
                        .mode = mode,
                        .frozen = &frozen_,
                        .is_used = &lane_is_used_,
                        .thread_time_ns = ThreadTimeNs,
                        .core_speed = CoreSpeed,
                        .engine_threads = EngineThreads(options),
                        .usable_cores = lane.usable_cores});
}

Status AdaptiveBroadPhase::Impl::StartLane() {
  if (!lane_) return {};
  return CatchFailure(
      [&]() -> Status {
        lane_->Start();
        return {};
      },
      [](const char*) -> Status {
        return {StatusCode::kResourceExhausted,
                "the system cannot start a thread for the shadow lane: end other threads, or turn "
                "the lane off"};
      });
}

// Executes a pending switch, at most one per frame. A local command (SelectArm or a guard) has
// priority over a command from the mailbox.
void AdaptiveBroadPhase::Impl::BeginFrame() {
  const Zone zone(kZoneBeginFrame);
  KeepBudgetOfGrowing();
  const std::optional<SwitchCommand> commanded = mailbox.Take();
  std::optional<OperatorOrder> order = orders.Take();
  if (frozen()) order.reset();
  if (commanded || order || local_command_ || pending_) ExecuteOne(commanded, order);
  sample_.arm = arm();
  sample_.switch_epoch = epoch();
}

// Only frames with something to execute pay for the scope.
void AdaptiveBroadPhase::Impl::ExecuteOne(const std::optional<SwitchCommand>& commanded,
                                          const std::optional<OperatorOrder>& order) {
  const FloatEnvironmentScope environment;
  if (commanded) TakeCommand(*commanded);
  if (order) TakeOrder(*order);
  if (const auto local = std::exchange(local_command_, std::nullopt)) {
    Execute(*local);
    ReportTrialEnd();
    if (pending_) Refuse(pending_->command);
    Drop();
  } else if (pending_) {
    ExecutePending();
  }
  if (order) ReportMode(order->order_id);
}

// Executes an operator's order. manual_by_order_ is not set if the game itself chose kManual
// earlier. Otherwise a later bail-out would end the game's own choice (EndFrame).
void AdaptiveBroadPhase::Impl::TakeOrder(const OperatorOrder& order) {
  const bool is_own_manual =
      mode.load(std::memory_order_relaxed) == Mode::kManual && !manual_by_order_;
  ChangeMode(order.mode);
  manual_by_order_ = order.mode == Mode::kManual && !is_own_manual;
  if (!order.arm) return;
  DropLocalCommand();
  if (*order.arm != arm()) {
    local_command_ = SwitchCommand{.arm = *order.arm, .reason = SwitchReason::kManual};
  }
}

// Stores a command, which replaces the pending one. If both name the same arm, the lane's
// preparation of that arm continues.
void AdaptiveBroadPhase::Impl::TakeCommand(const SwitchCommand& command) {
  const bool same_arm = pending_ && pending_->command.arm == command.arm;
  pending_ = PendingSwitch{command, same_arm ? pending_->waited_ns : 0};
}

void AdaptiveBroadPhase::Impl::ExecutePending() {
  const SwitchCommand command = pending_->command;
  if (!IsAllowed(command)) {
    Refuse(command);
  } else if (WaitsForLane()) {
    return;
  } else {
    Execute(command);
  }
  Drop();
}

bool AdaptiveBroadPhase::Impl::IsAllowed(const SwitchCommand& command) const {
  const bool may_choose =
      mode.load(std::memory_order_relaxed) == Mode::kAi || command.reason == SwitchReason::kManual;
  return may_choose && !frozen() && command.arm < arms.size() && command.arm != arm();
}

// Returns whether the pending switch must wait for the lane to prepare the arm. A switch because of
// a bail-out, or after a frame over the bail-out limit, does not wait.
bool AdaptiveBroadPhase::Impl::WaitsForLane() {
  const bool bails_out = pending_->command.reason == SwitchReason::kBailOut ||
                         (last_sample.flags & kFrameBailOut) != 0;
  return lane_ != nullptr && !bails_out && pending_->waited_ns < kMaxPreparationNs &&
         lane_->Ask(pending_->command.arm) == ShadowLane::Preparation::kUnderWay;
}

void AdaptiveBroadPhase::Impl::Execute(const SwitchCommand& command) {
  const uint32_t next_epoch = epoch() + 1;
  const uint32_t arm_before = arm();
  const bool goes_on = keeps_structure_ && trial_end_;
  keeps_structure_ = built_;
  active_.store(PackActive(command.arm, next_epoch), std::memory_order_relaxed);
  last_switch_reason = command.reason;
  built_ = goes_on || (!frozen() && lane_ != nullptr &&
                       lane_->TakeOver(command.arm, backends_[command.arm], pairs_));
  (built_ ? warm_switch_count_ : cold_switch_count_).fetch_add(1, std::memory_order_relaxed);
  trial_.Begin(arm_before, command, 2 * switch_cost.settling_ns(), built_);
  KeepBudget();
  Report(switch_cost.Begin(command, next_epoch, /*warm=*/built_));
}

void AdaptiveBroadPhase::Impl::KeepBudget() {
  budgeted_bytes_ = backends_[arm()].backend->native_bytes();
  if (memory_budget_bytes_ == 0 || memory_bytes() <= memory_budget_bytes_) return;
  FreeInactiveArms();
  if (lane_ != nullptr && memory_bytes() > memory_budget_bytes_) lane_->Trim();
}

// Checks the memory budget if the active arm grew in the last frame. That frame allocated memory,
// so further allocations by FreeInactiveArms do little harm. After a frame without growth nothing
// is checked or allocated.
void AdaptiveBroadPhase::Impl::KeepBudgetOfGrowing() {
  if (memory_budget_bytes_ != 0 && last_sample.native_bytes > budgeted_bytes_) KeepBudget();
}

void AdaptiveBroadPhase::Impl::Trim() {
  FreeInactiveArms();
  pairs_ = PairBuffer();
  if (sorter_) sorter_.emplace();
  if (lane_ != nullptr) lane_->Trim();
}

// Replaces the inactive backends by new ones, because a backend frees its buffers only when it is
// destroyed.
void AdaptiveBroadPhase::Impl::FreeInactiveArms() {
  if (!make_) return;
  keeps_structure_ = false;
  for (uint32_t index = 0; index < backends_.size(); ++index) {
    if (index == arm() || backends_[index].backend->native_bytes() == 0) continue;
    backends_[index] = make_(index);
    backends_[index].Attach(true);
  }
}

uint64_t AdaptiveBroadPhase::Impl::memory_bytes() const {
  uint64_t bytes = pairs_.capacity_bytes() + shadow_stats().memory_bytes;
  if (sorter_) bytes += sorter_->native_bytes();
  for (const ArmBackend& own : backends_) bytes += own.backend->native_bytes();
  return bytes;
}

void AdaptiveBroadPhase::Impl::Drop() {
  pending_.reset();
  if (lane_ != nullptr) lane_->Cancel();
}

void AdaptiveBroadPhase::Impl::Refuse(const SwitchCommand& command) {
  Report(SwitchOutcome{.command_id = command.command_id,
                       .arm = arm(),
                       .switch_epoch = epoch(),
                       .reason = command.reason,
                       .executed = 0});
}

// Updates the structure of the active arm, searches for pairs, and measures both. The lane's cost
// is not learnt from a search during which the game was suspended, or which exceeded max_pairs.
std::span<const OverlapPair> AdaptiveBroadPhase::Impl::FindPairs(std::span<const Aabb> boxes) {
  ShadowLane* const lane = frozen() ? nullptr : lane_.get();
  const uint32_t work = lane == nullptr ? 0 : lane->cost().Begin();
  const bool is_steady = built_;
  const uint64_t start_ns = frozen() ? 0 : suspension_.BeginSearch();
  const bool is_stopped = !Detect(boxes, start_ns);
  if (is_stopped) LeaveTrial(boxes);
  const uint64_t detection_ns = MeasureDetection(boxes, start_ns);
  const bool is_suspended = suspension_.EndSearch(start_ns, detection_ns);
  const bool is_cost = !is_suspended && !is_stopped && !pairs_exceeded_;
  if (lane != nullptr && is_steady && is_cost) lane->cost().End(work, detection_ns, epoch());
  // Sorting is not measured. The lane's visits do not sort, and costs must be comparable between
  // games with and without sorting.
  if (sorter_) sorter_->Sort(pairs_.pairs());
  if (!std::exchange(searched_, true)) ShowFrame(boxes);
  return std::as_const(pairs_).pairs();
}

std::span<const OverlapPair> AdaptiveBroadPhase::Impl::FindPairs(ProxySet& proxies) {
  const auto found = FindPairs(proxies.moving_boxes());
  if (pairs_exceeded_) {
    proxies.SkipResolve();
    return {};
  }
  const auto pairs = proxies.Resolve(found, max_pairs_);
  pairs_exceeded_ = proxies.pairs_exceeded();
  if (pairs_exceeded_) sample_.flags |= kFramePairsExceeded;
  return pairs;
}

// Updates the structure of the active arm and searches for pairs. In a trial both are stopped after
// the time that the guard allows. Returns false if they were: pairs_ is then incomplete, and the
// structure must be built again.
bool AdaptiveBroadPhase::Impl::Detect(std::span<const Aabb> boxes, uint64_t start_ns) {
  const std::optional<uint64_t> limit_ns = trial_.limit_ns();
  if (!limit_ns) {
    UpdateStructure(boxes, start_ns);
    Search();
    return true;
  }
  trial_stop_.Begin(start_ns, *limit_ns - std::min(ComputedNs(), *limit_ns));
  const StopScope stop(*backends_[sample_.arm].backend, trial_stop_);
  UpdateStructure(boxes, start_ns);
  if (!trial_stop_.WantsStop(0, 0)) Search();
  return !trial_stop_.has_stopped();
}

// Ends a trial whose search was stopped. The previous arm becomes active at once and answers the
// frame, so the frame is the first one of its new switch epoch.
void AdaptiveBroadPhase::Impl::LeaveTrial(std::span<const Aabb> boxes) {
  const uint64_t searched_ns = trial_stop_.ComputedNs(NowNs());
  trial_end_ = trial_.Stop(ComputedNs() + searched_ns);
  local_command_ = SwitchCommand{.arm = trial_end_->arm_before};
  built_ = false;
  left_trial_ = true;
  ExecuteOne(std::nullopt, std::nullopt);
  sample_.arm = arm();
  sample_.switch_epoch = epoch();
  UpdateStructure(boxes, NowNs());
  Search();
}

// Returns the time of this frame's finished searches of a trial, without waits for the core.
uint64_t AdaptiveBroadPhase::Impl::ComputedNs() const {
  return sample_.detection_time_ns - std::min(waited_ns_, sample_.detection_time_ns);
}

void AdaptiveBroadPhase::Impl::Search() {
  const Zone zone(kZoneSearch);
  pairs_.Clear();
  BroadPhase& backend = *backends_[sample_.arm].backend;
  backend.Search(pairs_);
  pairs_exceeded_ = backend.pairs_exceeded();
  built_ = !pairs_exceeded_;
}

// Passes the boxes of a frame's first search to consumers that use one set of boxes per frame. So
// between two sets, objects make the motion of one frame, even if frames have several searches.
void AdaptiveBroadPhase::Impl::ShowFrame(std::span<const Aabb> boxes) {
  descriptors_.Observe(boxes);
  (sample_.flags & kFrameRebuild) != 0 ? invalid_boxes_.CountAll(boxes)
                                       : invalid_boxes_.Follow(boxes);
  sample_.invalid_box_count = invalid_boxes_.count();
  view_tap.OnFrame(boxes, sample_.frame_index);
  if (sink_ != nullptr) sink_->OnBoxes(boxes);
  if (lane_ == nullptr || frozen()) return;
  lane_->OnFrame(boxes, {.frame_index = sample_.frame_index,
                         .frame_time_ns = last_sample.frame_time_ns,
                         .arm = sample_.arm});
}

// Updates the structure, or builds it if it is not built. If a backend runs out of memory or
// exceeds max_pairs, built_ stays false and the next search builds again.
void AdaptiveBroadPhase::Impl::UpdateStructure(std::span<const Aabb> boxes, uint64_t start_ns) {
  const Zone zone(kZoneUpdate);
  if (std::exchange(built_, false)) {
    backends_[sample_.arm].backend->Advance(boxes);
  } else {
    Rebuild(boxes, start_ns);
  }
}

void AdaptiveBroadPhase::Impl::Rebuild(std::span<const Aabb> boxes, uint64_t start_ns) {
  backends_[sample_.arm].backend->Start(boxes);
  sample_.flags |= kFrameRebuild;
  if (switch_cost.awaits_rebuild()) switch_cost.OnRebuild(NowNs() - start_ns);
}

// Adds the search to the frame's sample. Times and AABB checks are summed over the frame's
// searches. The other counts come from the latest search.
uint64_t AdaptiveBroadPhase::Impl::MeasureDetection(std::span<const Aabb> boxes,
                                                    uint64_t start_ns) {
  constexpr size_t kMaxCount = std::numeric_limits<uint32_t>::max();
  const BroadPhase& backend = *backends_[sample_.arm].backend;
  const uint64_t detection_ns = NowNs() - start_ns;
  if (trial_.limit_ns())
    waited_ns_ += detection_ns - trial_stop_.ComputedNs(start_ns + detection_ns);
  if (pairs_exceeded_) sample_.flags |= kFramePairsExceeded;
  sample_.detection_time_ns += detection_ns;
  sample_.aabb_check_count += backend.aabb_check_count();
  sample_.native_bytes = backend.native_bytes();
  sample_.pair_count = static_cast<uint32_t>(std::min(pairs_.size(), kMaxCount));
  sample_.object_count = static_cast<uint32_t>(boxes.size());
  return detection_ns;
}

// Completes the frame's sample and passes it to the sink. Sets kFrameSuspended if the game was
// suspended, otherwise kFrameBailOut if the frame is over the limit. Few frames compute with
// floating-point numbers here, and only these pay for a FloatEnvironmentScope.
void AdaptiveBroadPhase::Impl::EndFrame(const FrameEnd& frame) {
  sample_.frame_time_ns = frame.frame_time_ns;
  sample_.flags |= frame.flags & (kFramePaused | kFrameLoading);
  const bool is_suspended = !frozen() && suspension_.EndFrame(frame);
  if (is_suspended) {
    sample_.flags |= kFrameSuspended;
  } else if (guard.Exceeds(frame.frame_time_ns)) {
    sample_.flags |= kFrameBailOut;
  }
  last_sample = sample_;
  if (pending_ && !is_suspended) pending_->waited_ns += frame.frame_time_ns;
  // The mode changes before the frame is reported, so that the decider treats the frame as one in
  // kAi.
  if (manual_by_order_ && guard.IsCausedByArm(last_sample)) SetMode(Mode::kAi);
  Emit();
  EndTrial();
  GuardLocally();
  const uint64_t next_index = sample_.frame_index + 1;
  searched_ = false;
  sample_ = FrameSample{};
  sample_.frame_index = next_index;
  sample_.arm = arm();
  sample_.switch_epoch = epoch();
}

void AdaptiveBroadPhase::Impl::Emit() {
  if (sink_ != nullptr) sink_->OnFrame(last_sample);
  Report(switch_cost.OnFrame(last_sample));
  if (!descriptors_.ready()) return;
  const FloatEnvironmentScope environment;
  const SceneDescriptor descriptor = descriptors_.Take();
  if (sink_ != nullptr) sink_->OnDescriptor(descriptor);
}

void AdaptiveBroadPhase::Impl::EndTrial() {
  const uint64_t waited_ns = std::exchange(waited_ns_, 0);
  if (std::exchange(left_trial_, false)) return;
  const std::optional<TrialGuard::End> end = trial_.OnFrame(last_sample, waited_ns);
  if (!end || local_command_) return;
  trial_end_ = end;
  local_command_ = SwitchCommand{.arm = end->arm_before};
}

// Reports the end of a trial at once, not after the settling time, so that the decider gets the
// report before it chooses again.
void AdaptiveBroadPhase::Impl::ReportTrialEnd() {
  const auto end = std::exchange(trial_end_, std::nullopt);
  if (!end) return;
  Report(SwitchOutcome{.arm = arm(),
                       .switch_epoch = epoch(),
                       .executed = 1,
                       .trial_detection_time_ns = end->detection_time_ns,
                       .trial_arm = end->tried_arm});
}

void AdaptiveBroadPhase::Impl::GuardLocally() {
  if ((last_sample.flags & kFrameBailOut) == 0) return;
  if (mode.load(std::memory_order_relaxed) != Mode::kAi || local_command_) return;
  const std::optional<uint32_t> fallback = guard.LocalChoice(last_sample);
  if (fallback) local_command_ = SwitchCommand{.arm = *fallback, .reason = SwitchReason::kBailOut};
}

void AdaptiveBroadPhase::Impl::Report(const std::optional<SwitchOutcome>& outcome) {
  if (!outcome) return;
  last_outcome.Set(*outcome);
  if (sink_ != nullptr) sink_->OnSwitch(*outcome);
}

void AdaptiveBroadPhase::Impl::ReportMode(uint64_t order_id) {
  if (sink_ == nullptr) return;
  sink_->OnModeChange({.mode = mode, .active_arm = arm(), .order_id = order_id});
}

void AdaptiveBroadPhase::Impl::SetMode(Mode chosen) {
  ChangeMode(chosen);
  ReportMode(/*order_id=*/0);
}

void AdaptiveBroadPhase::Impl::ChangeMode(Mode chosen) {
  mode.store(chosen, std::memory_order_relaxed);
  if (chosen == Mode::kManual) CancelTrial();
  manual_by_order_ = false;
  frozen_.store(false, std::memory_order_relaxed);
}

void AdaptiveBroadPhase::Impl::Freeze() {
  SetMode(Mode::kManual);
  frozen_.store(true, std::memory_order_relaxed);
  if (lane_ != nullptr) lane_->Trim();
  if (local_command_ && local_command_->reason == SwitchReason::kBailOut) DropLocalCommand();
}

void AdaptiveBroadPhase::Impl::SetLaneUse(bool used) {
  lane_is_used_.store(used, std::memory_order_relaxed);
  if (!used && lane_ != nullptr && !lane_->enabled()) lane_->Trim();
}

void AdaptiveBroadPhase::Impl::CancelTrial() {
  trial_.Cancel();
  if (trial_end_) DropLocalCommand();
}

void AdaptiveBroadPhase::Impl::DropLocalCommand() {
  local_command_.reset();
  trial_end_.reset();
}

Status AdaptiveBroadPhase::Impl::SelectArm(std::string_view name) {
  const std::optional<uint32_t> chosen = IndexOfArm(name, arms);
  if (!chosen) return UnknownArm(name, arms);
  CancelTrial();
  DropLocalCommand();
  if (*chosen != arm()) {
    local_command_ = SwitchCommand{.arm = *chosen, .reason = SwitchReason::kManual};
  }
  return {};
}

ShadowStats AdaptiveBroadPhase::Impl::shadow_stats() const {
  ShadowStats stats;
  stats.state = lane_state_;
  if (lane_ != nullptr) stats = lane_->stats();
  stats.warm_switch_count = warm_switch_count_.load(std::memory_order_relaxed);
  stats.cold_switch_count = cold_switch_count_.load(std::memory_order_relaxed);
  return stats;
}

AdaptiveBroadPhase::AdaptiveBroadPhase(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
AdaptiveBroadPhase::~AdaptiveBroadPhase() {
  if (impl_->attachment != nullptr) impl_->attachment->End(/*deadline_ms=*/0);
}

void AdaptiveBroadPhase::BeginFrame() { impl_->BeginFrame(); }
std::span<const OverlapPair> AdaptiveBroadPhase::FindPairs(std::span<const Aabb> boxes) {
  const FloatEnvironmentScope environment;
  return impl_->FindPairs(boxes);
}
std::span<const OverlapPair> AdaptiveBroadPhase::FindPairs(ProxySet& proxies) {
  const FloatEnvironmentScope environment;
  return impl_->FindPairs(proxies);
}
bool AdaptiveBroadPhase::pairs_exceeded() const { return impl_->pairs_exceeded(); }
uint64_t AdaptiveBroadPhase::max_pairs() const { return impl_->max_pairs(); }
void AdaptiveBroadPhase::EndFrame(const FrameEnd& frame) { impl_->EndFrame(frame); }
void AdaptiveBroadPhase::Trim() { impl_->Trim(); }
uint64_t AdaptiveBroadPhase::memory_bytes() const { return impl_->memory_bytes(); }

Status AdaptiveBroadPhase::SelectArm(std::string_view arm) { return impl_->SelectArm(arm); }
void AdaptiveBroadPhase::SetMode(Mode mode) {
  const FloatEnvironmentScope environment;
  impl_->SetMode(mode);
}
void AdaptiveBroadPhase::Freeze() {
  const FloatEnvironmentScope environment;
  impl_->Freeze();
}
bool AdaptiveBroadPhase::Obey(const OperatorOrder& order) {
  if (impl_->frozen()) return false;
  impl_->orders.Post(order);
  return true;
}
void AdaptiveBroadPhase::SetDeciderPresent(bool present) {
  impl_->guard.SetDeciderPresent(present);
}
void AdaptiveBroadPhase::SetPosteriorMeans(std::span<const double> means) {
  const FloatEnvironmentScope environment;
  impl_->guard.SetPosteriorMeans(means);
}
void AdaptiveBroadPhase::SetSettling(uint64_t settling_ns) {
  impl_->switch_cost.SetSettling(settling_ns);
}
void AdaptiveBroadPhase::SetLaneUse(bool used) { impl_->SetLaneUse(used); }
void AdaptiveBroadPhase::SetBailOutLimit(uint64_t limit_ns) { impl_->guard.SetLimit(limit_ns); }

void AdaptiveBroadPhase::SetVerdict(const SceneVerdict& verdict) { impl_->verdict.Set(verdict); }
SceneVerdict AdaptiveBroadPhase::verdict() const { return impl_->verdict.Get(); }
void AdaptiveBroadPhase::SetLastDecision(const LastDecision& decision) {
  impl_->last_decision.Set(decision);
}
std::optional<LastDecision> AdaptiveBroadPhase::last_decision() const {
  return impl_->last_decision.Get();
}
std::optional<SwitchOutcome> AdaptiveBroadPhase::last_outcome() const {
  return impl_->last_outcome.Get();
}

bool AdaptiveBroadPhase::Attach(std::shared_ptr<SessionAttachment> attachment) {
  if (impl_->attachment != nullptr && impl_->attachment->active()) return false;
  impl_->attachment = std::move(attachment);
  return true;
}

SwitchMailbox& AdaptiveBroadPhase::mailbox() { return impl_->mailbox; }
ViewTap& AdaptiveBroadPhase::view_tap() { return impl_->view_tap; }
Mode AdaptiveBroadPhase::mode() const { return impl_->mode.load(std::memory_order_relaxed); }
uint32_t AdaptiveBroadPhase::initial_arm() const { return impl_->initial_arm; }
uint32_t AdaptiveBroadPhase::active_arm() const { return impl_->arm(); }
uint32_t AdaptiveBroadPhase::switch_epoch() const { return impl_->epoch(); }
SwitchReason AdaptiveBroadPhase::last_switch_reason() const { return impl_->last_switch_reason; }
std::span<const std::string> AdaptiveBroadPhase::arms() const { return impl_->arms; }
std::span<const uint32_t> AdaptiveBroadPhase::arm_versions() const { return impl_->versions; }
const FrameSample& AdaptiveBroadPhase::last_sample() const { return impl_->last_sample; }
ShadowStats AdaptiveBroadPhase::shadow_stats() const {
  const FloatEnvironmentScope environment;
  return impl_->shadow_stats();
}

}  // namespace sweepstake
