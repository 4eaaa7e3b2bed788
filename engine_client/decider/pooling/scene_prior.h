// Combines the stored evidence of a scene about each arm. Arms that were live have windows of the
// frame thread. All arms may have visits of the shadow lane.
//
// Windows of different arms come from different times, and a policy chose those times. For example,
// an arm that was live only while the scene was cheap looks cheap. The visits of a sweep measure
// all arms on the same frames. Therefore visits determine the differences between arms, and windows
// determine the level. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine_client/decider/pooling/prior_record.h"
#include "engine_client/math/saturating_sum.h"

namespace sweepstake::decision {

// A record's measured_by is kLaneName or, for the frame thread, empty.
inline constexpr std::string_view kLaneName = "lane";
constexpr bool IsMeasuredBy(std::string_view name) { return name.empty() || name == kLaneName; }

// Sums of increments of alpha and beta. They do not include a prior.
struct EvidenceSum {
  double alpha = 0;  // finite, >= 0
  double beta = 0;   // finite, >= 0

  double evidence() const { return alpha + beta; }
  EvidenceSum& operator+=(const EvidenceSum& other) {
    alpha += other.alpha;
    beta += other.beta;
    return *this;
  }
};

struct ArmEvidence {
  EvidenceSum live = {};        // windows, and the penalties of bail-outs
  EvidenceSum lane = {};        // visits; empty except in reward version 3
  uint64_t bail_out_count = 0;  // bail-outs whose penalties are in `live`
  uint64_t window_count = 0;
  uint64_t visit_count = 0;

  ArmEvidence& operator+=(const ArmEvidence& other) {
    live += other.live;
    lane += other.lane;
    bail_out_count = SaturatingSum(bail_out_count, other.bail_out_count);
    window_count = SaturatingSum(window_count, other.window_count);
    visit_count = SaturatingSum(visit_count, other.visit_count);
    return *this;
  }
};

// Returns stored evidence of an arm as evidence of the frame thread or of the lane.
ArmEvidence EvidenceBy(std::string_view measured_by, const Evidence& evidence);

// Returns whether any arm has evidence.
bool IsAnythingKnown(std::span<const EvidenceSum> arms);

// Returns one sum per arm. Beta(1,1) plus the sum is the arm's prior.
// - Without visits the sum is `live`.
// - With visits, the mean is the mean of the visits plus the difference between windows and visits,
//   averaged over the arms that have both.
// - If the arm bailed out, its mean is never better than the mean of its windows.
// - The weight of visits is limited, however many there are, because the bias of the lane is
//   unknown.
std::vector<EvidenceSum> PoolEvidence(std::span<const ArmEvidence> arms);

// Fills in the arms for which a scene has no evidence, from the project's other scenes. Such an arm
// gets its mean cost relative to the other arms, at the level of the scene's own arms. The standard
// deviation is the one between the scenes, but at least a factor of 1.35. REQUIRES: reward version
// 3, and the same arms in each scene.
std::vector<EvidenceSum> WithOtherScenes(std::vector<EvidenceSum> own,
                                         std::span<const std::vector<EvidenceSum>> others);

}  // namespace sweepstake::decision
