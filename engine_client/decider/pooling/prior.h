// Turns stored evidence into the prior of a session. The daemon, the embedded decider and the
// command line all call PriorFor, so a game starts from the same prior with and without a daemon.
// Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/policy/regime_bucket.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/math/beta_distribution.h"

namespace sweepstake::decision {

// Evidence of one source about one version of an arm, in one regime of a scene on one class of
// machines. If several records agree in all these, their evidence is added. Strings are borrowed.
struct ArmRecord {
  std::string_view project;
  std::string_view scene;
  std::string_view machine_class;  // empty: unknown
  uint32_t reward_version = 1;
  std::string_view source;  // a session, or the sum of several
  std::string_view build;   // the game's build; empty: unknown
  std::string_view arm;
  uint32_t backend_version = 1;
  ArmEvidence evidence = {};
  uint64_t source_count = 1;     // above 1 if `source` is a sum over several sources
  std::string_view regime = {};  // the regime's bucket (policy/regime_bucket.h); empty: unknown
};

// Identifies the session that starts and its arms.
struct PriorKey {
  std::string project;
  std::string scene;
  std::string machine_class;
  uint32_t reward_version = 1;
  std::string build = {};
  // The session's own source, whose evidence counts in full; empty if it has none.
  std::string source = {};
  std::vector<std::string> arms;
  std::vector<uint32_t> backend_versions;  // one per arm
  // true: compares sources with each other, and compares other scenes of the project; needs reward
  // version 3. false: the prior is the sum over the sources of the scene and machine class.
  bool compares_sources = false;
};

// Sources of one scene that have the same weight, build and machine class.
struct SourceGroup {
  double weight = 1;  // weight of evidence about arms in the session's versions
  std::string build;
  std::string machine_class;
  uint64_t source_count = 0;
};

struct Prior {
  std::vector<EvidenceSum> evidence;  // one per arm of the key; does not include Beta(1,1)
  // Number of the scene's sources with evidence. If there are none: number of sources of the other
  // scenes that were used. 0 if there is no evidence.
  uint64_t source_count = 0;
  std::vector<SourceGroup> groups;  // groups of the scene's sources, highest weight first
  uint64_t other_scene_count = 0;   // number of other scenes that were compared
  // The priors of single regimes; the rest of this struct is about all regimes together. Empty
  // unless key.compares_sources. The scene's own regimes come first: the kMaxStoredRegimes with the
  // most evidence. Regimes that only other scenes have follow, up to kMaxRegimePriors in all. An
  // arm without evidence in its regime is filled in from the scene's other regimes, and from the
  // same regime of other scenes.
  RegimePriors regimes = {};

  bool is_known() const { return IsAnythingKnown(evidence); }
  // Whether some arm has no evidence.
  bool lacks_arms() const;
  // Returns Beta(1,1) plus the evidence, per arm. Evidence above a session's maximum is scaled down
  // in proportion. Empty if there is no evidence: a policy that starts from priors would treat flat
  // priors as evidence.
  std::vector<BetaPosterior> posteriors() const;
};

// Returns the backend version whose evidence is preferred: the session's own version `own` if it is
// `a` or `b`, else the later of them. Versions count from 1; 0 stands for none.
constexpr uint32_t BestVersion(uint32_t a, uint32_t b, uint32_t own) {
  return own != 0 && (a == own || b == own) ? own : (a > b ? a : b);
}

// Returns the prior of the session `key`. Records of other projects and reward versions are
// ignored, and records of other scenes if the scene's own ones know every arm. REQUIRES:
// key.backend_versions has one item per arm; source names are unique within a scene and machine
// class.
Prior PriorFor(std::span<const ArmRecord> records, const PriorKey& key);

}  // namespace sweepstake::decision
