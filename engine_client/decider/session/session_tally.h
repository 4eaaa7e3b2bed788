// What a session ran: its frames per regime, for reports (policy/regime_report.h), and its latest
// switches. Decisions do not use it.
//
// Unlike the windows from which policies learn (arm_runs.h), it contains all measured frames, also
// those between the end of a regime and the switch that follows it. These are the frames in which
// the session pays for finding out.
//
// Not thread-safe. The memory is bounded by the numbers of regimes and arms.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "engine_client/decider/policy/policy.h"
#include "engine_client/decider/policy/regime_report.h"

namespace sweepstake::decision {

class SessionTally {
 public:
  static constexpr int64_t kLatelyNs = 60'000'000'000;

  explicit SessionTally(size_t arm_count)
      : total_{.arm_us = std::vector<double>(arm_count),
               .known_frame_counts = std::vector<uint64_t>(arm_count)} {}

  // Adds a measured frame. File adds the frames since the previous File to the present regime of
  // the policy. `policy` is needed in AddFrame because frames of another arm are filed first.
  void AddFrame(const FrameSample& frame, const Policy& policy);
  void File(const Policy& policy);
  void AddSwitchCost(const SwitchCost& cost, const Policy& policy);
  // Adds an executed switch.
  void AddSwitch(int64_t executed_ns);

  // The sums do not contain the frames since the previous File.
  std::span<const RegimeUse> uses() const { return uses_; }
  const RegimeUse& total() const { return total_; }
  // Returns the number of switches in the last kLatelyNs, at most kMaxSwitches.
  uint32_t RecentSwitchCount(int64_t now_ns) const;

 private:
  static constexpr size_t kMaxSwitches = 100;

  RegimeUse& UseOf(RegimeId id);

  uint32_t arm_ = 0;             // of frames_
  Window frames_;                // the frames that are not filed yet
  std::vector<RegimeUse> uses_;  // at most one per place of a regime
  RegimeUse total_;
  std::deque<int64_t> switches_ns_;  // the latest switches, ascending
};

}  // namespace sweepstake::decision
