#include "server/auth/failure_limit.h"

namespace sweepstake::auth {

FailureLimit::Verdict FailureLimit::Count(const std::string& address, int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  Forget(now_ns);
  const auto [found, is_new] = windows_.try_emplace(address);
  Window& window = found->second;
  if (is_new) {
    window.start_ns = now_ns;
    starts_.emplace_back(now_ns, address);
  }
  // The count stops above the limit, so that it cannot overflow.
  if (window.count > kMaxFailures) return Verdict::kBeyond;
  ++window.count;
  if (window.count > kMaxFailures) return Verdict::kBeyond;
  return window.count == kMaxFailures ? Verdict::kReached : Verdict::kBelow;
}

void FailureLimit::Forget(int64_t now_ns) {
  while (!starts_.empty() &&
         (starts_.front().first <= now_ns - kIntervalNs || windows_.size() >= kMaxAddresses)) {
    windows_.erase(starts_.front().second);
    starts_.pop_front();
  }
}

size_t FailureLimit::size() const {
  const std::lock_guard lock(mutex_);
  return windows_.size();
}

}  // namespace sweepstake::auth
