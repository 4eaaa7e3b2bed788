// Backends against the oracle: every frame of a scene, by the identity of the pairs.
// Not thread-safe. Cost per frame: the oracle plus each backend and a sort of its pairs.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/game/pair_oracle.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct FirstDifference {
  uint64_t frame = 0;
  PairDifference pairs;
};

struct ArmVerdict {
  std::string arm;
  uint64_t frame_count = 0;                         // frames that were right, or all of them
  uint64_t pair_count = 0;                          // right ones, summed over these frames
  std::optional<FirstDifference> first_difference;  // absent: the arm passed
};

// A frame may have so many pairs: the oracle and every arm hold 8 bytes and, while their buffers
// grow, up to 24 for each, which is 2 to 4 GB for all arms.
inline constexpr size_t kMostCheckedPairs = 20'000'000;

// Checks the scene's present frame and `step_count` further ones. An arm that differed is left out
// of what follows. `on_frame` hears the number of frames done. kResourceExhausted: a frame has more
// than `most_pairs`, of which no arm hears.
Result<std::vector<ArmVerdict>> CheckScene(Scene& scene,
                                           std::span<const std::unique_ptr<BroadPhase>> arms,
                                           uint64_t step_count,
                                           const std::function<void(uint64_t)>& on_frame,
                                           size_t most_pairs = kMostCheckedPairs);

}  // namespace sweepstake::cli
