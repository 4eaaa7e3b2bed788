// Measures how much the shadow lane slows the frame thread down. A search takes longer while the
// lane works, because both share caches, memory bandwidth, a core's execution units, or the only
// core.
//
// Searches during one stretch of the lane's work are compared with the searches since the previous
// stretch. The comparison needs the same arm throughout and at least as many searches without the
// lane. Means decay exponentially: the latest ten stretches have most of the weight.
//
// Thread safety: Begin and End on the frame thread, which never wait, lock or allocate; the rest on
// the lane's thread. Times are ns.
#pragma once

#include <atomic>
#include <cstdint>

namespace sweepstake {

class LaneCost {
 public:
  // The slowdown assumed before anything is measured. Measured on 2 cores of AMD Zen 4 with 1,000
  // to 10,000 objects: 0 to 0.07.
  static constexpr double kPriorSlowdown = 0.1;
  // The weight of the prior slowdown, as ns of searches during lane work.
  static constexpr double kPriorNs = 2e6;
  // The factor by which each new stretch of work reduces the weight of the earlier ones.
  static constexpr double kKept = 0.9;
  // Clamps the slowdown measured in one stretch to ±kMost, so that other load on the machine cannot
  // stop the lane from measuring for long.
  static constexpr double kMost = 0.5;

  // Call before a search, and pass the result to End.
  uint32_t Begin() const noexcept { return work_.load(std::memory_order_relaxed); }
  // Call after the search, with the time it took. `epoch` changes whenever the active arm changes.
  void End(uint32_t begun, uint64_t detection_ns, uint32_t epoch) noexcept;

  // Marks the start of a stretch of the lane's work.
  void BeginWork();
  // Ends a stretch that took `wall_ns` of wall-clock time. Returns the estimated extra time of the
  // frame thread: wall_ns · slowdown(), even if no search ran during the stretch.
  double EndWork(uint64_t wall_ns);
  // Search time during lane work ÷ search time without it, minus 1; >= 0.
  double slowdown() const;
  // Total time of all searches, in ns. Any thread.
  uint64_t search_ns() const { return alone_.sum().ns + beside_.sum().ns; }
  // Total estimated cost to the frame thread of all lane work, in ns. Any thread.
  uint64_t total_ns() const { return total_ns_.load(std::memory_order_relaxed); }

 private:
  struct Searches {
    uint64_t count = 0;
    uint64_t ns = 0;
    friend Searches operator-(const Searches& a, const Searches& b) {
      return {a.count - b.count, a.ns - b.ns};
    }
  };
  // Written by the frame thread.
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
  Searches alone_before_;   // searches up to the end of the latest work
  Searches beside_before_;  // searches up to the start of the current work
  Searches alone_between_;  // searches between the latest work and the current one
  uint32_t epoch_before_ = 0;
  double extra_ns_ = 0;
  double base_ns_ = 0;
};

}  // namespace sweepstake
