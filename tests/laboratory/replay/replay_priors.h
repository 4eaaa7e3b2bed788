// Computes the priors that a daemon serves to a game after other games, with decision::PriorFor.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/pooling/prior.h"
#include "tests/laboratory/replay/replay_run.h"
#include "tests/laboratory/replay/replay_scene.h"

namespace sweepstake::cli {

enum class ReplayPriors {
  kNone,
  kRight,   // from a game on the same scene, build and machine class
  kWrong,   // from a game like kRight, with the ranking of the arms reversed
  kClass,   // from a game on the same scene and build, on another machine class
  kScenes,  // from games on all other scenes; the scene itself is new
};
inline constexpr std::array<std::string_view, 5> kReplayPriorsNames = {"none", "right", "wrong",
                                                                       "class", "scenes"};

// Standard deviation of an arm's relative log-cost between two classes of machines. The value was
// measured between AVX-512 and SSE4: the median over the cells of
// tests/bench/results/amd-zen4-2cores-instruction-sets.csv.
inline constexpr double kClassDeviation = 0.17;

// Plays a game on a scene. The evidence of that game (ReplayResult::stored) becomes the priors.
using PlayGame = std::function<ReplayResult(const ReplayScene& scene)>;

// Returns the prior of a new session, which is unknown if there is no evidence. `others` are the
// project's other scenes. For kClass, `seed` determines how the costs of the arms differ between
// the machine classes.
decision::Prior ServedPrior(ReplayPriors kind, const std::string& policy, const ReplayScene& scene,
                            std::span<const ReplayScene* const> others, uint64_t seed,
                            const PlayGame& play);

}  // namespace sweepstake::cli
