#include "server/sessions/source_weights.h"

#include <algorithm>
#include <utility>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/prior.h"
#include "engine_client/decider/pooling/source_prior.h"

namespace sweepstake::sessions {
namespace {

// Returns whether a session whose arm has the version `own` uses the source's evidence of the key.
// It uses only the source's best version of the arm.
bool IsUsed(const priors::SceneSource& source, const priors::EvidenceKey& key, uint32_t own) {
  uint32_t best = 0;
  bool has_it = false;
  for (const priors::SceneEvidence::Arm& arm : source.evidence.arms) {
    if (arm.name != key.arm) continue;
    best = decision::BestVersion(arm.backend_version, best, own);
    const auto regime = arm.regimes.find(key.regime);
    if (arm.backend_version == key.backend_version && regime != arm.regimes.end())
      has_it = regime->second.of(key.measured_by) != priors::Evidence();
  }
  return has_it && key.backend_version == best;
}

}  // namespace

absl::StatusOr<double> SourceWeights::Of(const priors::PriorRecord& record) {
  if (record.is_quarantined) return 0;
  const priors::EvidenceKey& key = record.key;
  const auto scene = Find({key.project, key.scene, key.machine_class, key.reward_version});
  if (!scene.ok()) return scene.status();
  const auto newest = (*scene)->newest_versions.find(key.arm);
  const uint32_t own = newest == (*scene)->newest_versions.end() ? 0 : newest->second;
  const bool is_newest = key.backend_version == own;
  const auto source = (*scene)->sources.find(record.source_id);
  if (source == (*scene)->sources.end() || !IsUsed(source->second, key, own)) return 0;
  // The rewards of other versions are summed over the sources.
  if (key.reward_version != decision::kLogCostRewardVersion) return is_newest ? 1 : 0;
  return decision::PowerPriorWeight({.same_build = source->second.build == (*scene)->newest_build,
                                     .same_machine_class = true,
                                     .same_backend_version = is_newest});
}

absl::StatusOr<const SourceWeights::Scene*> SourceWeights::Find(const priors::SceneKey& key) {
  const auto [found, is_new] = scenes_.try_emplace(key);
  Scene& scene = found->second;
  if (!is_new) return &scene;
  auto sources = store_.LoadSources(key);
  if (!sources.ok()) return sources.status();
  uint64_t last_seen_unix_s = 0;
  for (priors::SceneSource& source : *sources) {
    if (source.evidence.key != key) continue;  // source of another machine class
    // The build of the most recent source is the newest. Among equally recent sources, the last one
    // in the order of LoadSources counts.
    if (source.last_seen_unix_s >= last_seen_unix_s) scene.newest_build = source.build;
    last_seen_unix_s = std::max(last_seen_unix_s, source.last_seen_unix_s);
    for (const priors::SceneEvidence::Arm& arm : source.evidence.arms) {
      uint32_t& newest = scene.newest_versions[arm.name];
      newest = decision::BestVersion(newest, arm.backend_version, 0);
    }
    scene.sources.emplace(source.id, std::move(source));
  }
  return &scene;
}

}  // namespace sweepstake::sessions
