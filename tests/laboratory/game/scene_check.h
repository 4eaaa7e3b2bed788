// Compares backends with the oracle in every frame of a scene, by the identity of the pairs.
// Not thread-safe. A frame costs the oracle plus, for each backend, its search and a sort of its
// pairs.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "sweepstake/status.h"
#include "tests/laboratory/game/pair_oracle.h"

namespace sweepstake::cli {

struct FirstDifference {
  uint64_t frame = 0;
  PairDifference pairs;
};

struct ArmCheck {
  std::string arm;
  uint64_t frame_count = 0;  // frames before the first difference
  uint64_t pair_count = 0;   // the pairs of these frames, summed
  // Absent if the arm passed.
  std::optional<FirstDifference> first_difference;
};

// The maximum number of pairs of a frame. The oracle and every arm hold 8 bytes per pair, and up to
// 24 while their buffers grow, which makes 2 to 4 GB for all arms.
inline constexpr size_t kMaxCheckedPairs = 20'000'000;

// Checks the scene's current frame and `step_count` further ones. An arm that differed is not
// checked in later frames. `on_frame` is called with the number of frames done. Error:
// kResourceExhausted (a frame has more than `max_pairs`; the arms are not run on that frame).
Result<std::vector<ArmCheck>> CheckScene(Scene& scene,
                                         std::span<const std::unique_ptr<BroadPhase>> arms,
                                         uint64_t step_count,
                                         const std::function<void(uint64_t)>& on_frame,
                                         size_t max_pairs = kMaxCheckedPairs);

}  // namespace sweepstake::cli
