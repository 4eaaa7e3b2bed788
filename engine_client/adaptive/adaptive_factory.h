// Makes an AdaptiveBroadPhase from backends that the caller brings, beside the public Create with
// the registry's: scripted backends in tests take this way. Internal to this repository.
#pragma once

#include <memory>
#include <vector>

#include "engine_client/adaptive/arm_backend.h"
#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {

// What the shadow lane is made from; without `make` there is none.
struct LaneParts {
  ArmBackendFactory make;  // of its own backends
  size_t core_count = 0;   // of the machine
};

class AdaptiveFactory {
 public:
  // `backends` replace options.arms: the arms are their names. Errors as
  // AdaptiveBroadPhase::Create.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Make(const AdaptiveOptions& options,
                                                          std::vector<ArmBackend> backends,
                                                          const LaneParts& lane, FrameSink* sink,
                                                          Clock& clock);
  // Without a lane.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Make(
      const AdaptiveOptions& options, std::vector<std::unique_ptr<BroadPhase>> backends,
      FrameSink* sink, Clock& clock);
};

}  // namespace sweepstake
