// Finds frames during which the system stopped the whole process: SIGSTOP, a breakpoint, a paused
// virtual machine, a frozen container, a sleeping laptop. Wall-clock time passes, but nothing is
// computed. The frame's times are therefore not the cost of its arm.
//
// A stop is recognised by the CPU time. Three rules:
// - Suspicion. Only a search of at least kSuspiciousSearchNs and a frame of at least
//   kSuspiciousFrameNs are examined.
// - Share. The search or frame was suspended if the CPU time is less than 1/kComputedShare of the
//   wall-clock time. For a search this is the CPU time of the frame thread. If an executor runs
//   parts of the search, and for a whole frame, it is the CPU time of the process, because the
//   frame thread may wait for threads that compute. So a frame in which
//   the arm computes for long never counts as suspended. Neither does a frame of a machine with
//   fewer than kComputedShare busy threads per core, which slows down all arms alike.
// - Series. At most kMaxInARow frames in a row count as suspended. A longer series has another
//   cause: the game gets little CPU time, or it waits for events. It must not end the learning.
//
// Reading CPU times takes a system call. They are read when a search begins, but at most every
// kBaselineNs, and after a suspicious search or frame. CPU time between the reading and the search
// counts as part of the search. It can hide a stop of less than kComputedShare · kBaselineNs, times
// the number of busy threads if the CPU time is that of the process. It cannot hide the cost of an
// arm.
//
// Cost: two comparisons per search, one per frame, and 0.8 µs per reading (two cores of AMD EPYC,
// Linux). Frame thread only. Times are ns. The clock is borrowed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {

class SuspensionGuard {
 public:
  static constexpr uint64_t kBaselineNs = 50'000'000;
  static constexpr uint64_t kSuspiciousSearchNs = 100'000'000;
  static constexpr uint64_t kSuspiciousFrameNs = 1'000'000'000;
  static constexpr uint64_t kComputedShare = 8;
  static constexpr uint32_t kMaxInARow = 8;

  // `parallel`: other threads run parts of the searches.
  SuspensionGuard(Clock& clock, bool parallel) : clock_(clock), parallel_(parallel) {}

  // Returns whether work of `wall_ns` that computed for `computed_ns` was suspended.
  static bool IsSuspended(uint64_t wall_ns, uint64_t computed_ns) {
    return wall_ns >= kSuspiciousSearchNs && computed_ns < wall_ns / kComputedShare;
  }

  // Call before a search. Returns the time of the clock at which the search begins.
  uint64_t BeginSearch() {
    const uint64_t now_ns = clock_.NowNs();
    if (now_ns < next_reading_ns_) return now_ns;
    Read(now_ns);
    return baseline_.is_known() ? clock_.NowNs() : now_ns;
  }

  // Call after a search with the result of BeginSearch. Returns whether the search was suspended.
  bool EndSearch(uint64_t begin_ns, uint64_t detection_ns) {
    if (detection_ns < kSuspiciousSearchNs || !baseline_.is_known()) return false;
    const Times computed = Rebase(begin_ns + detection_ns, baseline_);
    const bool is_suspended =
        IsSuspended(detection_ns, parallel_ ? computed.process_ns : computed.thread_ns);
    search_suspended_ = search_suspended_ || is_suspended;
    return is_suspended;
  }

  // Call at the end of a frame. Returns whether it was suspended. A paused or loading frame is not
  // examined, because it counts as no cost anyway.
  bool EndFrame(const FrameEnd& frame) {
    const bool is_examined = (frame.flags & (kFramePaused | kFrameLoading)) == 0;
    const bool looks_suspended =
        is_examined && (search_suspended_ || LooksSuspended(frame.frame_time_ns));
    search_suspended_ = false;
    frame_baseline_ = baseline_;
    if (!looks_suspended) {
      in_a_row_ = 0;
      return false;
    }
    in_a_row_ = std::min(in_a_row_ + 1, kMaxInARow + 1);
    return in_a_row_ <= kMaxInARow;
  }

 private:
  struct Times {
    uint64_t wall_ns = 0;
    uint64_t thread_ns = 0;
    uint64_t process_ns = 0;

    bool is_known() const { return thread_ns > 0 && process_ns > 0; }
  };

  void Read(uint64_t now_ns) {
    baseline_ = {
        .wall_ns = now_ns, .thread_ns = clock_.ThreadCpuNs(), .process_ns = clock_.ProcessCpuNs()};
    next_reading_ns_ = now_ns + kBaselineNs;
  }

  // Replaces the baseline. Returns the times that passed since `before`.
  Times Rebase(uint64_t now_ns, Times before) {
    Read(now_ns);
    return {.wall_ns = now_ns - before.wall_ns,
            .thread_ns = baseline_.thread_ns - std::min(before.thread_ns, baseline_.thread_ns),
            .process_ns = baseline_.process_ns - std::min(before.process_ns, baseline_.process_ns)};
  }

  // Returns whether the frame was suspended between its searches. An engine may report a frame time
  // that is longer than the time that passed; such a frame was not suspended.
  bool LooksSuspended(uint64_t frame_time_ns) {
    if (frame_time_ns < kSuspiciousFrameNs || !frame_baseline_.is_known()) return false;
    const Times computed = Rebase(clock_.NowNs(), frame_baseline_);
    return IsSuspended(frame_time_ns, computed.process_ns) &&
           computed.wall_ns >= frame_time_ns - frame_time_ns / kComputedShare;
  }

  Clock& clock_;
  const bool parallel_;
  Times baseline_;                 // the latest reading; zeros before the first
  Times frame_baseline_;           // the latest reading before the current frame
  uint64_t next_reading_ns_ = 0;   // no search reads the CPU times before
  bool search_suspended_ = false;  // a search of this frame was suspended
  uint32_t in_a_row_ = 0;          // frames in a row that looked suspended
};

}  // namespace sweepstake
