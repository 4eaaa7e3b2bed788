#include <chrono>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {
namespace {

class ChronoSteadyClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override {
    const auto since_origin = std::chrono::steady_clock::now().time_since_epoch();
    return static_cast<uint64_t>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(since_origin).count());
  }
};

}  // namespace

Clock& SteadyClock() {
  static ChronoSteadyClock clock;  // Stateless: sharing it shares nothing.
  return clock;
}

}  // namespace sweepstake
