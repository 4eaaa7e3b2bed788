// Limits the rate of events to a number per second. A burst may have as many events as ten seconds
// of that rate. Times are those of a steady clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>

namespace sweepstake::auth {

// One token bucket. Not thread-safe.
class RateBucket {
 public:
  static constexpr int64_t kBurstNs = 10'000'000'000;

  // Returns whether the event is allowed now, and counts it if so. REQUIRES: per_s >= 1.
  bool Take(double per_s, int64_t now_ns);
  // Returns whether the bucket is full, so that it can be forgotten.
  bool full(int64_t now_ns) const { return due_ns_ <= now_ns; }

 private:
  // Time at which the bucket is full again.
  int64_t due_ns_ = std::numeric_limits<int64_t>::min();
};

// A bucket per name. Thread-safe. Memory is bounded by kMaxBuckets: above it the least recently
// used bucket is removed. If a removed name is used again, it gets a full bucket.
class RateLimit {
 public:
  static constexpr size_t kMaxBuckets = 10'000;

  // Like RateBucket::Take, for the bucket of `name`.
  bool Take(const std::string& name, double per_s, int64_t now_ns);

  size_t size() const;

 private:
  struct Entry {
    RateBucket bucket;
    std::list<std::string>::iterator place;
  };

  void Forget(int64_t now_ns);

  mutable std::mutex mutex_;  // guards the members below
  std::unordered_map<std::string, Entry> buckets_;
  std::list<std::string> uses_;  // names, the most recently used one at the end
};

}  // namespace sweepstake::auth
