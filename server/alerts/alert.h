// Alerts: conditions that need a person. Plain values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/prior_store.h"

namespace sweepstake::alerts {

enum class Rule : uint8_t {
  kCheck,          // a check of the daemon's health fails, or passes with a remark
  kDegraded,       // connected sessions miss the frame-rate floor because of the broad phase
  kBailOuts,       // sessions had bail-outs lately
  kAmbiguous,      // connected sessions have no clear best arm yet
  kManual,         // connected sessions are in manual mode and add no evidence
  kLostSessions,   // sessions have lost the connection to their games
  kDroppedFrames,  // games have dropped measurements lately
};
// The names of the rules in messages and metrics, in the order of Rule.
inline constexpr std::array<std::string_view, 7> kRuleNames = {
    "check", "degraded", "bail_outs", "ambiguous", "manual", "lost_sessions", "dropped_frames"};

constexpr std::string_view NameOf(Rule rule) { return kRuleNames[static_cast<size_t>(rule)]; }

// The values are those of v1::AlertSeverity.
enum class Severity : uint8_t { kNotice = 1, kSerious = 2 };
constexpr std::string_view NameOf(Severity severity) {
  return severity == Severity::kSerious ? "serious" : "notice";
}

// Identifies an alert.
struct AlertKey {
  Rule rule = Rule::kCheck;
  std::string check = {};       // name of the check; empty for other rules
  priors::SceneKey scene = {};  // default for the rule kCheck, which concerns the whole daemon

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const AlertKey&, const AlertKey&) = default;
};

// A condition that holds now.
struct Finding {
  Severity severity = Severity::kNotice;
  std::string text = {};                      // one sentence, without the name of the scene
  uint32_t session_count = 0;                 // sessions for which it holds
  std::vector<std::string> session_ids = {};  // the first kMaxPlaces of them
  // Expected loss per frame in µs, added over the sessions; absent if not known.
  std::optional<double> loss_us = {};
};

inline constexpr size_t kMaxPlaces = 3;

struct Silence {
  std::string id = {};        // of the alert
  int64_t unix_until_ms = 0;  // 0: until the alert ends
  std::string comment = {};
  std::string silenced_by = {};
};

struct Alert {
  std::string id = {};  // 16 hexadecimal digits; the same for the same key in every run
  AlertKey key = {};
  Finding finding = {};
  int64_t unix_since_ms = 0;
  std::optional<Silence> silence = {};
};

// Returns the id of the alert with this key.
std::string IdOf(const AlertKey& key);

}  // namespace sweepstake::alerts
