#include "server/sessions/common/log_histogram.h"

#include <algorithm>
#include <array>
#include <bit>

namespace sweepstake::sessions {
namespace {

// 2^(63 + k/8) for k = 1 to 7, rounded up: the lower bounds of buckets 2 to 8 of an octave.
constexpr std::array<uint64_t, 7> kEighths = {
    0x8b95c1e3ea8bd6e7, 0x9837f0518db8a970, 0xa5fed6a9b15138eb, 0xb504f333f9de6485,
    0xc5672a115506dade, 0xd744fccad69d6af5, 0xeac0c6e7dd24392f};

}  // namespace

uint32_t LogHistogram::BucketOf(uint64_t value) {
  if (value == 0) return 0;
  const int leading_zeros = std::countl_zero(value);
  const uint64_t mantissa = value << leading_zeros;
  const auto eighth = std::count_if(kEighths.begin(), kEighths.end(),
                                    [mantissa](uint64_t start) { return mantissa >= start; });
  return 8 * static_cast<uint32_t>(63 - leading_zeros) + static_cast<uint32_t>(eighth) + 1;
}

void LogHistogram::Add(uint64_t value) {
  const uint32_t number = BucketOf(value);
  // Fast path: consecutive frames often fall into the same bucket.
  if (latest_ < buckets_.size() && buckets_[latest_].number == number) {
    ++buckets_[latest_].count;
    return;
  }
  auto place = std::lower_bound(
      buckets_.begin(), buckets_.end(), number,
      [](const Bucket& bucket, uint32_t wanted) { return bucket.number < wanted; });
  const bool known = place != buckets_.end() && place->number == number;
  if (!known && buckets_.size() < kMaxBuckets) {
    place = buckets_.insert(place, {number, 0});
  } else if (!known && place != buckets_.begin()) {
    // Merge the lowest bucket into the next one, to make room for the new bucket.
    buckets_[1].count += buckets_[0].count;
    --place;
    std::move(buckets_.begin() + 1, place + 1, buckets_.begin());
    *place = {number, 0};
  }
  ++place->count;
  latest_ = static_cast<size_t>(place - buckets_.begin());
}

}  // namespace sweepstake::sessions
