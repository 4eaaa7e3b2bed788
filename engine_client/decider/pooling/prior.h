// Turns stored evidence into the prior of a session. The daemon, the embedded decider and the
// command line all call PriorFor, so a game starts from the same prior online and offline. Pure
// functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/math/beta_distribution.h"

namespace sweepstake::decision {

// Evidence of one source about one version of an arm, in one scene on one class of machines. The
// same subject may occur in several records, whose evidence is added. Strings are borrowed.
struct ArmRecord {
  std::string_view project;
  std::string_view scene;
  std::string_view machine_class;  // empty: unknown
  uint32_t reward_version = 1;
  std::string_view source;  // a session, or the sum of several
  std::string_view build;   // build of the source; empty: unknown
  std::string_view arm;
  uint32_t backend_version = 1;
  ArmEvidence evidence = {};
  uint64_t source_count = 1;  // greater for a sum over all sources of the scene
};

// The session that starts.
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
  // Compares sources, and scenes of the project, which requires reward version 3. Otherwise the
  // prior is the sum over the sources of the scene and machine class.
  bool compares_sources = false;
};

// Sources that have the same weight, build and machine class.
struct SourceGroup {
  double weight = 1;  // weight of the arms in the session's versions
  std::string build;
  std::string machine_class;
  uint64_t source_count = 0;
};

struct Prior {
  std::vector<EvidenceSum> evidence;  // one per arm of the key, without Beta(1,1)
  // The number of the scene's sources or, if they have no evidence, of the sources of the other
  // scenes that were used. 0 if there is no evidence.
  uint64_t source_count = 0;
  std::vector<SourceGroup> groups;  // the sources of the scene, by falling weight
  uint64_t other_scene_count = 0;   // scenes of the project that were compared

  bool is_known() const { return IsAnythingKnown(evidence); }
  // Returns Beta(1,1) plus the evidence of each arm. Evidence that exceeds the maximum of a session
  // is scaled down in proportion. Empty if there is no evidence, because a policy that starts from
  // priors would treat flat priors as evidence.
  std::vector<BetaPosterior> posteriors() const;
};

// Returns whether evidence of one version of an arm counts instead of evidence of another. The
// session's own version comes first, then the latest. Versions count from 1; 0 stands for none.
bool IsBetterVersion(uint32_t version, uint32_t other, uint32_t own);

// Returns the prior of a session. Records of other projects and reward versions are ignored.
// REQUIRES: as many versions as arms; source names are unique within a scene and machine class.
Prior PriorFor(std::span<const ArmRecord> records, const PriorKey& key);

}  // namespace sweepstake::decision
