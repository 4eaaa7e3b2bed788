// Decides which arms the shadow lane visits, and when. Visits are grouped in sweeps over the arms.
// Budgets determine the time between sweeps.
//
//   if (schedule.IsDue(now_ns, search_ns)) {
//     schedule.Begin(now_ns, search_ns, active_arm, object_count);
//     while (const auto arm = schedule.NextArm()) schedule.OnVisit(/* its cost */);
//   }
//
// The first sweep is due at once and visits every arm. After that:
// - Order. The active arm comes first in one sweep and last in the next, because all others are
//   compared with it. The order of the other arms is reversed too, so that no arm always has the
//   better place.
// - Frequency. An arm whose cost is within kContenderRatio of the cheapest is in every sweep. An
//   arm that costs r times as much as the cheapest is in every r²-th sweep, but at least in every
//   kMaxPeriod-th. So it takes 1/r of a cheap arm's share of the budget.
// - Changes. If the object count or the cost of the active arm changes by more than kChangeRatio,
//   the scene counts as a different one. The sweep then visits every arm again.
// - Arms over a cap. If a visit ends at the time cap, the arm is visited half as often. Each
//   further such visit halves the frequency again, down to every kMaxPeriod-th sweep. This ends
//   when a visit stays below the cap or the object count changes. It does not apply to the active
//   arm and to arms within kContenderRatio. An arm whose structure exceeds the memory cap is
//   visited less often by the same rule, without exceptions.
// - Spacing by the lane's time. From the start of one sweep to the start of the next, the lane
//   works at most duty_ratio of the time.
// - Spacing by the frame thread's time. In the long run, sweeps cost the frame thread at most
//   kMaxCostRatio of its time (lane_cost.h). An allowance that was not used in the last kSavingsNs
//   may be used at once. When the scene becomes a different one, this allowance is granted again,
//   at most once per kSavingsNs.
// - Spacing by search time. A better arm saves only a part of the search time. So the lane's total
//   work may be at most kMaxWorkRatio of the frame thread's total search time, plus kWorkAheadNs.
//   This rule delays a sweep by at most kMaxSpacingNs. The lane can be ahead or behind by at most
//   kWorkAheadNs of work. So long play in manual mode builds up no large allowance, and a scene
//   that keeps changing builds up no large debt. All times are wall-clock times; the time scale
//   does not apply.
//
// Deterministic and without side effects: time and costs are arguments. Not thread-safe. Times are
// ns of one clock that never goes back; its zero point does not matter.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sweepstake {

// The frames of a visit. On the first frame the structure is built. The next kShadowWarmUpFrames
// frames still include the extra cost of a new structure. The frames after that are measured.
inline constexpr uint32_t kShadowBurstFrames = 8;
inline constexpr uint32_t kShadowWarmUpFrames = 2;
// The first run after a pause is slower. So the lane runs this much of a sweep's first visit, in
// ns, twice and counts only the second run.
inline constexpr uint64_t kShadowWarmUpNs = 1'000'000;

struct ShadowScheduleOptions {
  double duty_ratio = 0.15;                      // share of one thread's time, (0, 1]
  uint64_t visit_cap_ns = 250'000'000;           // time cap of a visit
  uint64_t memory_cap_bytes = 64 * 1024 * 1024;  // cap of one arm's structure
  // Minimum time between two sweeps. More frequent ones would add no information, because decisions
  // are seconds apart.
  uint64_t sweep_interval_min_ns = 250'000'000;
};

// The cost of a visit to one arm.
struct ShadowVisit {
  uint32_t arm = 0;
  uint32_t frame_count = 0;   // number of measured frames
  uint64_t detection_ns = 0;  // median of the measured frames; without any, the fastest frame
  uint64_t build_ns = 0;      // time of the first frame
  uint64_t busy_ns = 0;       // total time of all frames
  uint64_t native_bytes = 0;
  uint64_t aabb_check_count = 0;  // mean over the measured frames
  bool capped = false;            // a cap ended the visit before the last frame
  // Whether detection_ns was measured. There are two reasons why not. Either the memory cap ended
  // the first frame (`capped`); detection_ns is then the time cap. Or another thread had the core
  // of the lane's thread, or the game was suspended; the arm's cost then stays unknown.
  bool is_measured = true;
};

// Computes a visit from the times of its frames. Ignores frames that begin after the earlier ones
// have taken `cap_ns`. The caller sets arm, native_bytes and aabb_check_count. REQUIRES: 1 to
// kShadowBurstFrames frames.
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
  // Returns the time from which the next sweep may begin, without regard to the limit by search
  // time. Returns 0 before the first sweep.
  uint64_t next_sweep_ns() const;

  // Begins a sweep. REQUIRES: active_arm < arm_count.
  void Begin(uint64_t now_ns, uint64_t search_ns, uint32_t active_arm, uint32_t object_count);
  // Returns the arm to visit next in this sweep, or nullopt if the sweep is complete.
  std::optional<uint32_t> NextArm() const;
  // Adds a finished visit. REQUIRES: visit.arm is NextArm().
  void OnVisit(const ShadowVisit& visit);
  // Adds work of the lane's thread that is not a visit.
  void Spend(uint64_t busy_ns) {
    busy_ns_ += busy_ns;
    matched_ns_ += static_cast<uint64_t>(static_cast<double>(busy_ns) / kMaxWorkRatio);
  }
  // Adds `cost_ns`, the time that the lane's work up to `now_ns` has cost the frame thread.
  void Charge(uint64_t now_ns, double cost_ns);

 private:
  struct Arm {
    uint64_t cost_ns = 0;       // from the latest visit; 0 before the first
    uint64_t reference_ns = 0;  // from the first visit since the latest Renew
    uint64_t last_sweep = 0;    // number of its latest sweep; 0 if none since Renew
    uint32_t back_off = 0;      // minimum sweeps between visits of an arm over a cap, else 0
    bool too_big = false;       // the structure exceeds the memory cap
  };

  void Renew(bool end_back_off);
  void GrantSavings();
  uint64_t BestCost() const;
  uint32_t ArmAt(uint32_t place) const;
  uint64_t Period(uint32_t arm, uint64_t best_ns) const;
  bool Due(uint32_t arm, uint64_t best_ns) const;

  const ShadowScheduleOptions options_;
  std::vector<Arm> arms_;
  uint64_t sweep_ = 0;  // number of the latest sweep
  uint64_t begun_ns_ = 0;
  uint64_t busy_ns_ = 0;  // work of the lane since the latest sweep began
  // No sweep begins before this time. That keeps the cost to the frame thread at most kMaxCostRatio
  // of the elapsed time.
  uint64_t paid_ns_ = 0;
  // The lane's work so far ÷ kMaxWorkRatio. While it exceeds the frame thread's total search time +
  // kWorkAheadNs ÷ kMaxWorkRatio, no sweep begins unless kMaxSpacingNs have passed.
  uint64_t matched_ns_ = 0;
  uint64_t granted_ns_ = 0;  // when GrantSavings last granted an allowance
  uint32_t active_arm_ = 0;
  uint64_t reference_count_ = 0;  // object count when all arms were last made due
};

}  // namespace sweepstake
