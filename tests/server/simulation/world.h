// Virtual time, the queue of events, and the random numbers. A run has one thread, and is the same
// for the same seed.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <utility>

#include "server/sessions/common/decision_loop.h"

namespace sweepstake::simulation {

inline constexpr int64_t kMsNs = 1'000'000;
inline constexpr int64_t kSecondNs = 1'000 * kMsNs;

class World final : public sessions::LoopClock {
 public:
  explicit World(uint64_t seed) : random_(seed) {}

  int64_t NowNs() const override { return now_ns_; }
  // Does nothing: the owner runs the daemon's loop, which therefore never waits.
  void WaitUntil(int64_t /*deadline_ns*/) override {}
  void Wake() override {}

  void After(int64_t delay_ns, std::function<void()> event) {
    events_.emplace(now_ns_ + delay_ns, std::move(event));
  }
  // Advances to the earliest event, and runs it. Events of the same time run in the order of
  // queueing. REQUIRES: there is an event.
  void RunNext() {
    auto next = events_.extract(events_.begin());
    now_ns_ = next.key();
    next.mapped()();
  }

  // Draw, Happens and Bits use uniform random numbers.
  int64_t Draw(int64_t min, int64_t max) {
    return min + static_cast<int64_t>(random_() % static_cast<uint64_t>(max - min + 1));
  }
  bool Happens(double ratio) { return static_cast<double>(random_() >> 11) * 0x1p-53 < ratio; }
  uint64_t Bits() { return random_(); }

 private:
  int64_t now_ns_ = kSecondNs;
  std::multimap<int64_t, std::function<void()>> events_;
  std::mt19937_64 random_;
};

}  // namespace sweepstake::simulation
