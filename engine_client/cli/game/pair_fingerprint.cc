#include "engine_client/cli/game/pair_fingerprint.h"

namespace sweepstake::cli {
namespace {

// The finalizer of splitmix64: every bit of the key reaches every bit of the hash.
uint64_t Mix(uint64_t key) {
  key = (key ^ (key >> 30)) * 0xBF58476D1CE4E5B9U;
  key = (key ^ (key >> 27)) * 0x94D049BB133111EBU;
  return key ^ (key >> 31);
}

}  // namespace

PairFingerprint FingerprintOf(std::span<const OverlapPair> pairs) {
  PairFingerprint fingerprint;
  fingerprint.count = pairs.size();
  for (const OverlapPair& pair : pairs) {
    const uint64_t key = uint64_t{pair.a} << 32 | pair.b;
    fingerprint.sums[0] += Mix(key + 0x9E3779B97F4A7C15U);
    fingerprint.sums[1] += Mix(~key);
  }
  return fingerprint;
}

}  // namespace sweepstake::cli
