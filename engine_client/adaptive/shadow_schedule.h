// Decides which arms the shadow lane visits, and when. Visits are grouped in sweeps over the arms.
// A budget determines the time between sweeps.
//
//   if (schedule.IsDue(now_ns, search_ns)) {
//     schedule.Begin(now_ns, search_ns, active_arm, object_count);
//     while (const auto arm = schedule.NextArm()) schedule.OnVisit(/* its cost */);
//   }
//
// The first sweep is due at once and visits every arm. After that:
// - The active arm comes first in one sweep and last in the next, since all others are compared
//   with it. The order of the other arms is reversed too, so that no arm always has the better
//   place.
// - An arm within kContenderRatio of the cheapest known cost is in every sweep. An arm that costs r
//   times as much is in every r²-th sweep, but at least in every kMaxPeriod-th. It thus takes 1/r
//   of a cheap arm's share of the budget.
// - If the object count or the cost of the active arm changes by more than kChangeRatio, the scene
//   counts as a different one. The sweep then visits every arm again.
// - An arm whose visit ends at the time cap is visited half as often each time, down to every
//   kMaxPeriod-th sweep. This ends when a visit stays below the cap or the object count changes.
//   The active arm and arms within kContenderRatio are exempt. The same holds for an arm whose
//   structure exceeds the memory cap, without these exceptions.
// - Sweeps are spaced so that visits take duty_ratio of the time since the first one.
// - They are spaced further so that they cost the frame thread at most kMaxCostRatio of its time in
//   the long run (lane_cost.h). Costs not spent in the last kSavingsNs may be spent at once. A
//   different scene grants these savings again, at most once per kSavingsNs.
// - All work together takes at most kMaxWorkRatio of the time of the frame thread's searches, plus
//   kWorkAheadNs, because a better arm saves only a part of the search time. This rule delays a
//   sweep by at most kMaxSpacingNs. Both the unused allowance and the excess are limited to
//   kWorkAheadNs: long play in manual mode builds up no large allowance, and a scene that keeps
//   changing no large debt. Both times are wall-clock time; the time scale does not apply.
//
// Deterministic and without side effects: time and costs come in as arguments. Not thread-safe.
// Times are ns of one clock that never goes back, from any origin.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sweepstake {

// The frames of a visit. The structure is built on the first one; the next kShadowWarmUpFrames
// still include the extra cost of a new structure; the others are measured.
inline constexpr uint32_t kShadowBurstFrames = 8;
inline constexpr uint32_t kShadowWarmUpFrames = 2;
// The lane runs this much of a sweep's first visit twice, because the first run after a pause is
// slower; in ns.
inline constexpr uint64_t kShadowWarmUpNs = 1'000'000;

struct ShadowScheduleOptions {
  double duty_ratio = 0.15;                      // the share of one thread's time, (0, 1]
  uint64_t visit_cap_ns = 250'000'000;           // time cap of a visit
  uint64_t memory_cap_bytes = 64 * 1024 * 1024;  // the cap of one arm's structure
  // Decisions are seconds apart, so that more frequent sweeps would add no information.
  uint64_t sweep_interval_min_ns = 250'000'000;
};

// The cost of a visit to one arm.
struct ShadowVisit {
  uint32_t arm = 0;
  uint32_t frame_count = 0;   // the number of measured frames
  uint64_t detection_ns = 0;  // median of the measured frames; without any, the fastest frame
  uint64_t build_ns = 0;      // the time of the first frame
  uint64_t busy_ns = 0;       // total time of all frames
  uint64_t native_bytes = 0;
  uint64_t aabb_check_count = 0;  // mean over the measured frames
  bool capped = false;            // whether a cap ended the visit before the last frame
  // Whether detection_ns was measured. If not, detection_ns is the time cap: either the memory cap
  // ended the first frame (`capped`), or the lane's thread did not get its core, and the cost stays
  // unknown.
  bool is_measured = true;
};

// Summarizes a visit whose frames took `frame_ns`; frames that begin after `cap_ns` are left out.
// The caller sets arm, native_bytes and aabb_check_count. REQUIRES: 1 to kShadowBurstFrames frames.
ShadowVisit SummarizeVisit(std::span<const uint64_t> frame_ns, uint64_t cap_ns);

class ShadowSchedule {
 public:
  static constexpr double kContenderRatio = 1.5;
  static constexpr double kChangeRatio = 0.25;
  static constexpr uint32_t kMaxPeriod = 64;
  static constexpr double kMaxCostRatio = 0.005;
  static constexpr uint64_t kSavingsNs = 5'000'000'000;
  static constexpr double kMaxWorkRatio = 0.5;
  static constexpr uint64_t kWorkAheadNs = 100'000'000;
  static constexpr uint64_t kMaxSpacingNs = 5'000'000'000;

  // REQUIRES: arm_count >= 1.
  ShadowSchedule(const ShadowScheduleOptions& options, uint32_t arm_count);

  const ShadowScheduleOptions& options() const { return options_; }

  // Returns whether a sweep may begin. `search_ns` is the total time of the frame thread's searches
  // so far.
  bool IsDue(uint64_t now_ns, uint64_t search_ns) const;
  // Returns when the next sweep may begin, apart from the limit by search time; 0 before the first
  // one.
  uint64_t next_sweep_ns() const;

  // Begins a sweep. REQUIRES: active_arm < arm_count.
  void Begin(uint64_t now_ns, uint64_t search_ns, uint32_t active_arm, uint32_t object_count);
  // Returns the arm to visit next in this sweep, or nullopt if the sweep is complete.
  std::optional<uint32_t> NextArm() const;
  // REQUIRES: visit.arm is NextArm().
  void OnVisit(const ShadowVisit& visit);
  // Adds other work of the lane's thread to the sweep's cost.
  void Spend(uint64_t busy_ns) {
    busy_ns_ += busy_ns;
    matched_ns_ += static_cast<uint64_t>(static_cast<double>(busy_ns) / kMaxWorkRatio);
  }
  // Adds the frame thread's cost of the work up to `now_ns`.
  void Charge(uint64_t now_ns, double cost_ns);

 private:
  struct Arm {
    uint64_t cost_ns = 0;       // cost measured by the latest visit; 0 before the first
    uint64_t reference_ns = 0;  // cost measured by the first visit since the latest Renew
    uint64_t last_sweep = 0;    // the sweep of the latest visit; 0 if none since the latest Renew
    uint32_t back_off = 0;  // minimum sweeps between visits of an arm over a cap; 0: not over a cap
    bool too_big = false;   // whether the structure exceeds the memory cap
  };

  void Renew(bool end_back_off);
  void GrantSavings();
  uint64_t BestCost() const;
  uint32_t ArmAt(uint32_t place) const;
  uint64_t Period(uint32_t arm, uint64_t best_ns) const;
  bool Due(uint32_t arm, uint64_t best_ns) const;

  const ShadowScheduleOptions options_;
  std::vector<Arm> arms_;
  uint64_t sweep_ = 0;  // the number of the latest sweep
  uint64_t begun_ns_ = 0;
  uint64_t busy_ns_ = 0;  // work of the lane since the latest sweep began
  // No sweep begins before this time, so that the cost so far is at most kMaxCostRatio of the
  // elapsed time.
  uint64_t paid_ns_ = 0;
  uint64_t matched_ns_ = 0;  // search time that would justify all work so far
  uint64_t granted_ns_ = 0;  // time of the latest grant of savings
  uint32_t active_arm_ = 0;
  uint64_t reference_count_ = 0;  // object count when every arm was last due
};

}  // namespace sweepstake
