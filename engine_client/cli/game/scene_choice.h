// Resolves SCENE, --objects, --seed and --arms of the command line. Pure functions, safe from any
// thread.
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
  std::string name;  // a name or path that MakeScene accepts
  uint32_t object_count = 0;
  uint64_t seed = 1;
};

// Returns all scenes × all object counts. A recorded file has its own count and appears once. The
// words `all` (the eight reference scenes), `changing`, `degenerate` (without the mixture) and
// `mixtures` (ten, from ten seeds) stand for several scenes.
std::vector<SceneChoice> ExpandScenes(const std::vector<std::string>& names,
                                      const std::vector<uint32_t>& object_counts, uint64_t seed);

// Returns the valid names for a command's SCENE besides FILE.aabbs, in lines for its help.
std::string SceneHelp();

// Opens the scene. Both seeds of the scene are the choice's seed. Errors: those of MakeScene.
Result<std::unique_ptr<Scene>> OpenScene(const SceneChoice& choice);

// Resolves `all` or names of backends, each at most once. Error: kNotFound (lists the backends).
Result<std::vector<std::string>> ChooseArms(const std::vector<std::string>& names);

}  // namespace sweepstake::cli
