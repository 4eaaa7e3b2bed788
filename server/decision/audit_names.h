// The words of the audit log for enumerations.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "server/decision/audit_text.h"
#include "server/decision/types.h"

namespace sweepstake::decision {

enum class AuditKind : uint32_t { kSetup, kTick, kBailOut, kSwitch, kRefusal, kMode };

// By value; empty: there is no such value.
inline constexpr std::array<std::string_view, 6> kAuditKindNames = {"setup",  "tick",    "bail-out",
                                                                    "switch", "refusal", "mode"};
inline constexpr std::array<std::string_view, 3> kModeNames = {"", "manual", "ai"};
inline constexpr std::array<std::string_view, 5> kSwitchReasonNames = {"", "policy", "exploration",
                                                                       "bail-out", "manual"};
inline constexpr std::array<std::string_view, 13> kOutcomeNames = {
    "",          "kept",   "switched",  "held-cooldown", "held-settling",
    "no-frames", "manual", "exploring", "rejected",      "held-gate",
    "",          "",       "held-tie"};
inline constexpr std::array<std::string_view, 5> kVerdictNames = {"unknown", "stable", "tie",
                                                                  "ambiguous", "degraded"};

// The value's name, or its number where it has none.
template <typename Enum>
void AppendName(std::string& out, std::span<const std::string_view> names, Enum value) {
  const auto number = static_cast<uint32_t>(value);
  if (number < names.size() && !names[number].empty()) {
    out += names[number];
  } else {
    AppendText(out, number);
  }
}

template <typename Enum>
bool ParseName(std::string_view text, std::span<const std::string_view> names, Enum& value) {
  for (size_t i = 0; i < names.size() && !text.empty(); ++i) {
    if (names[i] != text) continue;
    value = static_cast<Enum>(i);
    return true;
  }
  uint32_t number = 0;
  if (!ParseText(text, number)) return false;
  value = static_cast<Enum>(number);
  return true;
}

}  // namespace sweepstake::decision
