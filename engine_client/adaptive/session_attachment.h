// The connection between an AdaptiveBroadPhase and the session whose thread uses it. Both share
// this object. Whichever of them is destroyed first ends the session, so that its thread never uses
// a destroyed AdaptiveBroadPhase.
//
// Thread safety: every method on any thread. End waits for another End in progress.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>

namespace sweepstake {

class SessionAttachment {
 public:
  // A function of the session that takes a deadline.
  using Call = std::function<void(uint32_t deadline_ms)>;

  // `end` ends the session's thread within the deadline, and its use of the AdaptiveBroadPhase.
  // `limit` shortens the deadline of an `end` in progress.
  void Begin(Call end, Call limit) {
    const std::lock_guard lock(mutex_);
    const std::lock_guard limit_lock(limit_mutex_);
    end_ = std::move(end);
    limit_ = std::move(limit);
  }
  // Ends the session unless that was done already. The session has ended when this returns.
  void End(uint32_t deadline_ms) {
    Limit(deadline_ms);
    const std::lock_guard lock(mutex_);
    if (const Call end = std::exchange(end_, nullptr)) end(deadline_ms);
    const std::lock_guard limit_lock(limit_mutex_);
    limit_ = nullptr;
  }
  bool active() {
    const std::lock_guard lock(mutex_);
    return end_ != nullptr;
  }

 private:
  void Limit(uint32_t deadline_ms) {
    const std::lock_guard lock(limit_mutex_);
    if (limit_) limit_(deadline_ms);
  }

  std::mutex mutex_;
  Call end_;  // guarded by mutex_; null: not begun, or ended
  std::mutex limit_mutex_;
  Call limit_;  // guarded by limit_mutex_
};

}  // namespace sweepstake
