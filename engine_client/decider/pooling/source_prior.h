// What the sources of a scene, which are sessions on one machine or another, of one build or
// another, say together of each arm, for one more session.
//
// A machine that is twice as fast does not contradict the others, since each source has a level of
// its own, and arms are compared within a source: log-cost = level of the source + the arm's
// + what the two of them have in particular. Levels and arms are weighted medians (J. W. Tukey,
// Exploratory Data Analysis, 1977, ch. 11: median polish), which a tenth of sources that lie hardly
// move: none is heard as surer than the median one, nor at all where it is far from the others.
// What remains is the random effect of the sources: how far the next one may be from what they have
// in common, however many there are. Pure functions.
#pragma once

#include <span>
#include <vector>

#include "engine_client/decider/pooling/scene_prior.h"

namespace sweepstake::decision {

// What a source and a session have in common.
struct SourceRelation {
  bool same_build = false;
  bool same_machine_class = false;
  bool same_backend_version = true;  // of the arm
};

// Returns the weight of a source's evidence about an arm, that of a power prior (J. Ibrahim,
// M.-H. Chen, "Power prior distributions for regression models", Statistical Science 15, 2000).
double PowerPriorWeight(const SourceRelation& relation);

// What one source knows of an arm.
struct SourceArm {
  EvidenceSum sum = {};  // what PoolEvidence makes of its windows and visits; empty: nothing
  double weight = 1;     // of the power prior: > 0, and at most 1
};
using SourceEvidence = std::vector<SourceArm>;

// Returns one sum per arm, which on top of Beta(1,1) is the prior of a session that has `own`
// evidence already, or none of any arm: that and, at its level, what the sources say. An arm that
// nobody knows has none. REQUIRES: reward version 3, and as many arms in each source as in `own`.
std::vector<EvidenceSum> CombineSources(std::span<const SourceEvidence> sources,
                                        std::span<const EvidenceSum> own);

}  // namespace sweepstake::decision
