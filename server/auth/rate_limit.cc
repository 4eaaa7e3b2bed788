#include "server/auth/rate_limit.h"

#include <algorithm>

namespace sweepstake::auth {

bool RateBucket::Take(double per_s, int64_t now_ns) {
  const auto cost_ns = static_cast<int64_t>(1e9 / per_s);
  const int64_t due_ns = std::max(due_ns_, now_ns) + cost_ns;
  if (due_ns - now_ns > kBurstNs) return false;
  due_ns_ = due_ns;
  return true;
}

bool RateLimit::Take(const std::string& name, double per_s, int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  auto found = buckets_.find(name);
  if (found == buckets_.end()) {
    Forget(now_ns);
    found = buckets_.emplace(name, Entry{{}, uses_.insert(uses_.end(), name)}).first;
  } else {
    uses_.splice(uses_.end(), uses_, found->second.place);
  }
  return found->second.bucket.Take(per_s, now_ns);
}

void RateLimit::Forget(int64_t now_ns) {
  while (!uses_.empty() &&
         (buckets_.size() >= kMaxBuckets || buckets_.at(uses_.front()).bucket.full(now_ns))) {
    buckets_.erase(uses_.front());
    uses_.pop_front();
  }
}

size_t RateLimit::size() const {
  const std::lock_guard lock(mutex_);
  return buckets_.size();
}

}  // namespace sweepstake::auth
