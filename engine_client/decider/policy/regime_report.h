// The measurements and estimates of a session for each regime of its scene: which arm is the best,
// and what its choices have saved. It is a report for people; decisions do not use it.
//
// "Saved" is defined as follows. If arm a ran in n successive frames of a regime, with a mean
// detection time of c (of calm frames, window.h), they add
//   n · c                    to the measured time
//   n · c · e^(y_j − y_a)    to the time of each arm j, where y is the policy's log-cost in this
//                            regime at that time
// An arm without a known cost adds n · c. The cost of each executed switch is added to the measured
// time. The saving against arm j is (time of j − measured time) ÷ frames. So an arm that runs all
// the time saves nothing against itself, and a change that affects all arms cancels out.
// All measured frames count. Settling frames do not; the cost of the switch contains theirs.
//
// Times are in µs. Plain values and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// The arm that savings are reported against in every session that has it: the initial arm of a game
// that does not choose one.
inline constexpr std::string_view kReferenceArm = "KDTree";

// Identifies a regime within a session. The place of a forgotten regime is used again, with another
// number.
struct RegimeId {
  uint32_t place = 0;   // < RegimeMemory::kMaxRegimes
  uint32_t number = 0;  // number of regimes that began before it
  bool operator==(const RegimeId&) const = default;
};

// The descriptor that is typical of a regime. A value that was not measured is absent.
struct RegimeCentre {
  std::optional<double> object_count = {};
  std::optional<double> speed_mean = {};    // world units per frame
  std::optional<double> static_ratio = {};  // share of objects that did not move
};

// A policy's belief about one regime.
struct RegimeBelief {
  struct Arm {
    NormalBelief log_cost;
    // Such that the difference of two arms has the sum of their variances. It is smaller than the
    // variance of the log-cost if costs are correlated.
    double difference_variance = 0;
    bool is_known = false;  // the arm was observed, or has a prior
  };

  RegimeId id = {};
  RegimeCentre centre = {};
  bool is_present = false;
  std::vector<Arm> arms = {};  // one per arm; empty if the policy does not estimate costs
};

// The measured frames of a session, in one regime or in total.
struct RegimeUse {
  RegimeId id = {};
  uint64_t frame_count = 0;
  double ran_us = 0;  // what ran, with its switches
  // What each arm would have taken. Contains what ran in the frames in which the arm's cost was not
  // known.
  std::vector<double> arm_us = {};
  std::vector<uint64_t> known_frame_counts = {};  // frames in which each arm's cost was known
};

// Returns whether an arm's cost was known in most of the frames. Otherwise its sum says little.
bool IsMostlyKnown(const RegimeUse& use, uint32_t arm);
// Returns what was saved per frame in µs against always running `arm`; a loss is negative. Absent
// unless the arm's cost is mostly known.
std::optional<double> SavedPerFrame(const RegimeUse& use, uint32_t arm);

struct ArmReport {
  struct Cost {
    double us = 0;  // mean detection time per frame: median of the belief
    double low_us = 0;
    double high_us = 0;  // the cost is between low_us and high_us with a probability of 95 %
  };
  std::optional<Cost> cost = {};  // absent: not known
  double best_probability = 0;
};

struct RegimeReport {
  RegimeCentre centre = {};
  bool is_present = false;
  double frame_share = 0;                 // share of the measured frames
  std::vector<ArmReport> arms = {};       // one per arm; empty before anything is learnt
  std::optional<uint32_t> best_arm = {};  // the known arm with the lowest cost
  // The next four are absent without a measured frame in this regime. The savings are also absent
  // if the cost of the other arm was not known in most of the frames. A loss is negative.
  std::optional<double> ran_us = {};  // per frame
  // Per frame, against SceneReport::total.best_arm and the arms of SavingBaselines.
  std::optional<double> saved_against_single_us = {};
  std::optional<double> saved_against_reference_us = {};
  std::optional<double> saved_against_initial_us = {};
};

// The arms that savings are reported against, beside the best single arm.
struct SavingBaselines {
  std::optional<uint32_t> reference = {};  // index of kReferenceArm, if the session has it
  uint32_t initial = 0;                    // SessionSetup::initial_arm
};

struct SceneReport {
  // Over all regimes. best_arm is the best single arm: the known arm with the lowest mean cost over
  // all measured frames. Before the first one it is that of the present regime.
  RegimeReport total;
  std::vector<RegimeReport> regimes;  // empty if there is only one, which `total` describes
};

// Returns whether the regimes have different best arms, so that no single arm is the best. Regimes
// without a known arm do not count.
bool BestArmsDiffer(const SceneReport& report);

// `beliefs` has one entry per regime, with one present. `uses` has at most one entry per regime;
// `total` also contains the frames of forgotten regimes. `diagnosis` replaces the beliefs of a
// policy that does not estimate costs.
SceneReport ReportOf(std::span<const RegimeBelief> beliefs, std::span<const RegimeUse> uses,
                     const RegimeUse& total, const Diagnosis& diagnosis,
                     const SavingBaselines& baselines);

}  // namespace sweepstake::decision
