#include "engine_client/cli/game/pair_fingerprint.h"

#include "server/decision/math/hash.h"

namespace sweepstake::cli {

PairFingerprint FingerprintOf(std::span<const OverlapPair> pairs) {
  PairFingerprint fingerprint;
  fingerprint.count = pairs.size();
  for (const OverlapPair& pair : pairs) {
    const uint64_t key = uint64_t{pair.a} << 32 | pair.b;
    fingerprint.sums[0] += math::Mix64(key + math::kGoldenGamma);
    fingerprint.sums[1] += math::Mix64(~key);
  }
  return fingerprint;
}

}  // namespace sweepstake::cli
