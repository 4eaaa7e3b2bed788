// A game without rendering: each frame steps a scene and finds its pairs on the frame path. The run
// records what happened for the report.
//
// The frame time is the measured time of the frame's work: step, detection and end of frame. If
// frames are paced, it includes the wait for the next frame, as with vertical sync. If they are
// not, a faster arm completes more frames. Not thread-safe: the thread that calls Frame is the
// frame thread. The scene is borrowed.
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

// A change of the decider's verdict.
struct VerdictEvent {
  uint64_t frame_index = 0;  // the first frame with the new verdict
  uint64_t time_ns = 0;      // since the run began
  SceneVerdict verdict;
};

// The frames of one arm.
struct ArmActivity {
  uint64_t frame_count = 0;
  uint64_t active_ns = 0;     // the time of its frames
  uint64_t detection_ns = 0;  // the broad phase's part of that
};

// The total time of all frames, by stage.
struct FrameProfile {
  uint64_t step_ns = 0;       // the scene's motion
  uint64_t detection_ns = 0;  // update and search; frames that rebuilt are excluded
  uint64_t rebuild_ns = 0;    // update and search in frames that built the structure
  uint64_t around_ns = 0;     // the rest up to EndFrame: pending switch, box copies, descriptors
  uint64_t end_ns = 0;        // EndFrame: completing the sample, the sink, the bail-out guard
};

class GameRun final : private FrameSink {
 public:
  // `sink` receives the output of the frame path and is borrowed. A frame takes at least
  // `frame_interval_ns`; with 0 frames are not paced. Has the errors of AdaptiveBroadPhase::Create.
  static Result<std::unique_ptr<GameRun>> Create(const AdaptiveOptions& options, Scene& scene,
                                                 FrameSink& sink, uint64_t frame_interval_ns = 0);

  // Runs one frame. Returns true if its arm differs from that of the previous frame; switches()
  // then has one more event.
  bool Frame();

  AdaptiveBroadPhase& adaptive() { return *adaptive_; }
  const AdaptiveBroadPhase& adaptive() const { return *adaptive_; }
  uint64_t frame_count() const { return frame_count_; }
  // Returns the time since the run began.
  uint64_t elapsed_ns() const;
  // Returns one entry per arm, in the order of the arms.
  const std::vector<ArmActivity>& activities() const { return activities_; }
  const std::vector<SwitchEvent>& switches() const { return switches_; }
  // Returns the changes of the verdict, from the first verdict that is not unknown.
  const std::vector<VerdictEvent>& verdicts() const { return verdicts_; }
  const FrameProfile& profile() const { return profile_; }
  // Returns the outcomes of the switches in the order in which they settled, at most 65,536.
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
  // Waits until the next frame is due. Returns the time.
  uint64_t Pace(uint64_t now_ns);
  bool Note(const FrameSample& sample);
  void NoteVerdict(const FrameSample& sample);
  void Account(uint64_t step_ns, uint64_t path_ns, const FrameSample& sample);

  Scene& scene_;
  FrameSink& sink_;
  const uint64_t frame_interval_ns_;
  uint64_t next_frame_ns_ = 0;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
  uint64_t start_ns_ = 0;
  uint64_t end_cost_ns_ = 0;  // duration of the last EndFrame; counted in the next frame's time
  uint64_t frame_count_ = 0;
  uint32_t arm_ = 0;
  FrameProfile profile_;
  std::vector<ArmActivity> activities_;
  std::vector<SwitchEvent> switches_;
  Verdict verdict_ = Verdict::kUnknown;
  std::vector<VerdictEvent> verdicts_;
  std::vector<SwitchOutcome> outcomes_;
};

// Returns the shadow lane's options for a decider whose intervals are divided by `time_scale`. The
// lane then has as many sweeps per decision as without scaling.
ShadowOptions ScaledShadow(ShadowMode mode, double time_scale);

// Returns "policy", "exploration", "bail-out" or "manual".
std::string ReasonName(SwitchReason reason);
// Returns "unknown", "stable", "tie", "ambiguous" or "degraded".
std::string VerdictName(Verdict verdict);

// Returns the outcome of the switch with this epoch, all zeros if there is none. The switch back
// after a trial has two outcomes: one at once, and one after it has settled. The result combines
// both.
SwitchOutcome OutcomeOf(std::span<const SwitchOutcome> outcomes, uint32_t switch_epoch);

}  // namespace sweepstake::cli
