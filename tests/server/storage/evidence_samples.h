// Evidence to test stores with.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "server/priors/prior_store.h"

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

// The n-th commit of a source, with one window's evidence about each of the keys.
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

inline PriorRecord Record(const std::string& source, uint64_t sequence, const EvidenceKey& key,
                          double alpha) {
  return {
      key, source, sequence, {.alpha = alpha, .beta = 0.5, .window_count = 3, .bail_out_count = 0}};
}

}  // namespace sweepstake::storage
