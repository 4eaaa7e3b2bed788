// Measures by how much the shadow lane slows down the frame thread. A search takes longer while the
// lane works, because both share caches, memory bandwidth, the execution units of a core, or the
// only core.
//
// A stretch is a period in which the lane works without a break. The searches during a stretch are
// compared with the searches between the previous stretch and this one. The comparison needs the
// same active arm throughout, and at least as many searches without the lane as with it. Means
// decay exponentially: the latest ten stretches have most of the weight.
//
// Thread safety: Begin and End on the frame thread, where they never wait, lock or allocate; the
// other functions on the lane's thread unless stated. Times are ns.
#pragma once

#include <atomic>
#include <cstdint>

namespace sweepstake {

class LaneCost {
 public:
  // The slowdown assumed before anything is measured. Measured values are 0 to 0.07, on 2 cores of
  // AMD Zen 4 with 1,000 to 10,000 objects.
  static constexpr double kPriorSlowdown = 0.1;
  // Weight of kPriorSlowdown: the search time during lane work, in ns, that it counts as.
  static constexpr double kPriorNs = 2e6;
  // Each new stretch multiplies the weight of all earlier ones by this factor.
  static constexpr double kKept = 0.9;
  // The slowdown measured in one stretch is clamped to ±kMost. Otherwise other load on the machine
  // could stop the lane for a long time.
  static constexpr double kMost = 0.5;

  // Call before a search. Pass the result to End.
  uint32_t Begin() const noexcept { return work_.load(std::memory_order_relaxed); }
  // Call after the search with the time that it took. `epoch` is a number that changes whenever the
  // active arm changes.
  void End(uint32_t begun, uint64_t detection_ns, uint32_t epoch) noexcept;

  // Call when a stretch of the lane's work begins.
  void BeginWork();
  // Call when a stretch ends, with its wall-clock time. Returns the estimated extra time of the
  // frame thread, wall_ns · slowdown(), whether or not a search ran during the stretch.
  double EndWork(uint64_t wall_ns);
  // Search time during lane work ÷ search time without it, minus 1; >= 0.
  double slowdown() const;
  // Total time of all searches so far, in ns. Any thread.
  uint64_t search_ns() const { return alone_.sum().ns + beside_.sum().ns; }
  // Total estimated extra time of the frame thread because of the lane, in ns. Any thread.
  uint64_t total_ns() const { return total_ns_.load(std::memory_order_relaxed); }

 private:
  struct Searches {
    uint64_t count = 0;
    uint64_t ns = 0;
    friend Searches operator-(const Searches& a, const Searches& b) {
      return {a.count - b.count, a.ns - b.ns};
    }
  };
  // Sums of searches, written by the frame thread.
  struct Cell {
    std::atomic<uint64_t> count{0};
    std::atomic<uint64_t> ns{0};
    Searches sum() const {
      return {count.load(std::memory_order_relaxed), ns.load(std::memory_order_relaxed)};
    }
  };

  std::atomic<uint32_t> work_{0};  // odd while the lane works
  std::atomic<uint32_t> epoch_{0};
  Cell alone_;
  Cell beside_;
  // Written by the lane's thread.
  std::atomic<uint64_t> total_ns_{0};
  // Used by the lane's thread only.
  Searches alone_before_;   // alone_ at the end of the latest stretch
  Searches beside_before_;  // beside_ at the start of the current stretch
  Searches alone_between_;  // between the latest stretch and the current one
  uint32_t epoch_before_ = 0;
  double extra_ns_ = 0;
  double base_ns_ = 0;
};

}  // namespace sweepstake
