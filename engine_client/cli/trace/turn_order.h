// Who runs when in a frame of a trace: an order drawn anew each time, in which the last contestant,
// the A/A control, and its twin are never neighbours, so that neither finds the caches as the other
// left them.
//
// Deterministic by seed. Not thread-safe. A draw costs some nanoseconds per contestant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine_client/scene/random.h"

namespace sweepstake::cli {

class TurnOrder {
 public:
  // REQUIRES: twin < contestant_count - 1.
  TurnOrder(size_t contestant_count, size_t twin, uint64_t seed);

  // All contestants; valid until the next call. The last one of the order before counts as the
  // neighbour of the first one. Two contestants cannot be kept apart.
  const std::vector<size_t>& Next();

 private:
  void Shuffle();
  bool HasTwinsTogether(size_t before) const;
  bool AreTwins(size_t a, size_t b) const;

  std::vector<size_t> order_;
  size_t twin_;
  SequentialRandom random_;
};

}  // namespace sweepstake::cli
