// Pools the stored evidence of a scene's arms for readers who compare them. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine_client/decider/policy/scene_diagnosis.h"
#include "engine_client/decider/pooling/scene_prior.h"

namespace sweepstake::decision {

// The evidence about one backend version of an arm. The name is borrowed.
struct VersionEvidence {
  std::string_view arm;
  uint32_t backend_version = 1;
  ArmEvidence evidence = {};
};

struct PooledScene {
  // One item per version, in the order of the argument. The posteriors of `arms` are Beta(1,1) plus
  // `pooled`. DiagnoseScene and LeaderOf compare them.
  std::vector<EvidenceSum> pooled;
  std::vector<SceneArm> arms;
  // Average evidence per live window; 0 if there is none. Arms with bail-outs are left out, because
  // the penalties of bail-outs are evidence without windows.
  double window_evidence = 0;
};

// Pools the newest version of each arm with the newest versions of the others, as sessions do. Each
// older version is pooled alone.
PooledScene PoolScene(std::span<const VersionEvidence> versions);

}  // namespace sweepstake::decision
