#include <algorithm>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {
namespace {

constexpr uint64_t kCommandIdMask = (uint64_t{1} << 40) - 1;
// An arm index above 254 is stored as 255. No client has so large an arm index (the maximum is 31),
// so such a command is refused and cannot select a wrong arm.
constexpr uint32_t kMaxCommandArm = 255;
constexpr uint32_t kMaxTrialLimit = 255;

uint64_t Pack(const SwitchCommand& command) {
  const uint64_t arm = std::min(command.arm, kMaxCommandArm);
  const uint64_t reason = static_cast<uint32_t>(command.reason) & 0xFF;
  const uint64_t limit = std::min(command.trial_limit_percent, kMaxTrialLimit);
  return ((command.command_id & kCommandIdMask) << 24) | (limit << 16) | (arm << 8) | reason;
}

SwitchCommand Unpack(uint64_t packed) {
  return {.command_id = packed >> 24,
          .arm = static_cast<uint32_t>((packed >> 8) & 0xFF),
          .reason = static_cast<SwitchReason>(packed & 0xFF),
          .trial_limit_percent = static_cast<uint32_t>((packed >> 16) & 0xFF)};
}

}  // namespace

void SwitchMailbox::Post(const SwitchCommand& command) noexcept {
  slot_.store(Pack(command), std::memory_order_release);
}

std::optional<SwitchCommand> SwitchMailbox::Take() noexcept {
  // Test with a plain load first: the slot is empty in nearly every frame, and an exchange is a
  // locked bus cycle.
  if (slot_.load(std::memory_order_relaxed) == 0) return std::nullopt;
  return Unpack(slot_.exchange(0, std::memory_order_acquire));
}

}  // namespace sweepstake
