// A game without rendering. Each frame steps a scene and finds its pairs on the frame path. The run
// records its events for the report.
//
// The frame time is the measured time of the frame's work: step, detection and end of frame. If
// frames are paced, it also includes the wait for the next frame, as with vertical sync. If they
// are not paced, a faster arm completes more frames. Not thread-safe: the thread that calls Frame
// is the frame thread. The scene is borrowed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/scene.h"

namespace sweepstake::cli {

struct SwitchEvent {
  uint64_t frame_index = 0;  // the first frame on the new arm
  uint64_t time_ns = 0;      // since the run began
  uint32_t from = 0;
  uint32_t to = 0;
  uint32_t switch_epoch = 0;
  SwitchReason reason = SwitchReason::kPolicy;
};

// A change of the verdict that the decider publishes.
struct VerdictEvent {
  uint64_t frame_index = 0;  // the first frame with the new verdict
  uint64_t time_ns = 0;      // since the run began
  SceneVerdict verdict;
};

// Totals over the frames of one arm. The times of suspended frames (kFrameSuspended) are left out.
struct ArmActivity {
  uint64_t frame_count = 0;
  uint64_t active_ns = 0;     // sum of the frame times
  uint64_t detection_ns = 0;  // the part of active_ns spent in the broad phase
};

// The work of all frames of the run, divided into stages. Waiting between frames is left out.
struct FrameProfile {
  uint64_t step_ns = 0;       // moving the scene's objects
  uint64_t detection_ns = 0;  // update and search; frames that rebuilt are excluded
  uint64_t rebuild_ns = 0;    // update and search in frames that built the structure
  uint64_t around_ns = 0;     // rest before EndFrame: pending switch, box copies, descriptors
  uint64_t end_ns = 0;        // EndFrame: completing the sample, the sink, the bail-out guard
};

class GameRun final : private FrameSink {
 public:
  // `sink` receives the output of the frame path and is borrowed. A frame takes at least
  // `frame_interval_ns`; 0 means that frames are not paced. Returns the errors of
  // AdaptiveBroadPhase::Create.
  static Result<std::unique_ptr<GameRun>> Create(const AdaptiveOptions& options, Scene& scene,
                                                 FrameSink& sink, uint64_t frame_interval_ns = 0);

  // Runs one frame. Returns true if the frame's arm differs from the previous frame's; switches()
  // then has one more event.
  bool Frame();

  const Scene& scene() const { return scene_; }
  // Returns the pairs of the latest frame, valid until the next one.
  std::span<const OverlapPair> pairs() const { return pairs_; }
  AdaptiveBroadPhase& adaptive() { return *adaptive_; }
  const AdaptiveBroadPhase& adaptive() const { return *adaptive_; }
  uint64_t frame_count() const { return frame_count_; }
  // Returns the number of frames with kFrameSuspended.
  uint64_t suspended_frame_count() const { return suspended_frame_count_; }
  // Returns the time since the run began.
  uint64_t elapsed_ns() const;
  // Returns one entry per arm, in the order of the arms.
  const std::vector<ArmActivity>& activities() const { return activities_; }
  const std::vector<SwitchEvent>& switches() const { return switches_; }
  // Returns the changes of the verdict, beginning with the first verdict that is not kUnknown.
  const std::vector<VerdictEvent>& verdicts() const { return verdicts_; }
  const FrameProfile& profile() const { return profile_; }
  // Returns the outcomes of the switches, at most 65,536, in the order in which the switches
  // settled.
  const std::vector<SwitchOutcome>& outcomes() const { return outcomes_; }

 private:
  GameRun(Scene& scene, FrameSink& sink, uint64_t frame_interval_ns);

  void OnBoxes(std::span<const Aabb> boxes) noexcept override { sink_.OnBoxes(boxes); }
  void OnFrame(const FrameSample& sample) noexcept override { sink_.OnFrame(sample); }
  void OnDescriptor(const SceneDescriptor& descriptor) noexcept override {
    sink_.OnDescriptor(descriptor);
  }
  void OnSwitch(const SwitchOutcome& outcome) noexcept override;
  void OnModeChange(const ModeChange& change) noexcept override { sink_.OnModeChange(change); }
  void OnShadow(const ShadowSample& sample) noexcept override { sink_.OnShadow(sample); }
  // Waits until the next frame is due. Returns the time after the wait.
  uint64_t Pace(uint64_t now_ns);
  bool Note(const FrameSample& sample);
  void NoteVerdict(const FrameSample& sample);
  void Account(uint64_t step_ns, uint64_t path_ns, const FrameSample& sample);

  Scene& scene_;
  FrameSink& sink_;
  const uint64_t frame_interval_ns_;
  uint64_t next_frame_ns_ = 0;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
  std::span<const OverlapPair> pairs_;
  uint64_t start_ns_ = 0;
  uint64_t end_cost_ns_ = 0;  // time of the latest EndFrame, added to the next frame's time
  uint64_t frame_count_ = 0;
  uint64_t suspended_frame_count_ = 0;
  uint32_t arm_ = 0;
  FrameProfile profile_;
  std::vector<ArmActivity> activities_;
  std::vector<SwitchEvent> switches_;
  Verdict verdict_ = Verdict::kUnknown;
  std::vector<VerdictEvent> verdicts_;
  std::vector<SwitchOutcome> outcomes_;
};

// Returns the shadow lane's options for a decider whose intervals are divided by `time_scale`. The
// lane's intervals are divided too, so there are as many sweeps per decision as without scaling.
ShadowOptions ScaledShadow(ShadowMode mode, double time_scale);

// Returns "policy", "exploration", "bail-out" or "manual".
std::string ReasonName(SwitchReason reason);
// Returns "unknown", "stable", "tie", "ambiguous" or "degraded".
std::string VerdictName(Verdict verdict);

// Returns the outcome of the switch with this epoch, or all zeros if there is none. The switch back
// after a trial has two outcomes: one at once, and one after settling. The result combines both.
SwitchOutcome OutcomeOf(std::span<const SwitchOutcome> outcomes, uint32_t switch_epoch);

}  // namespace sweepstake::cli
