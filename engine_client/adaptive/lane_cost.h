// What the shadow lane costs the frame thread: how much longer a search takes while the lane works,
// since the two share caches, memory, a core's execution units, or the only core that there is.
//
// Searches during the lane's work are compared with those since its work before, of the same arm,
// where there were as many. Means forget: the latest ten stretches of work count for most of it.
//
// Thread safety: Begin and End on the frame thread, which never wait, lock or allocate; the rest on
// the lane's. Times are ns.
#pragma once

#include <atomic>
#include <cstdint>

namespace sweepstake {

class LaneCost {
 public:
  // Before anything is measured. 2 cores of AMD Zen 4: 0 to 0.07, at 1,000 to 10,000 objects.
  static constexpr double kPriorSlowdown = 0.1;
  // The prior counts for as much as this time of searches beside the lane.
  static constexpr double kPriorNs = 2e6;
  // What is left of the weight of a stretch after the next one.
  static constexpr double kKept = 0.9;
  // A stretch tells at most so much, and as little: what else goes on in the machine must not keep
  // the lane from measuring for long.
  static constexpr double kMost = 0.5;

  // Before a search, for End.
  uint32_t Begin() const noexcept { return work_.load(std::memory_order_relaxed); }
  // After the search that took this time; an epoch has one arm.
  void End(uint32_t begun, uint64_t detection_ns, uint32_t epoch) noexcept;

  void BeginWork();
  // The work took `wall_ns` by the clock. Returns what it has cost the frame thread, by the
  // slowdown measured so far, even if no search fell into it.
  double EndWork(uint64_t wall_ns);
  // Time of the frame thread beside the lane ÷ without, minus 1; >= 0.
  double slowdown() const;
  // What all searches have taken, in ns. Any thread may ask.
  uint64_t search_ns() const { return alone_.sum().ns + beside_.sum().ns; }
  // What all work has cost the frame thread, in ns. Any thread may ask.
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

  std::atomic<uint32_t> work_{0};  // odd during work
  std::atomic<uint32_t> epoch_{0};
  Cell alone_;
  Cell beside_;
  // Written by the lane's thread.
  std::atomic<uint64_t> total_ns_{0};
  // Of the lane's thread.
  Searches alone_before_;   // up to the latest work's end
  Searches beside_before_;  // up to the present work's begin
  Searches alone_between_;  // from the latest work's end to the present one's begin
  uint32_t epoch_before_ = 0;
  double extra_ns_ = 0;
  double base_ns_ = 0;
};

}  // namespace sweepstake
