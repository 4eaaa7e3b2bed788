// The shadow lane's thread (sweepstake/shadow.h): visits arms in sweeps, and prepares the arm of a
// commanded switch.
//
// A sweep: the frame thread copies up to kShadowBurstFrames consecutive frames, and only then
// (box_tap.h); each arm that is due (shadow_schedule.h) builds its structure on the first and
// updates it on the others, so that all arms of a sweep are compared on the same boxes. Sweeps are
// also spaced so that copying takes at most kCopyRatio of the frame time on average.
//
// A preparation goes before sweeps: the arm's structure is built on the next frame, kept up to date
// on the frames that follow until its buffers have grown and what a new structure costs more is
// past, and offered (switch_handover.h).
//
// Thread safety: Ask, Cancel, TakeOver and OnFrame on the frame thread; they never wait, lock,
// allocate, or call the system beyond the clock. stats() on any thread. Step is the thread's own
// and public for tests, which drive the lane by hand in place of Start. Ownership: sink, clock and
// mode are borrowed. The destructor waits for the backend's call under way. Errors: where memory
// runs out the lane frees its own and looks again a second later.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "engine_client/adaptive/arm_backend.h"
#include "engine_client/adaptive/box_tap.h"
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
    FrameSink* sink = nullptr;  // null: none
    Clock& clock;
    const std::atomic<Mode>& mode;
  };

  // What a switch that was asked for has come to.
  enum class Preparation { kNever, kUnderWay, kReady };

  static constexpr double kCopyRatio = 0.01;
  // Frames that a structure is kept up to date on before it is offered.
  static constexpr uint32_t kPreparationFrames = 1 + kShadowWarmUpFrames + 1;
  // A structure this many frames behind is brought up to date once more before it is offered.
  static constexpr uint64_t kRecentFrames = 4;

  explicit ShadowLane(Setup setup);
  ~ShadowLane();
  ShadowLane(const ShadowLane&) = delete;
  ShadowLane& operator=(const ShadowLane&) = delete;

  void Start();
  // Does what there is to do. Returns how long to wait before the next call.
  std::chrono::microseconds Step();

  // Begins to prepare `arm`, or says how far its preparation is. An earlier one of another arm is
  // given up.
  Preparation Ask(uint32_t arm);
  void Cancel();
  // Exchanges `own` for the backend prepared for `arm`: true, and `own` then holds boxes of a few
  // frames ago. False where none is ready. `pairs` gets the lane's room where that is larger; what
  // it held is then lost.
  bool TakeOver(uint32_t arm, ArmBackend& own, PairBuffer& pairs);
  void OnFrame(std::span<const Aabb> boxes, const FrameNote& note) noexcept {
    tap_.OnFrame(boxes, note, setup_.clock);
  }

  // All but the switches.
  ShadowStats stats() const;

 private:
  // Least frames of a burst: a visit then still measures one.
  static constexpr uint32_t kFramesMin = 1 + kShadowWarmUpFrames + 1;

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
    uint32_t frame_count = 0;  // the structure has seen
    uint64_t frame_index = 0;  // the latest of them
    bool caught_up = false;    // was brought up to date once more
  };

  void Run();
  bool enabled() const;
  bool sweep_is_due() const;
  bool interrupted() const;

  void RequestBurst();
  void OnBurst();
  bool MakeRoom(size_t object_count);
  void Sweep();
  std::optional<ShadowVisit> Visit(uint32_t arm);
  void Report(const ShadowVisit& visit);

  bool PrepareSwitch();
  void Prepare(const SwitchHandover::Order& order);
  bool AwaitFrame(const SwitchHandover::Order& order);
  bool RequestForPreparation();
  bool Follow(const SwitchHandover::Order& order);

  uint64_t Feed(BroadPhase& backend, bool build, std::span<const Aabb> boxes);
  ArmBackend& BackendOf(uint32_t arm);
  void AccountCopies();
  void TrimMemory(uint32_t arm);
  void FreeMemory();
  uint64_t structure_cap_bytes() const { return setup_.options.memory_cap_bytes / 2; }
  uint64_t structure_bytes() const;

  const Setup setup_;
  BoxTap tap_;
  SwitchHandover handover_;
  Counters counters_;
  std::atomic<ShadowState> state_{ShadowState::kRunning};

  // On the lane's thread.
  ShadowSchedule schedule_;
  std::vector<ArmBackend> backends_;
  PairBuffer pairs_;
  bool collecting_ = false;        // the tap's request is a burst for a sweep
  uint32_t accounted_frames_ = 0;  // of the tap's request
  uint64_t next_burst_frame_ = 0;
  uint64_t next_look_ns_ = 0;
  uint32_t next_slot_ = 0;  // of the preparation
  std::optional<Progress> progress_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<bool> stopping_{false};  // written under mutex_
  std::thread thread_;
};

}  // namespace sweepstake
