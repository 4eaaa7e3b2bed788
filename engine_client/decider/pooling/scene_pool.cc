#include "engine_client/decider/pooling/scene_pool.h"

namespace sweepstake::decision {

PooledScene PoolScene(std::span<const VersionEvidence> versions) {
  PooledScene scene;
  std::vector<size_t> places;  // indices of the newest versions
  std::vector<ArmEvidence> newest;
  double evidence = 0;
  double window_count = 0;
  for (const VersionEvidence& version : versions) {
    scene.arms.push_back({version.arm, version.backend_version, {}});
    if (version.evidence.bail_out_count > 0) continue;
    evidence += version.evidence.live.evidence();
    window_count += static_cast<double>(version.evidence.window_count);
  }
  if (window_count > 0) scene.window_evidence = evidence / window_count;
  scene.pooled.resize(versions.size());
  for (size_t i = 0; i < versions.size(); ++i) {
    if (IsOutdated(scene.arms[i], scene.arms)) {
      scene.pooled[i] = PoolEvidence({&versions[i].evidence, 1}).front();
    } else {
      places.push_back(i);
      newest.push_back(versions[i].evidence);
    }
  }
  const std::vector<EvidenceSum> together = PoolEvidence(newest);
  for (size_t i = 0; i < places.size(); ++i) scene.pooled[places[i]] = together[i];
  for (size_t i = 0; i < versions.size(); ++i)
    scene.arms[i].posterior = {1 + scene.pooled[i].alpha, 1 + scene.pooled[i].beta};
  return scene;
}

}  // namespace sweepstake::decision
