// The SCENE, --objects, --seed and --arms of the command line, resolved. Pure functions, safe from
// any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sweepstake/scene.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// One scene to open.
struct SceneChoice {
  std::string name;  // as MakeScene takes it, or a changing or degenerate scene's
  uint32_t object_count = 0;
  uint64_t seed = 1;
};

// Scenes × object counts. Recorded files have their own count and come once. The words `all` (the
// eight scenes), `changing`, `degenerate` and `mixtures` (ten, from ten seeds) stand for many.
std::vector<SceneChoice> ExpandScenes(const std::vector<std::string>& names,
                                      const std::vector<uint32_t>& object_counts, uint64_t seed);

// The names that a command's SCENE may have besides FILE.aabbs, in lines for its help.
std::string SceneHelp();

// The errors of MakeScene; for an unknown name one that lists the other scenes too.
Result<std::unique_ptr<Scene>> OpenScene(const SceneChoice& choice);

// `all`, or names of backends, each once. kNotFound lists the backends.
Result<std::vector<std::string>> ChooseArms(const std::vector<std::string>& names);

}  // namespace sweepstake::cli
