// What keeps switching in bounds (paper §4, §6.3): the cooldown, one command at a time, and whom a
// long frame is blamed on.
//
// Plain values; not thread-safe.
#pragma once

#include <cstdint>
#include <optional>

#include "server/decision/types.h"

namespace sweepstake::decision {

// Whether the frame is over the limit, by its time or by the client's own judgement
// (kFrameBailOut).
bool IsOverBailOutLimit(const Frame& frame, int64_t bail_out_ns);

// Whether such a frame is the arm's fault: not while paused or loading, and not where detection is
// under half of it.
bool BlamesArm(const Frame& frame, int64_t bail_out_ns);

// Says whether a switch may be commanded now.
class SwitchGate {
 public:
  // `last_switch_ns` absent: no switch yet, so nothing to wait for.
  explicit SwitchGate(std::optional<int64_t> last_switch_ns) : last_switch_ns_(last_switch_ns) {}

  bool CooldownPassed(int64_t now_ns, int64_t cooldown_ns) const;
  std::optional<int64_t> last_switch_ns() const { return last_switch_ns_; }

  // How long a command may travel to the client and its first frame back: two of the paper's
  // decision intervals. A time scale does not shorten it, since it does not shorten the way.
  static constexpr int64_t kCommandPatienceNs = 4'000'000'000;

  // A command is under way from when it is issued until a switch is executed, the client refuses
  // it, or it counts as lost: at the second or a later tick after it, once kCommandPatienceNs have
  // passed, whose own interval brought frames of the old epoch and none of a later one. The client
  // never got it; the next candidate that differs is commanded anew.
  void OnCommand(int64_t now_ns);
  void OnExecuted(int64_t executed_ns);
  void OnRefused() { ticks_since_command_.reset(); }
  void OnTick(bool old_epoch_frames_seen, int64_t now_ns);
  bool switch_under_way() const { return ticks_since_command_.has_value(); }

 private:
  std::optional<int64_t> last_switch_ns_;
  std::optional<uint32_t> ticks_since_command_;
  int64_t commanded_ns_ = 0;  // while ticks_since_command_ is there
};

}  // namespace sweepstake::decision
