// A sink that keeps everything it is given.
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

  std::vector<FrameSample> frames;
  std::vector<SceneDescriptor> descriptors;
  std::vector<SwitchOutcome> switches;
};

}  // namespace sweepstake::test_support
