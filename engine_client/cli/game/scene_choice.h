// Interprets SCENE, --objects, --seed and --arms of the command line. Pure functions, thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sweepstake/scene.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Identifies a scene to open.
struct SceneChoice {
  std::string name;  // a name or path that MakeScene accepts
  uint32_t object_count = 0;
  uint64_t seed = 1;
};

// Returns every combination of a scene and an object count. A recorded file has its own count and
// appears once. These words stand for several scenes: `all` (the eight reference scenes),
// `changing`, `degenerate` (without the mixture), `mixtures` (ten mixtures, from ten seeds).
std::vector<SceneChoice> ExpandScenes(const std::vector<std::string>& names,
                                      const std::vector<uint32_t>& object_counts, uint64_t seed);

// Returns the valid values for SCENE, except FILE.aabbs, as lines for a command's help.
std::string SceneHelp();

// Opens the scene. `choice.seed` is used as both the spawn seed and the motion seed. Errors: those
// of MakeScene.
Result<std::unique_ptr<Scene>> OpenScene(const SceneChoice& choice);

// Returns the backends named, each at most once; `all` stands for all of them. Error: kNotFound,
// with a list of the backends.
Result<std::vector<std::string>> ChooseArms(const std::vector<std::string>& names);

}  // namespace sweepstake::cli
