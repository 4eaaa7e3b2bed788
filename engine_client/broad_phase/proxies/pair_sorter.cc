#include "sweepstake/pair_sorter.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/proxies/pair_events.h"

namespace sweepstake {
namespace {

constexpr uint32_t kDigitBits = 11;
constexpr size_t kBuckets = size_t{1} << kDigitBits;
constexpr size_t kDigits = 6;  // three digits of b, then three of a
// The minimum number of pairs for a radix sort. For fewer, std::sort is faster.
constexpr size_t kMinRadixPairs = 128;

using Starts = std::array<uint32_t, kBuckets>;

// Returns one digit of a pair. The digits of an id have 11, 11 and 10 bits.
template <size_t kDigit>
uint32_t DigitOf(const OverlapPair& pair) {
  const uint32_t id = kDigit < 3 ? pair.b : pair.a;
  return id >> (kDigit % 3 * kDigitBits) & (kBuckets - 1);
}

// Returns the bits that are not the same in all pairs.
OverlapPair Differences(std::span<const OverlapPair> pairs) {
  const OverlapPair first = pairs[0];
  OverlapPair bits{0, 0};
  for (const OverlapPair& pair : pairs) {
    bits.a |= pair.a ^ first.a;
    bits.b |= pair.b ^ first.b;
  }
  return bits;
}

template <size_t kDigit>
void Scatter(std::span<const OverlapPair> from, OverlapPair* to, Starts& starts) {
  starts.fill(0);
  for (const OverlapPair& pair : from) ++starts[DigitOf<kDigit>(pair)];
  uint32_t sum = 0;
  for (uint32_t& start : starts) {
    const uint32_t count = start;
    start = sum;
    sum += count;
  }
  for (const OverlapPair& pair : from) to[starts[DigitOf<kDigit>(pair)]++] = pair;
}

}  // namespace

struct PairSorter::Scratch {
  AlignedBuffer<OverlapPair> pairs;
  Starts starts;
};

PairSorter::PairSorter() : scratch_(std::make_unique<Scratch>()) {}
PairSorter::~PairSorter() = default;
PairSorter::PairSorter(PairSorter&&) noexcept = default;
PairSorter& PairSorter::operator=(PairSorter&&) noexcept = default;

void PairSorter::Sort(std::span<OverlapPair> pairs) {
  if (pairs.size() < kMinRadixPairs) {
    std::sort(pairs.begin(), pairs.end(), [](const OverlapPair& left, const OverlapPair& right) {
      return PairKey(left) < PairKey(right);
    });
    return;
  }
  scratch_->pairs.EnsureDiscarding(pairs.size());
  OverlapPair* from = pairs.data();
  OverlapPair* to = scratch_->pairs.data();
  const OverlapPair differences = Differences(pairs);
  // Skips digits that are the same in all pairs.
  const auto pass = [&]<size_t kDigit>() {
    if (DigitOf<kDigit>(differences) == 0) return;
    Scatter<kDigit>({from, pairs.size()}, to, scratch_->starts);
    std::swap(from, to);
  };
  [&]<size_t... kDigit>(std::index_sequence<kDigit...>) {
    (pass.template operator()<kDigit>(), ...);
  }
  (std::make_index_sequence<kDigits>());
  if (from != pairs.data()) std::copy_n(from, pairs.size(), pairs.data());
}

size_t PairSorter::native_bytes() const {
  return sizeof(Scratch) + scratch_->pairs.capacity_bytes();
}

}  // namespace sweepstake
