// What the stored evidence of a scene says of each arm: from the frame thread's windows, of the
// arms that were live, and from the shadow lane's visits, of all arms.
//
// Windows of different arms are of different times, and a policy chooses the times: an arm that is
// live only where the scene is cheap looks cheap. A visit's sweep measures all arms on the same
// frames. Where there are visits, they therefore say how the arms compare, and the windows at which
// level. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace sweepstake::decision {

// What stored evidence was measured by; the frame thread has no name.
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
  EvidenceSum lane = {};        // visits; only reward version 3 has any
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

// Returns one sum per arm, which on top of Beta(1,1) is its prior. Without visits that is `live`.
// With them the mean is the visits', moved by what windows exceed visits on the mean of the arms
// that have both, and never better than windows with bail-outs say. Visits weigh no more than the
// lane's unknown bias lets them, however many there are.
std::vector<EvidenceSum> PoolEvidence(std::span<const ArmEvidence> arms);

// Gives the arms of which a scene's own sums say nothing what those of its project's other scenes
// have in common: the arm's mean cost relative to the other arms, at the level of the arms that the
// scene knows, with the deviation that the scenes show, and a factor of 1.35 at least. REQUIRES:
// reward version 3, and as many arms in each scene.
std::vector<EvidenceSum> WithOtherScenes(std::vector<EvidenceSum> own,
                                         std::span<const std::vector<EvidenceSum>> others);

}  // namespace sweepstake::decision
