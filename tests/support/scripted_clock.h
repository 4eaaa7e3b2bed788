// A clock that advances only when the test advances it. CPU times are unknown until ReportCpu.
#pragma once

#include <cstdint>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake::test_support {

inline constexpr uint64_t kMs = 1'000'000;  // in nanoseconds

class ScriptedClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override {
    ++reading_count_;
    return now_ns_ += reading_ns_;
  }
  uint64_t ThreadCpuNs() noexcept override { return reports_cpu_ ? thread_ns_ : 0; }
  uint64_t ProcessCpuNs() noexcept override { return reports_cpu_ ? process_ns_ : 0; }

  // The calling thread works.
  void Advance(uint64_t duration_ns) {
    AdvanceWaiting(duration_ns, duration_ns);
    thread_ns_ += duration_ns;
  }
  // The calling thread waits while the other threads work for `process_ns` in total. If they do not
  // work either, the process may as well be stopped.
  void AdvanceWaiting(uint64_t duration_ns, uint64_t process_ns = 0) {
    now_ns_ += duration_ns;
    process_ns_ += process_ns;
  }
  void ReportCpu() { reports_cpu_ = true; }
  // Sets the time by which each reading advances the clock from now on.
  void SetReading(uint64_t duration_ns) { reading_ns_ = duration_ns; }
  uint64_t reading_count() const { return reading_count_; }

 private:
  uint64_t now_ns_ = 0;
  uint64_t thread_ns_ = 1;
  uint64_t process_ns_ = 1;
  bool reports_cpu_ = false;
  uint64_t reading_ns_ = 0;
  uint64_t reading_count_ = 0;
};

}  // namespace sweepstake::test_support
