// Decides which arms the shadow lane visits, and when: in sweeps over the arms, spaced by a budget.
//
//   if (schedule.IsDue(now_ns, search_ns)) {
//     schedule.Begin(now_ns, search_ns, active_arm, object_count);
//     while (const auto arm = schedule.NextArm()) schedule.OnVisit(/* its cost */);
//   }
//
// The first sweep is due at once and visits every arm. After that:
// - Sweeps begin and end with the active arm in turns, since the others are compared with it: every
//   second one is in the opposite order, so that of the arms in every sweep none has the better
//   place.
// - An arm within kContenderRatio of the cheapest known cost is in every sweep. An arm that costs r
//   times as much is in every r²-th sweep, so that it takes 1/r of a cheap arm's share of the
//   budget, but at least in every kMaxPeriod-th.
// - If the object count or the cost of the active arm has changed by more than kChangeRatio since
//   every arm was visited, the scene is a different one: the sweep visits every arm again.
// - An arm whose visit ends at the time cap is visited half as often each time, down to every
//   kMaxPeriod-th sweep, until a visit stays below the cap or the object count changes. The active
//   arm and arms within kContenderRatio are exempt. The same holds for an arm whose structure
//   exceeds the memory cap, without these exceptions.
// - Sweeps are spaced so that visits take duty_ratio of the time since the first one.
// - They are spaced further so that they cost the frame thread kMaxCostRatio of its time at most in
//   the long run (lane_cost.h). What was not spent in the last kSavingsNs may be spent at once, and
//   is granted anew where the scene is a different one, once in that time.
// - All work takes kMaxWorkRatio of what the frame thread's searches take at most, and kWorkAheadNs
//   besides, since a choice saves a part of these; but this holds a sweep back for kMaxSpacingNs at
//   most. Of what was not worked, or worked beyond that, no more than kWorkAheadNs is kept in mind:
//   long play in manual mode is no savings, nor is a scene that kept changing a debt. Both times
//   are the machine's, whatever the time scale.
//
// Pure and deterministic: time and costs come in as arguments. Not thread-safe. Times are ns of one
// clock, from any origin, that does not go back.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sweepstake {

// Frames of a visit: the structure is built on the first one; the next two still include the extra
// cost of a new structure; the others are measured.
inline constexpr uint32_t kShadowBurstFrames = 8;
inline constexpr uint32_t kShadowWarmUpFrames = 2;
// So long of a sweep's first visit, which follows a pause, the lane makes twice.
inline constexpr uint64_t kShadowWarmUpNs = 1'000'000;

struct ShadowScheduleOptions {
  double duty_ratio = 0.15;                      // the share of one thread's time, (0, 1]
  uint64_t visit_cap_ns = 250'000'000;           // a visit may end when it reaches it
  uint64_t memory_cap_bytes = 64 * 1024 * 1024;  // the cap of one arm's structure
  // Decisions are seconds apart, so that more frequent sweeps would add no information.
  uint64_t sweep_interval_min_ns = 250'000'000;
};

// The cost of a visit to one arm.
struct ShadowVisit {
  uint32_t arm = 0;
  uint32_t frame_count = 0;   // the number of measured frames
  uint64_t detection_ns = 0;  // the frames' median, or the fastest frame if none was measured
  uint64_t build_ns = 0;      // the time of the first frame
  uint64_t busy_ns = 0;       // the time of all frames
  uint64_t native_bytes = 0;
  uint64_t aabb_check_count = 0;  // the mean of the measured frames
  bool capped = false;            // whether a cap ended it before the last frame
  // Whether detection_ns is a cost. It is the time cap if the memory cap ended the first frame;
  // without a cap, the lane was kept from its core, and nothing is known.
  bool is_measured = true;
};

// Returns the visit whose frames took `frame_ns`, up to `cap_ns`. The caller sets arm, native_bytes
// and aabb_check_count. REQUIRES: 1 to kShadowBurstFrames frames.
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

  // Returns whether a sweep may begin after searches of the frame thread that took `search_ns`
  // altogether.
  bool IsDue(uint64_t now_ns, uint64_t search_ns) const;
  // Returns when the next sweep may begin, however long the searches take; 0 before the first one.
  uint64_t next_sweep_ns() const;

  // Begins a sweep. REQUIRES: active_arm < arm_count.
  void Begin(uint64_t now_ns, uint64_t search_ns, uint32_t active_arm, uint32_t object_count);
  // Returns the arm to visit next in this sweep; it is absent if the sweep is complete.
  std::optional<uint32_t> NextArm() const;
  // REQUIRES: visit.arm is NextArm().
  void OnVisit(const ShadowVisit& visit);
  // Adds other work of the visiting thread to the sweep's cost.
  void Spend(uint64_t busy_ns) {
    busy_ns_ += busy_ns;
    matched_ns_ += static_cast<uint64_t>(static_cast<double>(busy_ns) / kMaxWorkRatio);
  }
  // Adds what the work up to `now_ns` has cost the frame thread.
  void Charge(uint64_t now_ns, double cost_ns);

 private:
  struct Arm {
    uint64_t cost_ns = 0;       // the cost of the latest visit; 0 before one
    uint64_t reference_ns = 0;  // the cost of the first visit since the latest Renew
    uint64_t last_sweep = 0;    // the sweep of the latest visit; 0 if none since the latest Renew
    uint32_t back_off = 0;      // the sweeps between visits; 0 if not over a cap
    bool too_big = false;       // whether the structure exceeds the memory cap
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
  uint64_t busy_ns_ = 0;     // the lane's time since the latest sweep began
  uint64_t paid_ns_ = 0;     // when the frame thread's cost will have been in proportion
  uint64_t matched_ns_ = 0;  // searches that take so long allow for all work
  uint64_t granted_ns_ = 0;
  uint32_t active_arm_ = 0;
  uint64_t reference_count_ = 0;  // the object count at the latest Renew
};

}  // namespace sweepstake
