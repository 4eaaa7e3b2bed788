// The ranges of SceneOptions.
#pragma once

#include <cstdint>

#include "sweepstake/scene.h"
#include "sweepstake/status.h"

namespace sweepstake {

inline constexpr uint32_t kMaxSceneObjectCount = 16'777'216;

// kInvalidArgument names the option, its range and the value. A non-finite value is out of every
// range.
Status ValidateObjectCount(uint32_t object_count);
Status ValidateSceneOptions(const SceneOptions& options);

}  // namespace sweepstake
