// Stops a search of a trial after a time (SwitchCommand::trial_limit_percent).
//
// Time in which another thread has the core does not count, because it is not the arm's cost. The
// CPU time of the frame thread shows it. It is read when a search begins and when a search is over
// its time. If an executor runs parts of the searches, or the system's CPU times are coarse, all of
// the time counts.
//
// Thread safety: WantsStop may be called on the threads of the executor, during the search only.
// The other functions are called on the frame thread, outside of the search. Cost: one reading of
// the clock per poll, and about 1 µs per search. The clock is borrowed. Times are ns.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake {

class TrialStop final : public StopRequest {
 public:
  // `reads_cpu`: one thread runs the searches, and Clock::ThreadCpuNs is precise.
  TrialStop(Clock& clock, bool reads_cpu) : clock_(clock), reads_cpu_(reads_cpu) {}

  // Call when a search begins, at the time `begin_ns` of the clock. It may take `allowed_ns`.
  void Begin(uint64_t begin_ns, uint64_t allowed_ns) {
    begin_ns_ = begin_ns;
    allowed_ns_ = allowed_ns;
    cpu_begin_ns_ = reads_cpu_ ? clock_.ThreadCpuNs() : 0;
    has_stopped_.store(false, std::memory_order_relaxed);
  }

  bool WantsStop(uint64_t /*grown_bytes*/, uint64_t /*found_pairs*/) noexcept override {
    if (has_stopped()) return true;
    if (ComputedNs(clock_.NowNs()) <= allowed_ns_) return false;
    has_stopped_.store(true, std::memory_order_relaxed);
    return true;
  }
  void OnEnd(uint64_t /*grown_bytes*/, uint64_t /*found_pairs*/) noexcept override {}

  // Returns whether the search was stopped, so that its result is incomplete.
  bool has_stopped() const { return has_stopped_.load(std::memory_order_relaxed); }

  // Returns the time from Begin to `now_ns`, without the time in which another thread had the core.
  // Excludes that time only if the search exceeds allowed_ns_.
  uint64_t ComputedNs(uint64_t now_ns) const {
    const uint64_t passed_ns = now_ns - begin_ns_;
    if (passed_ns <= allowed_ns_ || cpu_begin_ns_ == 0) return passed_ns;
    return std::min(passed_ns, clock_.ThreadCpuNs() - cpu_begin_ns_);
  }

 private:
  Clock& clock_;
  const bool reads_cpu_;
  uint64_t begin_ns_ = 0;
  uint64_t allowed_ns_ = 0;
  uint64_t cpu_begin_ns_ = 0;  // 0: unknown
  std::atomic<bool> has_stopped_{false};
};

}  // namespace sweepstake
