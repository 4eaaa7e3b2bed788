// How often somebody may do something: as many times a second as a rate says, and at once as many
// as in ten seconds. Times are of a steady clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>

namespace sweepstake::auth {

// One bucket. Not thread-safe.
class RateBucket {
 public:
  static constexpr int64_t kBurstNs = 10'000'000'000;

  // Returns whether it may be done now, and counts it if so. REQUIRES: per_s >= 1.
  bool Take(double per_s, int64_t now_ns);
  // Returns whether nothing is left of what was counted.
  bool full(int64_t now_ns) const { return due_ns_ <= now_ns; }

 private:
  // What was counted is paid off by then, at the rate.
  int64_t due_ns_ = std::numeric_limits<int64_t>::min();
};

// A bucket for each of many. Thread-safe. The memory is bounded by kMaxBuckets; beyond it the one
// that has not been used for the longest time is forgotten, which fills it.
class RateLimit {
 public:
  static constexpr size_t kMaxBuckets = 10'000;

  // As RateBucket::Take, of whoever has this name.
  bool Take(const std::string& name, double per_s, int64_t now_ns);

  size_t size() const;

 private:
  struct Entry {
    RateBucket bucket;
    std::list<std::string>::iterator place;
  };

  void Forget(int64_t now_ns);

  mutable std::mutex mutex_;  // guards what follows
  std::unordered_map<std::string, Entry> buckets_;
  std::list<std::string> uses_;  // names, the one that was used last at the end
};

}  // namespace sweepstake::auth
