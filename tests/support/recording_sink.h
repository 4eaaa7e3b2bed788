// A sink that records everything it receives.
#pragma once

#include <vector>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake::test_support {

class RecordingSink final : public FrameSink {
 public:
  void OnFrame(const FrameSample& sample) noexcept override { frames.push_back(sample); }
  void OnDescriptor(const SceneDescriptor& descriptor) noexcept override {
    descriptors.push_back(descriptor);
  }
  void OnSwitch(const SwitchOutcome& outcome) noexcept override { switches.push_back(outcome); }
  void OnModeChange(const ModeChange& change) noexcept override { mode_changes.push_back(change); }
  void OnShadow(const ShadowSample& sample) noexcept override { shadows.push_back(sample); }

  std::vector<FrameSample> frames;
  std::vector<SceneDescriptor> descriptors;
  std::vector<SwitchOutcome> switches;
  std::vector<ModeChange> mode_changes;
  std::vector<ShadowSample> shadows;  // written by the lane's thread; read them after its end
};

}  // namespace sweepstake::test_support
