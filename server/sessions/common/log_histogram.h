// A histogram of values with logarithmic buckets, eight per octave (factor of two). A percentile
// derived from it differs from the exact one by at most 4.5 %. Histograms are merged by adding the
// counts of equal buckets.
//
// Buckets are computed in integers, so that a value has the same bucket on every machine. Not
// thread-safe. The memory is bounded by kMaxBuckets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sweepstake::sessions {

class LogHistogram {
 public:
  // Maximum number of non-empty buckets: eight octaves, a far larger range than the frames of a
  // game have. If the values need more buckets, the smallest values share the lowest bucket, so
  // that the high percentiles stay correct.
  static constexpr size_t kMaxBuckets = 64;

  struct Bucket {
    uint32_t number = 0;
    uint32_t count = 0;
  };

  // Bucket 0 holds the zeros, bucket n the whole numbers from 2^((n−1)/8) to below 2^(n/8).
  static uint32_t BucketOf(uint64_t value);

  void Add(uint64_t value);
  void Clear() {
    buckets_.clear();
    latest_ = 0;
  }
  bool empty() const { return buckets_.empty(); }
  // The non-empty buckets, in ascending order.
  std::span<const Bucket> buckets() const { return buckets_; }

 private:
  std::vector<Bucket> buckets_;
  size_t latest_ = 0;  // index of the bucket of the latest value, if there is one
};

// The cost of frames: times in ns, memory in bytes.
struct FrameHistograms {
  LogHistogram frame_time_ns;
  LogHistogram detection_time_ns;
  LogHistogram native_bytes;

  void Add(uint64_t frame_ns, uint64_t detection_ns, uint64_t bytes) {
    frame_time_ns.Add(frame_ns);
    detection_time_ns.Add(detection_ns);
    native_bytes.Add(bytes);
  }
  bool empty() const { return frame_time_ns.empty(); }
  void Clear() {
    frame_time_ns.Clear();
    detection_time_ns.Clear();
    native_bytes.Clear();
  }
};

}  // namespace sweepstake::sessions
