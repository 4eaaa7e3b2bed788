// Combines the stored evidence of a scene about each arm: windows of the frame thread, for arms
// that were live, and visits of the shadow lane, for all arms.
//
// Windows of different arms come from different times, and a policy chooses the times: an arm that
// is live only while the scene is cheap looks cheap. A sweep of visits measures all arms on the
// same frames. Visits therefore determine the differences between the arms, and windows determine
// the level. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace sweepstake::decision {

// Values of measured_by: "lane", or empty for the frame thread.
inline constexpr std::string_view kLaneName = "lane";
constexpr bool IsMeasuredBy(std::string_view name) { return name.empty() || name == kLaneName; }

// Sums of increments, without any prior.
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
  uint64_t bail_out_count = 0;  // penalties in `live`

  ArmEvidence& operator+=(const ArmEvidence& other) {
    live += other.live;
    lane += other.lane;
    bail_out_count += other.bail_out_count;
    return *this;
  }
};

// Returns whether any arm has evidence.
bool IsAnythingKnown(std::span<const EvidenceSum> arms);

// Returns one sum per arm. On top of Beta(1,1) it is the arm's prior. Without visits it is `live`.
// With visits, the mean is that of the visits, shifted by the mean difference between windows and
// visits over the arms that have both. It is never better than that of windows with bail-outs. The
// weight of visits is limited by the unknown bias of the lane, however many there are.
std::vector<EvidenceSum> PoolEvidence(std::span<const ArmEvidence> arms);

// Fills in the arms that a scene has no evidence about from the project's other scenes: the arm's
// mean cost relative to the other arms, at the level of the arms that the scene knows. The
// deviation is that between the scenes, and at least a factor of 1.35. REQUIRES: reward version 3,
// and the same arms in each scene.
std::vector<EvidenceSum> WithOtherScenes(std::vector<EvidenceSum> own,
                                         std::span<const std::vector<EvidenceSum>> others);

}  // namespace sweepstake::decision
