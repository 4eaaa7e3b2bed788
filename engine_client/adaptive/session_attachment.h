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
  // Ends the session's thread within `deadline_ms`, and its use of the AdaptiveBroadPhase.
  using EndSession = std::function<void(uint32_t deadline_ms)>;

  void Begin(EndSession end) {
    const std::lock_guard lock(mutex_);
    end_ = std::move(end);
  }
  // Ends the session unless that was done already. The session has ended when this returns.
  void End(uint32_t deadline_ms) {
    const std::lock_guard lock(mutex_);
    if (const EndSession end = std::exchange(end_, nullptr)) end(deadline_ms);
  }
  bool active() {
    const std::lock_guard lock(mutex_);
    return end_ != nullptr;
  }

 private:
  std::mutex mutex_;
  EndSession end_;  // guarded by mutex_; null: not begun, or ended
};

}  // namespace sweepstake
