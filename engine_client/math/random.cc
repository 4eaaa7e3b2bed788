#include "engine_client/math/random.h"

#include <algorithm>
#include <cassert>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr uint32_t kMultiplier0 = 0xD2511F53;
constexpr uint32_t kMultiplier1 = 0xCD9E8D57;
constexpr uint32_t kWeyl0 = 0x9E3779B9;
constexpr uint32_t kWeyl1 = 0xBB67AE85;

uint32_t High(uint64_t value) { return static_cast<uint32_t>(value >> 32); }
uint32_t Low(uint64_t value) { return static_cast<uint32_t>(value); }

PhiloxBlock Round(const PhiloxBlock& c, const PhiloxKey& k) {
  const uint64_t product0 = uint64_t{kMultiplier0} * c[0];
  const uint64_t product1 = uint64_t{kMultiplier1} * c[2];
  return {High(product1) ^ c[1] ^ k[0], Low(product1), High(product0) ^ c[3] ^ k[1], Low(product0)};
}

constexpr double kMinGammaShape = 1e-300;
constexpr double kMaxGammaShape = 1e300;

// Returns the logarithm of a Gamma(shape, 1) draw. REQUIRES: shape >= 1.
double DrawLogGammaFromOne(double shape, RandomStream& stream) {
  const double d = shape - 1.0 / 3.0;
  const double c = 1 / std::sqrt(9 * d);
  for (;;) {
    const double x = DrawNormal(stream);
    const double root = 1 + c * x;
    if (root <= 0) continue;
    const double v = root * root * root;
    const double u = stream.NextUniform();
    const double log_v = math::Log(v);
    if (math::Log(u) < 0.5 * x * x + d * (1 - v + log_v)) return math::Log(d) + log_v;
  }
}

}  // namespace

PhiloxBlock Philox4x32(PhiloxBlock counter, PhiloxKey key) {
  for (int round = 0; round < 10; ++round) {
    counter = Round(counter, key);
    key[0] += kWeyl0;
    key[1] += kWeyl1;
  }
  return counter;
}

RandomStream::RandomStream(uint64_t seed, RandomPurpose purpose, uint64_t decision_id,
                           uint32_t index)
    : key_{Low(seed), High(seed)},
      counter_{0, (static_cast<uint32_t>(purpose) << 16) | index, Low(decision_id),
               High(decision_id)} {
  assert(index < (1u << 16));
}

uint64_t RandomStream::NextBits() {
  if (used_words_ == 4) {
    block_ = Philox4x32(counter_, key_);
    ++counter_[0];
    used_words_ = 0;
  }
  const uint64_t bits = (uint64_t{block_[used_words_ + 1]} << 32) | block_[used_words_];
  used_words_ += 2;
  return bits;
}

double RandomStream::NextUniform() {
  return (static_cast<double>(NextBits() >> 12) + 0.5) * 0x1p-52;
}

uint32_t RandomStream::NextBelow(uint32_t bound) {
  assert(bound > 0);
  // Values at or above the limit are rejected, because they would favour the first results.
  const uint64_t limit = (uint64_t{1} << 32) / bound * bound;
  uint64_t value = limit;
  while (value >= limit) value = NextBits() >> 32;
  return static_cast<uint32_t>(value % bound);
}

double DrawNormal(RandomStream& stream) {
  for (;;) {
    const double u = 2 * stream.NextUniform() - 1;
    const double v = 2 * stream.NextUniform() - 1;
    const double s = u * u + v * v;
    if (s > 0 && s < 1) return u * std::sqrt(-2 * math::Log(s) / s);
  }
}

double DrawLogGamma(double shape, RandomStream& stream) {
  // With an infinite or undefined shape the loop of the draw would never end.
  assert(shape == shape);
  if (!(shape <= kMaxGammaShape)) shape = kMaxGammaShape;
  if (shape >= 1) return DrawLogGammaFromOne(shape, stream);
  // Gamma(a) = Gamma(a + 1) · U^(1/a).
  const double a = std::max(shape, kMinGammaShape);
  const double log_boosted = DrawLogGammaFromOne(a + 1, stream);
  return log_boosted + math::Log(stream.NextUniform()) / a;
}

double DrawBeta(const BetaPosterior& posterior, RandomStream& stream) {
  const double log_x = DrawLogGamma(posterior.alpha, stream);
  const double log_y = DrawLogGamma(posterior.beta, stream);
  return 1 / (1 + math::Exp(log_y - log_x));
}

}  // namespace sweepstake::decision
