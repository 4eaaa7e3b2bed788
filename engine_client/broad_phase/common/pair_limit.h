// Ends a search that finds more than a number of pairs. Thread-safe, without locks.
#pragma once

#include <atomic>
#include <cstdint>

#include "sweepstake/broad_phase.h"

namespace sweepstake {

// Also ends the search if another request ends it. `other` may be null; borrowed.
class PairLimit final : public StopRequest {
 public:
  PairLimit(StopRequest* other, uint64_t max_pairs) : other_(other), max_pairs_(max_pairs) {}

  bool WantsStop(uint64_t grown_bytes, uint64_t found_pairs) noexcept override {
    Count(found_pairs);
    const bool other_wants = other_ != nullptr && other_->WantsStop(grown_bytes, found_pairs);
    return other_wants || is_exceeded();
  }
  void OnEnd(uint64_t grown_bytes, uint64_t found_pairs) noexcept override {
    Count(found_pairs);
    if (other_ != nullptr) other_->OnEnd(grown_bytes, found_pairs);
  }
  bool is_exceeded() const { return found_.load(std::memory_order_relaxed) > max_pairs_; }

 private:
  void Count(uint64_t found_pairs) {
    if (found_pairs > 0) found_.fetch_add(found_pairs, std::memory_order_relaxed);
  }

  StopRequest* const other_;
  const uint64_t max_pairs_;
  std::atomic<uint64_t> found_{0};
};

}  // namespace sweepstake
