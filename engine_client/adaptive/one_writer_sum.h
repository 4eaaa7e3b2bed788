// Addition to a sum that one thread writes and any thread reads.
#pragma once

#include <atomic>
#include <cstdint>

namespace sweepstake {

// Adds `amount` without a locked instruction. REQUIRES: no other thread writes `sum`.
inline void AddAsOnlyWriter(std::atomic<uint64_t>& sum, uint64_t amount) {
  sum.store(sum.load(std::memory_order_relaxed) + amount, std::memory_order_relaxed);
}

}  // namespace sweepstake
