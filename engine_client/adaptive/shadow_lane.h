// The shadow lane's thread (sweepstake/shadow.h): visits arms in sweeps, and prepares the arm of a
// commanded switch.
//
// For a sweep the frame thread copies up to kShadowBurstFrames consecutive frames (box_tap.h). Each
// arm that is due (shadow_schedule.h) builds its structure on the first frame and updates it on the
// others. All arms of a sweep are therefore compared on the same boxes.
//
// The first visit after a pause is slower: 1.2 to 1.4 times on 2 cores of AMD Zen 3 with 3,000
// objects. The first kShadowWarmUpNs of a sweep's first visit are therefore run once before,
// without counting.
//
// The frame thread runs on one of the fastest cores. Times measured on a slower kind of core are
// converted to those of the fastest kind, by the speeds that the system reports (core_speed.h).
//
// Sweeps are spaced so that copying takes at most kCopyRatio of the frame time on average, and so
// that their work costs the frame thread little (lane_cost.h). Without a core to spare
// (UsableCores, checked every second) the lane rests.
//
// A preparation has priority over sweeps. The lane builds the arm's structure on the next frame and
// updates it on the following ones. It offers the structure (switch_handover.h) when the buffers
// have grown and the extra cost of a new structure is over.
//
// Thread safety: Ask, Cancel, TakeOver, Trim and OnFrame on the frame thread; they never wait,
// lock, allocate, or make a system call other than the clock. stats() on any thread. Step belongs
// to the lane's thread and is public for tests, which call it instead of Start. Ownership: sink,
// clock, mode and frozen are borrowed. The destructor, Ask, Cancel and the caps of time and memory
// interrupt the lane's backend, even during a search; StopRequest states how soon. Errors: if
// memory runs out, the lane frees its own memory and tries again a second later.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/adaptive/box_tap.h"
#include "engine_client/adaptive/lane_cost.h"
#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/adaptive/switch_handover.h"
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
    const std::atomic<bool>* frozen = nullptr;  // while it is true the lane rests; null: never
    // Returns the CPU time of the lane's thread, by which visits are timed. It excludes time during
    // which the thread had to give up its core. Null: the clock is used.
    uint64_t (*thread_time_ns)() noexcept = nullptr;
    // Returns the speed of the lane thread's present core ÷ that of the fastest core; null: all
    // cores are equal.
    double (*core_speed)() noexcept = nullptr;
    // The lane rests while engine_threads >= usable_cores(); null: the lane never rests for lack
    // of a core.
    size_t engine_threads = 1;
    size_t (*usable_cores)() noexcept = nullptr;
  };

  // The state of a requested preparation.
  enum class Preparation { kNever, kUnderWay, kReady };

  static constexpr double kCopyRatio = 0.01;
  // The number of frames that a structure processes before it is offered.
  static constexpr uint32_t kPreparationFrames = 1 + kShadowWarmUpFrames + 1;
  // A structure that lags more frames than this is updated once more before it is offered.
  static constexpr uint64_t kRecentFrames = 4;

  explicit ShadowLane(Setup setup);
  ~ShadowLane();
  ShadowLane(const ShadowLane&) = delete;
  ShadowLane& operator=(const ShadowLane&) = delete;

  void Start();
  // Does the work that is due. Returns the time to wait before the next call.
  std::chrono::microseconds Step();

  // Begins to prepare `arm`, or returns the state of its preparation. Cancels the preparation of
  // any other arm.
  Preparation Ask(uint32_t arm);
  void Cancel() { handover_.Cancel(); }
  // Swaps `own` with the backend prepared for `arm`, whose boxes are a few frames old. Returns
  // false if none is ready. `pairs` is swapped with the lane's buffer if that one is larger, and
  // then loses its content.
  bool TakeOver(uint32_t arm, ArmBackend& own, PairBuffer& pairs);
  // Makes the lane free its structures and copies as soon as it prepares no switch.
  void Trim() { trim_is_wanted_.store(true, std::memory_order_relaxed); }
  void OnFrame(std::span<const Aabb> boxes, const FrameNote& note) noexcept {
    tap_.OnFrame(boxes, note, setup_.clock);
  }

  // The frame thread records the times of its searches here.
  LaneCost& cost() { return cost_; }

  // Returns the statistics without the switch counts.
  ShadowStats stats() const;

 private:
  // The minimum number of frames of a burst, so that a visit measures at least one frame.
  static constexpr uint32_t kMinFrames = 1 + kShadowWarmUpFrames + 1;

  struct Counters {
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
    uint32_t frame_count = 0;  // number of frames that the structure has processed
    uint64_t frame_index = 0;  // the latest frame that the structure has processed
    bool caught_up = false;    // whether the structure was updated once more before the offer
  };

  class Watch;
  class Work;

  void Run();
  // Does the work of Step. Throws std::bad_alloc; Step then frees the lane's memory.
  std::chrono::microseconds StepWithMemory();
  bool enabled() const {
    if (setup_.frozen != nullptr && setup_.frozen->load(std::memory_order_relaxed)) return false;
    return setup_.options.enabled == ShadowMode::kOn || was_ai_.load(std::memory_order_relaxed) ||
           setup_.mode.load(std::memory_order_relaxed) == Mode::kAi;
  }
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
  // Converts a time to that of the fastest core. If the thread changed cores during the frame, the
  // speed of the last core is used.
  uint64_t OnFastestCoreNs(uint64_t time_ns) const {
    if (setup_.core_speed == nullptr) return time_ns;
    return static_cast<uint64_t>(setup_.core_speed() * static_cast<double>(time_ns));
  }
  uint64_t Feed(BroadPhase& backend, bool build, std::span<const Aabb> boxes, Watch& watch);
  ArmBackend& BackendOf(uint32_t arm);
  void AccountCopies();
  // Returns the time cap of a visit: visit_cap_ns, or twice the sum of the previous frame times
  // noted with the copied frames, if that is longer. In a game with long frames, an arm that costs
  // no more than the active one is then measured completely.
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
  Counters counters_;
  std::atomic<ShadowState> state_{ShadowState::kRunning};

  // Accessed on the lane's thread only.
  ShadowSchedule schedule_;
  std::vector<ArmBackend> backends_;
  PairBuffer pairs_;
  bool collecting_ = false;        // whether the tap's request is a burst for a sweep
  uint32_t accounted_frames_ = 0;  // frames of the tap's request whose copies are accounted for
  uint64_t next_burst_frame_ = 0;
  uint64_t next_try_ns_ = 0;
  uint64_t next_core_count_ns_ = 0;
  uint32_t next_slot_ = 0;  // the tap's slot that the preparation reads next
  std::optional<Progress> progress_;

  std::atomic<bool> was_ai_{false};  // whether the mode was kAi at least once
  std::atomic<bool> trim_is_wanted_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<bool> stopping_{false};  // set while mutex_ is held
  std::thread thread_;
};

}  // namespace sweepstake
