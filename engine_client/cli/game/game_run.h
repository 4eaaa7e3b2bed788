// A game without rendering: a scene steps, the frame path finds the pairs, and what happened is
// kept for the report.
//
// The frame time is the measured time of the frame's work (step, detection, end of frame); nothing
// is paced, so that a faster arm really makes more frames. Not thread-safe: Frame is the frame
// thread. The scene is borrowed.
#pragma once

#include <cstdint>
#include <memory>
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

// The decider's verdict became another one.
struct VerdictEvent {
  uint64_t frame_index = 0;  // the first frame that saw it
  uint64_t time_ns = 0;      // since the run began
  SceneVerdict verdict;
};

// What one arm did while it was active.
struct ArmActivity {
  uint64_t frame_count = 0;
  uint64_t active_ns = 0;     // its frames' times
  uint64_t detection_ns = 0;  // of these, the broad phase's
};

// Where the frames' time went, all frames together. The parts add up to it.
struct FrameProfile {
  uint64_t step_ns = 0;       // the scene's motion
  uint64_t detection_ns = 0;  // update and search of a standing structure
  uint64_t rebuild_ns = 0;    // the same of frames that built the structure anew
  uint64_t around_ns = 0;     // the rest up to EndFrame: pending switch, box copies, descriptors
  uint64_t end_ns = 0;        // EndFrame: sample, sink, bail-out guard
};

class GameRun final : private FrameSink {
 public:
  // `sink` takes what the frame path produces; borrowed. The errors of AdaptiveBroadPhase::Create.
  static Result<std::unique_ptr<GameRun>> Create(const AdaptiveOptions& options, Scene& scene,
                                                 FrameSink& sink);

  // One frame. Returns whether it ran on another arm than the one before; then switches() has one
  // more.
  bool Frame();

  AdaptiveBroadPhase& adaptive() { return *adaptive_; }
  const AdaptiveBroadPhase& adaptive() const { return *adaptive_; }
  uint64_t frame_count() const { return frame_count_; }
  // Since the run began.
  uint64_t elapsed_ns() const;
  // In the order of arms.
  const std::vector<ArmActivity>& activities() const { return activities_; }
  const std::vector<SwitchEvent>& switches() const { return switches_; }
  // From the first one that was not unknown.
  const std::vector<VerdictEvent>& verdicts() const { return verdicts_; }
  const FrameProfile& profile() const { return profile_; }
  // How switches went, as they settled. At most 65,536 are kept.
  const std::vector<SwitchOutcome>& outcomes() const { return outcomes_; }

 private:
  GameRun(Scene& scene, FrameSink& sink);

  void OnFrame(const FrameSample& sample) noexcept override;
  void OnDescriptor(const SceneDescriptor& descriptor) noexcept override;
  void OnSwitch(const SwitchOutcome& outcome) noexcept override;
  void OnShadow(const ShadowSample& sample) noexcept override;
  bool Note(const FrameSample& sample);
  void NoteVerdict(const FrameSample& sample);
  void Account(uint64_t step_ns, uint64_t path_ns, const FrameSample& sample);

  Scene& scene_;
  FrameSink& sink_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
  uint64_t start_ns_ = 0;
  uint64_t end_cost_ns_ = 0;  // of the last EndFrame; belongs to the next frame's time
  uint64_t frame_count_ = 0;
  uint32_t arm_ = 0;
  FrameProfile profile_;
  std::vector<ArmActivity> activities_;
  std::vector<SwitchEvent> switches_;
  Verdict verdict_ = Verdict::kUnknown;
  std::vector<VerdictEvent> verdicts_;
  std::vector<SwitchOutcome> outcomes_;
};

// The lane's options where every interval of the decider is divided by `time_scale`: its sweeps
// come as often per decision as without.
ShadowOptions ScaledShadow(ShadowMode mode, double time_scale);

// "policy", "exploration", "bail-out", "manual".
std::string ReasonName(SwitchReason reason);
// "unknown", "stable", "tie", "ambiguous", "degraded".
std::string VerdictName(Verdict verdict);

}  // namespace sweepstake::cli
