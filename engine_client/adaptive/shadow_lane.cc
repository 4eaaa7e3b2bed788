#include "engine_client/adaptive/shadow_lane.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "engine_client/adaptive/one_writer_sum.h"
#include "engine_client/broad_phase/host/exceptions.h"

namespace sweepstake {
namespace {

using State = SwitchHandover::State;

// The intervals at which the lane's thread looks for copied frames and orders. Both are much
// shorter than a 16 ms frame.
constexpr std::chrono::microseconds kBusyPoll{1'000};
constexpr std::chrono::microseconds kIdlePoll{4'000};
// Maximum number of yields while a preparation waits for a frame. Together they last longer than a
// frame of a game with 5,000 frames/s.
constexpr int kMaxYields = 200;
constexpr uint64_t kRetryNs = 1'000'000'000;
constexpr std::chrono::seconds kCorePoll{1};

ShadowScheduleOptions ScheduleOf(const ShadowOptions& options) {
  return {.duty_ratio = options.duty_ratio,
          .visit_cap_ns = options.visit_cap_ns,
          .memory_cap_bytes = options.memory_cap_bytes / 2,
          .sweep_interval_min_ns = options.sweep_interval_min_ns};
}

}  // namespace

// Stops a call of a backend for one of three reasons: its result is not needed any more, its time
// is over, or its pairs exceed the memory cap or max_pairs.
class ShadowLane::Watch final : public StopRequest {
 public:
  enum class End { kNone, kInterrupted, kTime, kMemory };

  // Watches a call that prepares a switch for the order `followed`, or a call of a visit if
  // `followed` is null. The call may take `time_ns` from Begin on. `held_bytes` is the memory of
  // the backend and the pairs before the call.
  Watch(const ShadowLane& lane, const SwitchHandover::Order* followed, uint64_t time_ns,
        uint64_t held_bytes)
      : lane_(lane), followed_(followed), time_ns_(time_ns), held_bytes_(held_bytes) {}

  void Begin(uint64_t now_ns) { begin_ns_ = now_ns; }
  End end() const { return end_; }
  uint64_t held_bytes() const { return held_bytes_; }

  // Ends the call as if its pairs exceeded the memory cap.
  void EndByPairs() {
    if (end_ == End::kNone) end_ = End::kMemory;
  }
  // The game was suspended during the call, and only a coarse CPU time is known of it.
  void NoteSuspended() { was_suspended_ = true; }
  bool was_suspended() const { return was_suspended_; }

  bool WantsStop(uint64_t grown_bytes, uint64_t /*found_pairs*/) noexcept override {
    held_bytes_ += grown_bytes;
    if (end_ != End::kNone) return true;
    if (lane_.interrupted(followed_)) {
      end_ = End::kInterrupted;
    } else if (grown_bytes > 0 && held_bytes_ > lane_.structure_cap_bytes()) {
      end_ = End::kMemory;
    } else if (lane_.setup_.clock.NowNs() - begin_ns_ >= time_ns_) {
      end_ = End::kTime;
    }
    return end_ != End::kNone;
  }

 private:
  const ShadowLane& lane_;
  const SwitchHandover::Order* const followed_;
  const uint64_t time_ns_;
  uint64_t begin_ns_ = 0;
  uint64_t held_bytes_;
  End end_ = End::kNone;
  bool was_suspended_ = false;
};

// Measures a stretch of the lane's work (LaneCost) and charges its cost to the schedule. The
// stretch lasts as long as this object. If the game was suspended meanwhile, only the lane's CPU
// time counts.
class ShadowLane::Work {
 public:
  explicit Work(ShadowLane& lane)
      : lane_(lane),
        begin_ns_(lane.setup_.clock.NowNs()),
        cpu_begin_ns_(lane.setup_.clock.ThreadCpuNs()) {
    lane_.cost_.BeginWork();
  }
  ~Work() {
    const uint64_t now_ns = lane_.setup_.clock.NowNs();
    const uint64_t time_ns = lane_.WithoutSuspension(now_ns - begin_ns_, cpu_begin_ns_);
    lane_.schedule_.Charge(now_ns, lane_.cost_.EndWork(time_ns));
  }
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

 private:
  ShadowLane& lane_;
  const uint64_t begin_ns_;
  const uint64_t cpu_begin_ns_;
};

ShadowLane::ShadowLane(Setup setup)
    : setup_(std::move(setup)),
      schedule_(ScheduleOf(setup_.options), setup_.arm_count),
      backends_(setup_.arm_count) {
  HasCore();
}

ShadowLane::~ShadowLane() { stopping_.store(true, std::memory_order_relaxed); }

void ShadowLane::Start() {
  thread_.Start(std::chrono::microseconds(0),
                [this](bool stopping) { return stopping ? std::nullopt : std::optional(Step()); });
}

std::chrono::microseconds ShadowLane::Step() {
  return CatchOutOfMemory([&] { return StepWithMemory(); },
                          [&] {
                            FreeMemory();
                            return collecting_ ? kBusyPoll : kIdlePoll;
                          });
}

std::chrono::microseconds ShadowLane::StepWithMemory() {
  if (PrepareSwitch()) return kBusyPoll;
  if (trim_is_wanted_.exchange(false, std::memory_order_relaxed)) Release();
  if (!enabled()) return kIdlePoll;
  was_ai_.store(true, std::memory_order_relaxed);
  if (!HasCore()) return kCorePoll;
  if (!tap_.complete()) return kBusyPoll;
  if (std::exchange(collecting_, false)) OnBurst();
  if (!collecting_ && sweep_is_due()) RequestBurst();
  return collecting_ ? kBusyPoll : kIdlePoll;
}

// Returns whether a core is free for the lane. The number of cores is read once a second, but not
// while a burst of frames is being copied: the lane completes the burst first.
bool ShadowLane::HasCore() {
  const uint64_t now_ns = setup_.clock.NowNs();
  if (setup_.usable_cores != nullptr && !collecting_ && now_ns >= next_core_count_ns_) {
    next_core_count_ns_ = now_ns + std::chrono::nanoseconds(kCorePoll).count();
    if (setup_.engine_threads >= setup_.usable_cores()) {
      state_.store(ShadowState::kNoSpareCore, std::memory_order_relaxed);
    } else if (state_.load(std::memory_order_relaxed) == ShadowState::kNoSpareCore) {
      state_.store(ShadowState::kRunning, std::memory_order_relaxed);
    }
  }
  return state_.load(std::memory_order_relaxed) != ShadowState::kNoSpareCore;
}

bool ShadowLane::sweep_is_due() const {
  const uint64_t now_ns = setup_.clock.NowNs();
  return schedule_.IsDue(now_ns, cost_.search_ns()) && now_ns >= next_try_ns_ &&
         tap_.latest_frame_index() >= next_burst_frame_;
}

// Returns whether the current work must end early. `followed` is the order that the work is for, or
// null for a visit. The work ends if the lane is stopping, if the order changed, or if a visit
// would delay an ordered switch.
bool ShadowLane::interrupted(const SwitchHandover::Order* followed) const {
  if (stopping_.load(std::memory_order_relaxed)) return true;
  const SwitchHandover::Order present = handover_.order();
  return followed == nullptr ? present.state == State::kWanted : present != *followed;
}

// Requests a burst: the consecutive frames for a sweep. If no memory is reserved yet, the request
// only finds out the object count (BoxTap::too_big_count).
void ShadowLane::RequestBurst() {
  if (tap_.slot_count() == 0) tap_.Reserve(1, 0);
  accounted_frames_ = 0;
  tap_.Request(tap_.slot_count());
  collecting_ = true;
}

void ShadowLane::OnBurst() {
  AccountCopies();
  if (tap_.too_big_count() > 0) {
    if (MakeRoom(tap_.too_big_count())) RequestBurst();
    return;
  }
  if (tap_.filled_count() >= kMinFrames && !tap_.frame(0).boxes.empty()) Sweep();
}

// Reserves memory for slightly more than `object_count` objects, so that a slowly growing scene
// does not reallocate often. Returns false if fewer than kMinFrames frames fit into the cap.
bool ShadowLane::MakeRoom(size_t object_count) {
  const size_t capacity = object_count + object_count / 8 + 64;
  const uint64_t cap_bytes = setup_.options.memory_cap_bytes / 2;
  const uint64_t max_slots = cap_bytes / (capacity * sizeof(Aabb));
  const bool fits = max_slots >= kMinFrames;
  state_.store(fits ? ShadowState::kRunning : ShadowState::kTooBig, std::memory_order_relaxed);
  if (fits) {
    tap_.Reserve(static_cast<uint32_t>(std::min<uint64_t>(max_slots, BoxTap::kMaxSlots)), capacity);
    CountMemory();
  } else {
    FreeMemory();
  }
  return fits;
}

// Counts each copied frame once, and spaces the bursts such that copying takes the share kCopyRatio
// of the frame time. It uses the mean frame time, because engines report frame times near 0 after a
// pause.
void ShadowLane::AccountCopies() {
  constexpr uint64_t kMinFrameNs = 1000;
  const uint32_t filled = tap_.filled_count();
  const uint32_t fresh = filled - accounted_frames_;
  uint64_t copy_ns = 0;
  uint64_t frame_ns = 0;
  for (uint32_t slot = accounted_frames_; slot < filled; ++slot) {
    const TappedFrame frame = tap_.frame(slot);
    copy_ns += frame.copy_time_ns;
    frame_ns += frame.note.frame_time_ns;
  }
  AddAsOnlyWriter(counters_.copied_frame_count, fresh);
  AddAsOnlyWriter(counters_.copy_time_ns, copy_ns);
  accounted_frames_ = filled;
  const uint64_t mean_frame_ns = std::max(frame_ns / std::max(fresh, 1U), kMinFrameNs);
  const double spacing =
      static_cast<double>(copy_ns) / (kCopyRatio * static_cast<double>(mean_frame_ns));
  next_burst_frame_ =
      std::max(next_burst_frame_, tap_.latest_frame_index()) + static_cast<uint64_t>(spacing);
}

void ShadowLane::Sweep() {
  const TappedFrame first = tap_.frame(0);
  schedule_.Begin(setup_.clock.NowNs(), cost_.search_ns(), first.note.arm,
                  static_cast<uint32_t>(first.boxes.size()));
  const Work work(*this);
  bool is_warm = false;
  while (const std::optional<uint32_t> arm = schedule_.NextArm()) {
    const std::optional<ShadowVisit> visit = Visit(*arm, is_warm ? VisitCapNs() : kShadowWarmUpNs);
    if (!visit) return;
    if (!std::exchange(is_warm, true)) {
      schedule_.Spend(visit->busy_ns);
      continue;
    }
    schedule_.OnVisit(*visit);
    Report(*visit);
    TrimMemory(*arm);
  }
  AddAsOnlyWriter(counters_.sweep_count, 1);
}

// Visits the arm: runs its backend on the frames of the burst. Returns nullopt if the visit was
// interrupted. A frame that was stopped midway does not count. One exception: a first frame that
// ran for most of the time cap counts, because the cap is then a lower bound of its cost. If the
// time cap ended a frame that computed for less than half of its time, the arm is not slow: the
// lane was kept waiting for a core, or the game was suspended. The frames before it then count only
// if some of them come after the warm-up. The same holds for a suspended frame without a precise
// thread time.
std::optional<ShadowVisit> ShadowLane::Visit(uint32_t arm, uint64_t cap_ns) {
  const Zone zone(kZoneLaneVisit);
  BroadPhase& backend = *BackendOf(arm).backend;
  const uint32_t frame_count = tap_.filled_count();
  std::array<uint64_t, kShadowBurstFrames> frame_ns{};
  uint32_t ran = 0;
  uint64_t busy_ns = 0;
  uint64_t check_sum = 0;
  uint64_t native_bytes = 0;
  bool kept_waiting = false;
  while (ran < frame_count && busy_ns < cap_ns) {
    Watch watch(*this, nullptr, cap_ns - busy_ns, bytes_of(backend));
    const bool is_wanted = !interrupted(nullptr);
    const uint64_t time_ns = is_wanted ? Feed(backend, ran == 0, tap_.frame(ran).boxes, watch) : 0;
    busy_ns += time_ns;
    if (!is_wanted || watch.end() == Watch::End::kInterrupted) {
      schedule_.Spend(busy_ns);
      return std::nullopt;
    }
    native_bytes = backend.native_bytes();
    if (watch.end() == Watch::End::kMemory) native_bytes = watch.held_bytes();
    const bool is_late = watch.end() == Watch::End::kTime;
    kept_waiting =
        watch.was_suspended() || (is_late && time_ns < (cap_ns - (busy_ns - time_ns)) / 2);
    if (!kept_waiting && (watch.end() == Watch::End::kNone || (ran == 0 && is_late))) {
      if (ran > kShadowWarmUpFrames) check_sum += backend.aabb_check_count();
      frame_ns[ran++] = OnFastestCoreNs(time_ns);
    }
    if (kept_waiting || watch.end() != Watch::End::kNone) break;
    if (native_bytes > structure_cap_bytes()) break;
  }
  const bool is_measured = ran > (kept_waiting ? 1 + kShadowWarmUpFrames : 0);
  if (ran == 0) frame_ns[ran++] = cap_ns;
  ShadowVisit visit =
      SummarizeVisit(std::span(frame_ns).first(ran), std::numeric_limits<uint64_t>::max());
  visit.arm = arm;
  visit.is_measured = is_measured;
  visit.busy_ns = busy_ns;
  visit.native_bytes = native_bytes;
  visit.aabb_check_count = check_sum / std::max<uint32_t>(visit.frame_count, 1);
  visit.capped = !kept_waiting && ran < frame_count;
  return visit;
}

void ShadowLane::Report(const ShadowVisit& visit) {
  AddAsOnlyWriter(counters_.visit_count, 1);
  if (visit.capped) AddAsOnlyWriter(counters_.capped_visit_count, 1);
  if (setup_.sink == nullptr || !visit.is_measured) return;
  const TappedFrame first = tap_.frame(0);
  uint32_t flags = visit.arm == first.note.arm ? uint32_t{kShadowActive} : 0U;
  if (visit.capped) flags |= kShadowCapped;
  setup_.sink->OnShadow({.first_frame_index = first.note.frame_index,
                         .detection_time_ns = visit.detection_ns,
                         .build_time_ns = visit.build_ns,
                         .aabb_check_count = visit.aabb_check_count,
                         .native_bytes = visit.native_bytes,
                         .arm = visit.arm,
                         .object_count = static_cast<uint32_t>(first.boxes.size()),
                         .frame_count = visit.frame_count,
                         .flags = flags});
}

// Does one step of the preparation that the frame thread ordered. Returns false without an order.
bool ShadowLane::PrepareSwitch() {
  const SwitchHandover::Order order = handover_.order();
  if (order.state == State::kReady || order.state == State::kTaken) return true;
  if (order.state != State::kWanted) return false;
  Prepare(order);
  return true;
}

void ShadowLane::Prepare(const SwitchHandover::Order& order) {
  if (!progress_ || progress_->ticket != order.ticket) {
    progress_ = Progress{.ticket = order.ticket};
    // Use the frames of a burst that is still being copied. The frames of a complete burst are too
    // old.
    next_slot_ = std::exchange(collecting_, false) ? 0 : tap_.filled_count();
  }
  while (AwaitFrame(order)) {
    if (!Follow(order)) {
      TrimMemory(order.arm);
      handover_.Decline(order);
      return;
    }
    if (progress_->frame_count < kPreparationFrames || next_slot_ < tap_.filled_count()) continue;
    const uint64_t behind = tap_.latest_frame_index() - progress_->frame_index;
    if (behind > kRecentFrames && !std::exchange(progress_->caught_up, true)) continue;
    handover_.Offer(order);
    return;
  }
}

// Waits until the next slot has a frame, and returns true. Returns false if no frame arrives soon;
// the next Step then continues.
bool ShadowLane::AwaitFrame(const SwitchHandover::Order& order) {
  for (int yields = 0; yields < kMaxYields; ++yields) {
    if (stopping_.load(std::memory_order_relaxed) || handover_.order() != order) return false;
    if (next_slot_ < tap_.filled_count()) return true;
    if (!tap_.complete()) {
      std::this_thread::yield();
    } else if (!RequestForPreparation()) {
      handover_.Decline(order);
      return false;
    }
  }
  return false;
}

// Requests frames for a preparation. Returns false if the boxes do not fit into the memory cap.
bool ShadowLane::RequestForPreparation() {
  AccountCopies();
  if (tap_.too_big_count() > 0 && !MakeRoom(tap_.too_big_count())) return false;
  if (tap_.slot_count() == 0) tap_.Reserve(1, 0);
  const uint32_t seen = std::min(progress_->frame_count, kPreparationFrames - 1);
  accounted_frames_ = next_slot_ = 0;
  tap_.Request(std::min(kPreparationFrames - seen, tap_.slot_count()));
  return true;
}

// Runs the backend on the frame in the next slot. Returns false if the structure exceeds the memory
// cap, or if the order was cancelled.
bool ShadowLane::Follow(const SwitchHandover::Order& order) {
  const Zone zone(kZoneLanePreparation);
  const Work work(*this);
  BroadPhase& backend = *BackendOf(order.arm).backend;
  const TappedFrame frame = tap_.frame(next_slot_++);
  Watch watch(*this, &order, std::numeric_limits<uint64_t>::max(), bytes_of(backend));
  schedule_.Spend(Feed(backend, progress_->frame_count == 0, frame.boxes, watch));
  ++progress_->frame_count;
  progress_->frame_index = frame.note.frame_index;
  FreeOthers(order.arm);
  return watch.end() == Watch::End::kNone && backend.native_bytes() <= structure_cap_bytes();
}

uint64_t ShadowLane::WorkNs() const {
  const uint64_t work_ns = setup_.thread_time_ns == nullptr ? 0 : setup_.thread_time_ns();
  return work_ns > 0 ? work_ns : setup_.clock.NowNs();
}

uint64_t ShadowLane::WithoutSuspension(uint64_t time_ns, uint64_t cpu_begin_ns) const {
  if (cpu_begin_ns == 0) return time_ns;
  const uint64_t cpu_ns = setup_.clock.ThreadCpuNs() - cpu_begin_ns;
  return SuspensionGuard::IsSuspended(time_ns, cpu_ns) ? cpu_ns : time_ns;
}

// Builds or updates the structure and searches for pairs, so that all buffers grow to the size that
// the scene needs. Returns the time that this took, in ns.
uint64_t ShadowLane::Feed(BroadPhase& backend, bool build, std::span<const Aabb> boxes,
                          Watch& watch) {
  const uint64_t cpu_begin_ns = setup_.clock.ThreadCpuNs();
  watch.Begin(setup_.clock.NowNs());
  const uint64_t start_ns = WorkNs();
  backend.SetStop(&watch);
  if (build) {
    backend.Build(boxes);
  } else {
    backend.Update(boxes);
  }
  pairs_.Clear();
  if (watch.end() == Watch::End::kNone) backend.FindPairs(pairs_);
  backend.SetStop(nullptr);
  if (backend.pairs_exceeded()) watch.EndByPairs();
  const uint64_t work_ns = WorkNs() - start_ns;
  const uint64_t time_ns = WithoutSuspension(work_ns, cpu_begin_ns);
  if (time_ns < work_ns) watch.NoteSuspended();
  AddAsOnlyWriter(counters_.busy_time_ns, time_ns);
  CountMemory();
  return time_ns;
}

ArmBackend& ShadowLane::BackendOf(uint32_t arm) {
  ArmBackend& own = backends_[arm];
  if (own.backend == nullptr) own = setup_.make(arm);
  return own;
}

uint64_t ShadowLane::structure_bytes() const {
  return std::accumulate(backends_.begin(), backends_.end(), uint64_t{pairs_.capacity_bytes()},
                         [](uint64_t sum, const ArmBackend& own) {
                           return sum + (own.backend ? own.backend->native_bytes() : 0);
                         });
}

// If all structures together exceed the cap, frees the structure of the arm just visited.
void ShadowLane::TrimMemory(uint32_t arm) {
  if (structure_bytes() > structure_cap_bytes()) {
    backends_[arm] = {};
    pairs_ = PairBuffer();
  }
  CountMemory();
}

// If all structures together exceed the cap, keeps only the structure of `arm`, which is being
// prepared for a switch. The switch has priority. The freed structures are not needed later,
// because a visit builds a new one.
void ShadowLane::FreeOthers(uint32_t arm) {
  if (structure_bytes() <= structure_cap_bytes()) return;
  for (uint32_t index = 0; index < backends_.size(); ++index)
    if (index != arm) backends_[index] = {};
  CountMemory();
}

// Updates the number of bytes that the lane holds. Called on the lane's thread, and by TakeOver on
// the frame thread, while the lane does not use its backends.
void ShadowLane::CountMemory() {
  counters_.memory_bytes.store(structure_bytes() + tap_.memory_bytes(), std::memory_order_relaxed);
}

// Frees the lane's memory. Boxes that the frame thread is still copying are kept.
void ShadowLane::Release() {
  for (ArmBackend& own : backends_) own = {};
  pairs_ = PairBuffer();
  progress_.reset();
  if (tap_.complete()) {
    collecting_ = false;
    tap_.Reserve(0, 0);
  }
  CountMemory();
}

void ShadowLane::FreeMemory() {
  Release();
  next_try_ns_ = setup_.clock.NowNs() + kRetryNs;
}

ShadowLane::Preparation ShadowLane::Ask(uint32_t arm) {
  const ShadowState state = state_.load(std::memory_order_relaxed);
  if (!enabled() || state == ShadowState::kTooBig || state == ShadowState::kNoSpareCore) {
    return Preparation::kNever;
  }
  const SwitchHandover::Order order = handover_.order();
  if (order.arm == arm && order.state == State::kWanted) return Preparation::kUnderWay;
  if (order.arm == arm && order.state == State::kReady) return Preparation::kReady;
  if (order.arm == arm && order.state == State::kDeclined) return Preparation::kNever;
  handover_.Want(arm);
  return Preparation::kUnderWay;
}

bool ShadowLane::TakeOver(uint32_t arm, ArmBackend& own, PairBuffer& pairs) {
  if (handover_.order().arm != arm || !handover_.Take()) return false;
  std::swap(own, backends_[arm]);
  if (pairs_.capacity_bytes() > pairs.capacity_bytes()) std::swap(pairs, pairs_);
  own.Attach(true);
  backends_[arm].Attach(false);
  CountMemory();
  handover_.Done();
  return true;
}

ShadowStats ShadowLane::stats() const {
  const auto load = [](const auto& counter) { return counter.load(std::memory_order_relaxed); };
  return {.state = enabled() ? state_.load(std::memory_order_relaxed) : ShadowState::kPaused,
          .sweep_count = load(counters_.sweep_count),
          .visit_count = load(counters_.visit_count),
          .capped_visit_count = load(counters_.capped_visit_count),
          .busy_time_ns = load(counters_.busy_time_ns),
          .memory_bytes = load(counters_.memory_bytes),
          .copied_frame_count = load(counters_.copied_frame_count),
          .copy_time_ns = load(counters_.copy_time_ns),
          .slowdown_time_ns = cost_.total_ns()};
}

}  // namespace sweepstake
