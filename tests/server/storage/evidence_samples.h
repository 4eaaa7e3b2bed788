// Sample evidence for tests of stores.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/sessions/prior_store.h"

namespace sweepstake::storage {

using priors::EvidenceKey;
using priors::PriorRecord;
using priors::PriorStore;
using priors::SceneKey;
using priors::SourceUpdate;

inline EvidenceKey Key(const std::string& arm, const std::string& scene = "harbour") {
  return {.project = "game",
          .scene = scene,
          .measured_by = "",
          .arm = arm,
          .backend_version = 1,
          .machine_class = "desktop",
          .reward_version = 1};
}

// A steady clock for AuditLimits that is so fast that the retention clock is the wall clock.
inline int64_t FastSteadyNs() {
  static std::atomic<int64_t> now_ns = 0;
  return now_ns += int64_t{100} * 86'400'000'000'000;
}

// Returns the key of an arm's evidence in a regime.
inline EvidenceKey KeyIn(const std::string& regime, const std::string& arm) {
  EvidenceKey key = Key(arm);
  key.regime = regime;
  return key;
}

// Returns the n-th commit of a source, with one window's evidence about each of the keys.
inline SourceUpdate Update(const std::string& source, uint64_t n,
                           const std::vector<EvidenceKey>& keys) {
  SourceUpdate update;
  update.progress = {.source_id = source,
                     .commit_sequence = n,
                     .message_sequence = 10 * n,
                     .explored_arm_count = static_cast<uint32_t>(n),
                     .decision_count = 100 * n,
                     .frame_count = 1000 * n,
                     .seed = std::numeric_limits<uint64_t>::max()};
  for (const EvidenceKey& key : keys) {
    update.increments.push_back(
        {key, {.alpha = 0.75, .beta = 0.25, .window_count = 1, .bail_out_count = 2}});
  }
  return update;
}

// Returns the first commit of a source with this origin and time.
inline SourceUpdate UpdateOf(const priors::SourceOrigin& origin, uint64_t unix_time_s,
                             const std::string& source, const std::vector<EvidenceKey>& keys) {
  SourceUpdate update = Update(source, 1, keys);
  update.unix_time_s = unix_time_s;
  update.origin = origin;
  return update;
}

inline PriorRecord Record(const std::string& source, uint64_t sequence, const EvidenceKey& key,
                          double alpha) {
  return {
      key, source, sequence, {.alpha = alpha, .beta = 0.5, .window_count = 3, .bail_out_count = 0}};
}

// The stored sum of a key.
struct KeySum {
  priors::Evidence evidence;
  uint64_t source_count = 0;  // number of sources
};
struct KeySums {
  std::vector<KeySum> sums;  // in the order of the given keys
  // Number of sources of all scenes that have evidence about one of the keys.
  uint64_t source_count = 0;
};

inline absl::StatusOr<KeySums> LoadSums(priors::PriorReader& store,
                                        const std::vector<EvidenceKey>& keys) {
  KeySums result;
  std::set<SceneKey> counted;
  for (const EvidenceKey& key : keys) {
    KeySum& sum = result.sums.emplace_back();
    const SceneKey scene{key.project, key.scene, key.machine_class, key.reward_version};
    auto stored = store.LoadScene(scene);
    auto sources = store.LoadSources(scene);
    if (!stored.ok()) return stored.status();
    if (!sources.ok()) return sources.status();
    if (!stored->has_value()) continue;
    const auto of_key = [&key](priors::SceneEvidence& evidence) {
      return evidence.ArmOf(key.arm, key.backend_version).regimes[key.regime].of(key.measured_by);
    };
    sum.evidence = of_key(**stored);
    for (priors::SceneSource& source : *sources) {
      const bool same_class = source.evidence.key == scene;
      if (same_class && of_key(source.evidence) != priors::Evidence()) ++sum.source_count;
    }
    if (sum.source_count > 0 && counted.insert(scene).second)
      result.source_count += (*stored)->source_count;
  }
  return result;
}

}  // namespace sweepstake::storage
