// The shadow lane's thread (sweepstake/shadow.h). It visits arms in sweeps, and prepares the arm of
// a commanded switch.
//
// For a sweep the frame thread copies up to kShadowBurstFrames consecutive frames, a burst
// (box_tap.h). Each arm that is due (shadow_schedule.h) builds its structure on the first frame and
// updates it on the others. So all arms of a sweep are compared on the same boxes.
//
// The first visit after a pause is slower: by a factor of 1.2 to 1.4 on 2 cores of AMD Zen 3 with
// 3,000 objects. The lane therefore runs the first kShadowWarmUpNs of a sweep's first visit twice,
// and counts only the second run.
//
// The frame thread runs on one of the fastest cores. If the lane's thread ran on a slower kind of
// core, its times are converted to times of the fastest kind, by the speeds that the system reports
// (core_speed.h).
//
// Sweeps are spaced such that copying takes at most kCopyRatio of the frame time on average, and
// such that their work costs the frame thread little (lane_cost.h). If no core is free
// (UsableCores, checked every second), the lane rests.
//
// A preparation has priority over sweeps. The lane builds the arm's structure on the next frame and
// updates it on the following ones. When the buffers have grown and the extra cost of a new
// structure is over, the frame thread may take the structure (switch_handover.h).
//
// Thread safety:
// - Ask, Cancel, TakeOver, Trim and OnFrame are called on the frame thread. They never wait, lock,
//   allocate, or make a system call other than the clock.
// - stats() may be called on any thread.
// - Step runs on the lane's thread. It is public for tests, which call it instead of Start.
//
// Ownership: sink, clock, mode and frozen are borrowed. The destructor, Ask, Cancel and the caps of
// time and memory interrupt the lane's backend, even during a search (StopRequest states how soon).
// If memory runs out, the lane frees its own memory and tries again a second later.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/adaptive/box_tap.h"
#include "engine_client/adaptive/guards/suspension_guard.h"
#include "engine_client/adaptive/lane_cost.h"
#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/adaptive/switch_handover.h"
#include "engine_client/broad_phase/host/polling_thread.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/shadow.h"

namespace sweepstake {

class ShadowLane {
 public:
  struct Setup {
    ShadowOptions options;
    uint32_t arm_count = 0;
    ArmBackendFactory make;
    FrameSink* sink = nullptr;  // may be null
    Clock& clock;
    const std::atomic<Mode>& mode;
    const std::atomic<bool>* frozen = nullptr;  // the lane rests while it is true; null: never
    // A lane with ShadowMode::kAuto rests while it is false; null: never.
    const std::atomic<bool>* is_used = nullptr;
    // Returns the CPU time of the lane's thread, which measures the visits. It excludes time in
    // which another thread had the core. Null, or the result 0: the clock is used, and its coarse
    // CPU time shows whether the game was suspended.
    uint64_t (*thread_time_ns)() noexcept = nullptr;
    // Returns (speed of the core that the lane's thread is on) ÷ (speed of the fastest core). Null:
    // all cores are equal.
    double (*core_speed)() noexcept = nullptr;
    // The lane rests while engine_threads >= usable_cores(). Null: the lane assumes that a core is
    // free.
    size_t engine_threads = 1;
    size_t (*usable_cores)() noexcept = nullptr;
  };

  // The state of the preparation that Ask requests.
  enum class Preparation { kNever, kUnderWay, kReady };

  static constexpr double kCopyRatio = 0.01;
  // Number of frames that a structure must process before the frame thread may take it.
  static constexpr uint32_t kPreparationFrames = 1 + kShadowWarmUpFrames + 1;
  // If a prepared structure is more than this many frames behind the latest frame, it is updated
  // once more before the frame thread may take it.
  static constexpr uint64_t kRecentFrames = 4;

  explicit ShadowLane(Setup setup);
  ~ShadowLane();
  ShadowLane(const ShadowLane&) = delete;
  ShadowLane& operator=(const ShadowLane&) = delete;

  void Start();
  // Does the work that is due. Returns how long to wait before the next call.
  std::chrono::microseconds Step();

  // Begins to prepare `arm`, or returns the state of its preparation. Cancels a preparation of
  // another arm.
  Preparation Ask(uint32_t arm);
  void Cancel() { handover_.Cancel(); }
  // Swaps `own` with the backend prepared for `arm`, whose boxes are a few frames old. Returns
  // false if none is ready. If the lane's pair buffer is larger than `pairs`, the two buffers are
  // swapped, and `pairs` loses its content.
  bool TakeOver(uint32_t arm, ArmBackend& own, PairBuffer& pairs);
  // Returns whether the options, the mode and the decider let the lane run now.
  bool enabled() const {
    if (setup_.frozen != nullptr && setup_.frozen->load(std::memory_order_relaxed)) return false;
    if (setup_.options.enabled == ShadowMode::kOn) return true;
    if (setup_.is_used != nullptr && !setup_.is_used->load(std::memory_order_relaxed)) return false;
    return was_ai_.load(std::memory_order_relaxed) ||
           setup_.mode.load(std::memory_order_relaxed) == Mode::kAi;
  }
  // Makes the lane free its structures and copied boxes as soon as no preparation is under way.
  void Trim() { trim_is_wanted_.store(true, std::memory_order_relaxed); }
  void OnFrame(std::span<const Aabb> boxes, const FrameNote& note) noexcept {
    tap_.OnFrame(boxes, note, setup_.clock);
  }

  // The frame thread reports its searches to this object.
  LaneCost& cost() { return cost_; }

  // Returns the statistics of the lane. The switch counts are 0 here; AdaptiveBroadPhase adds them.
  ShadowStats stats() const;

 private:
  // Minimum number of frames of a burst, so that each visit measures at least one frame after the
  // warm-up.
  static constexpr uint32_t kMinFrames = 1 + kShadowWarmUpFrames + 1;

  struct LaneCounters {
    std::atomic<uint64_t> sweep_count{0};
    std::atomic<uint64_t> visit_count{0};
    std::atomic<uint64_t> capped_visit_count{0};
    std::atomic<uint64_t> busy_time_ns{0};
    std::atomic<uint64_t> memory_bytes{0};
    std::atomic<uint64_t> copied_frame_count{0};
    std::atomic<uint64_t> copy_time_ns{0};
  };

  struct Progress {
    uint32_t ticket = 0;
    uint32_t frame_count = 0;  // frames that the structure has processed
    uint64_t frame_index = 0;  // index of the latest of these frames
    bool caught_up = false;    // the structure was updated once more because it was far behind
  };

  class Watch;
  class Work;

  // Does the work of Step. Throws std::bad_alloc, after which Step frees the lane's memory.
  std::chrono::microseconds StepWithMemory();
  bool HasCore();
  bool sweep_is_due() const;
  bool interrupted(const SwitchHandover::Order* followed) const;

  void RequestBurst();
  void OnBurst();
  bool MakeRoom(size_t object_count);
  void Sweep();
  std::optional<ShadowVisit> Visit(uint32_t arm, uint64_t cap_ns);
  void Report(const ShadowVisit& visit);

  bool PrepareSwitch();
  void Prepare(const SwitchHandover::Order& order);
  bool AwaitFrame(const SwitchHandover::Order& order);
  bool RequestForPreparation();
  bool Follow(const SwitchHandover::Order& order);

  uint64_t WorkNs() const;
  // Returns `time_ns`, the duration of work that began at the thread's CPU time `cpu_begin_ns`. If
  // the game was suspended during the work, returns the CPU time since then, which may be coarse.
  uint64_t WithoutSuspension(uint64_t time_ns, uint64_t cpu_begin_ns) const;
  // Converts a time to the time on the fastest core. If the thread changed cores during the frame,
  // uses the speed of its last core.
  uint64_t OnFastestCoreNs(uint64_t time_ns) const {
    if (setup_.core_speed == nullptr) return time_ns;
    return static_cast<uint64_t>(setup_.core_speed() * static_cast<double>(time_ns));
  }
  uint64_t Feed(BroadPhase& backend, bool build, std::span<const Aabb> boxes, Watch& watch);
  ArmBackend& BackendOf(uint32_t arm);
  void AccountCopies();
  // Returns the time cap of a visit. It is visit_cap_ns, or twice the frame time of the copied
  // frames if that is longer. So in a game with long frames, an arm that costs no more than the
  // active one can be measured completely.
  uint64_t VisitCapNs() const {
    return std::max(setup_.options.visit_cap_ns, 2 * tap_.frame_time_ns());
  }
  void TrimMemory(uint32_t arm);
  void FreeOthers(uint32_t arm);
  void CountMemory();
  void Release();
  void FreeMemory();
  uint64_t structure_cap_bytes() const { return setup_.options.memory_cap_bytes / 2; }
  uint64_t structure_bytes() const;
  uint64_t bytes_of(const BroadPhase& backend) const {
    return backend.native_bytes() + pairs_.capacity_bytes();
  }

  const Setup setup_;
  BoxTap tap_;
  SwitchHandover handover_;
  LaneCost cost_;
  LaneCounters counters_;
  std::atomic<ShadowState> state_{ShadowState::kRunning};

  // Used on the lane's thread only.
  ShadowSchedule schedule_;
  std::vector<ArmBackend> backends_;
  PairBuffer pairs_;
  bool collecting_ = false;        // the tap's current request is a burst for a sweep
  uint32_t accounted_frames_ = 0;  // copied frames that AccountCopies has counted
  uint64_t next_burst_frame_ = 0;
  uint64_t next_try_ns_ = 0;
  uint64_t next_core_count_ns_ = 0;
  uint32_t next_slot_ = 0;  // slot of the tap that the preparation reads next
  std::optional<Progress> progress_;

  std::atomic<bool> was_ai_{false};  // the mode was kAi at least once
  std::atomic<bool> trim_is_wanted_{false};
  std::atomic<bool> stopping_{false};  // ends a visit in progress
  // The last member: its destructor ends the thread, which uses the others.
  PollingThread thread_{"swp lane", ThreadPriority::kLow};
};

}  // namespace sweepstake
