// Combines the sources of a scene into evidence about each arm for a new session. A source is one
// session, on some machine with some build.
//
// The model: log-cost = level of the source + effect of the arm + interaction of both. Each source
// has its own level, and arms are compared within a source. So a machine that is twice as fast does
// not contradict the others.
//
// Levels and effects are weighted medians (median polish: J. W. Tukey, Exploratory Data Analysis,
// 1977, ch. 11). If a tenth of the sources send false values, the result hardly changes: no source
// counts as more certain than the median one, and outliers are dropped.
//
// The interaction is a random effect of the source. It limits the certainty of the prior, because
// the next source may differ from the common value however many sources there are. Pure functions.
#pragma once

#include <span>
#include <vector>

#include "engine_client/decider/pooling/scene_prior.h"

namespace sweepstake::decision {

// What a source and the session have in common.
struct SourceRelation {
  bool same_build = false;
  bool same_machine_class = false;
  bool same_backend_version = true;  // version of the arm's backend
};

// Returns the weight of a source's evidence about an arm in the prior. It is the exponent of a
// power prior (J. Ibrahim, M.-H. Chen, "Power prior distributions for regression models",
// Statistical Science 15, 2000).
double PowerPriorWeight(const SourceRelation& relation);

// The evidence of one source about an arm.
struct SourceArm {
  EvidenceSum sum = {};  // from PoolEvidence; 0: no evidence
  double weight = 1;     // weight in the power prior, > 0 and at most 1
};
using SourceEvidence = std::vector<SourceArm>;

// Returns one sum per arm. Beta(1,1) plus the sum is the prior of a session that has the evidence
// `own` (zeros for a new session). The sum is `own` plus the sources' evidence, shifted to the
// level of `own`. It is 0 for an arm without evidence. REQUIRES: reward version 3, and as many arms
// in each source as in `own`.
std::vector<EvidenceSum> CombineSources(std::span<const SourceEvidence> sources,
                                        std::span<const EvidenceSum> own);

}  // namespace sweepstake::decision
