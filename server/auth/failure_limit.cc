#include "server/auth/failure_limit.h"

namespace sweepstake::auth {

FailureLimit::Level FailureLimit::Count(const std::string& address, int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  Forget(now_ns);
  const auto [found, is_new] = minutes_.try_emplace(address);
  Minute& minute = found->second;
  if (is_new) {
    minute.start_ns = now_ns;
    starts_.emplace_back(now_ns, address);
  }
  // The count stops above the limit, so that it cannot overflow.
  if (minute.count > kMaxFailures) return Level::kBeyond;
  ++minute.count;
  if (minute.count > kMaxFailures) return Level::kBeyond;
  return minute.count == kMaxFailures ? Level::kReached : Level::kBelow;
}

void FailureLimit::Forget(int64_t now_ns) {
  while (!starts_.empty() &&
         (starts_.front().first <= now_ns - kIntervalNs || minutes_.size() >= kMaxAddresses)) {
    minutes_.erase(starts_.front().second);
    starts_.pop_front();
  }
}

size_t FailureLimit::size() const {
  const std::lock_guard lock(mutex_);
  return minutes_.size();
}

}  // namespace sweepstake::auth
