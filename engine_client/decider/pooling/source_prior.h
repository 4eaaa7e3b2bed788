// Combines the sources of a scene into evidence about each arm for a new session. A source is a
// session on some machine with some build.
//
// A machine that is twice as fast does not contradict the others, because each source has a level
// of its own, and arms are compared within a source: log-cost = level of the source + effect of the
// arm + interaction of both. Levels and effects are weighted medians (J. W. Tukey, Exploratory Data
// Analysis, 1977, ch. 11: median polish). A tenth of hostile sources hardly moves them: no source
// counts as more certain than the median one, and outliers are dropped. The rest is the random
// effect of the sources: how far the next source may be from the common value, however many sources
// there are. Pure functions.
#pragma once

#include <span>
#include <vector>

#include "engine_client/decider/pooling/scene_prior.h"

namespace sweepstake::decision {

// The common properties of a source and a session.
struct SourceRelation {
  bool same_build = false;
  bool same_machine_class = false;
  bool same_backend_version = true;  // version of the arm's backend
};

// Returns the weight of a source's evidence about an arm, that of a power prior (J. Ibrahim,
// M.-H. Chen, "Power prior distributions for regression models", Statistical Science 15, 2000).
double PowerPriorWeight(const SourceRelation& relation);

// The evidence of one source about an arm.
struct SourceArm {
  EvidenceSum sum = {};  // from PoolEvidence; empty: no evidence
  double weight = 1;     // weight in the power prior, > 0 and at most 1
};
using SourceEvidence = std::vector<SourceArm>;

// Returns one sum per arm. On top of Beta(1,1) it is the prior of a session that has the evidence
// `own` (0 for each arm of a new session): `own` plus the sources' evidence at the level of `own`.
// An arm without evidence has none. REQUIRES: reward version 3, and as many arms in each source as
// in `own`.
std::vector<EvidenceSum> CombineSources(std::span<const SourceEvidence> sources,
                                        std::span<const EvidenceSum> own);

}  // namespace sweepstake::decision
