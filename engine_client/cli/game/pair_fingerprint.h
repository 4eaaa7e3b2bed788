// What a set of pairs comes down to when it is compared with another by identity: the same pairs in
// any order give the same fingerprint, and any other pairs another one, by all likelihood (two
// 64-bit sums of hashes). So that every frame of every contestant is judged at 1 ns per pair,
// where sorting would take a hundred times as long.
//
// Pure, safe from any thread.
#pragma once

#include <cstdint>
#include <span>

#include "sweepstake/aabb.h"

namespace sweepstake::cli {

struct PairFingerprint {
  uint64_t count = 0;
  uint64_t sums[2] = {0, 0};

  friend bool operator==(const PairFingerprint&, const PairFingerprint&) = default;
};

// A pair found twice counts twice, one the wrong way round is another pair.
PairFingerprint FingerprintOf(std::span<const OverlapPair> pairs);

}  // namespace sweepstake::cli
