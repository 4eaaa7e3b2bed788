// The current alerts and their silences.
//
// An alert begins when its condition has held for BeginAfterNs, and ends when the condition has not
// held for kEndAfterNs, so that a condition that comes and goes is one alert. Not thread-safe. The
// memory is bounded by kMaxAlerts and kMaxSilences. Times in ns are those of a steady clock, times
// in ms those of the wall clock since 1970.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/alerts/alert.h"

namespace sweepstake::alerts {

inline constexpr int64_t kEndAfterNs = 30'000'000'000;

// Every new session is ambiguous at first, and a lost connection usually returns soon.
constexpr int64_t BeginAfterNs(Rule rule) {
  if (rule == Rule::kAmbiguous) return 60'000'000'000;
  return rule == Rule::kLostSessions ? 30'000'000'000 : 0;
}

struct AlertChanges {
  std::vector<Alert> begun;
  std::vector<Alert> ended;
};

// The number of alerts of each rule, in the order of Rule.
struct AlertCounts {
  std::array<uint32_t, kRuleNames.size()> announced{};  // without a silence
  std::array<uint32_t, kRuleNames.size()> silenced{};
};

class AlertBoard {
 public:
  // Maximum number of conditions that Update accepts, and of alerts. At the limit, no alert begins
  // until another one has ended.
  static constexpr size_t kMaxAlerts = 2'000;
  static constexpr size_t kMaxSilences = 1'000;
  // A silence until the end of its alert is removed if there is no such alert for this time. After
  // a restart, alerts need some time to begin again.
  static constexpr int64_t kForgetSilenceNs = 900'000'000'000;

  // Sets the conditions that hold now. Returns the alerts to announce: those that have begun, or
  // whose silence has ended, without a silence, and those that have ended after they were announced
  // as begun. REQUIRES: at most kMaxAlerts findings.
  AlertChanges Update(std::map<AlertKey, Finding> findings, int64_t now_ns, int64_t unix_now_ms);

  // Returns all alerts: those without a silence first, then the serious ones, then by loss, number
  // of sessions and key.
  const std::vector<Alert>& ranked() const { return ranked_; }
  // Returns null if there is no such alert.
  const Alert* Find(const std::string& id) const;
  AlertCounts Counts() const;

  // Silences an alert, and replaces its earlier silence. Error: RESOURCE_EXHAUSTED (kMaxSilences).
  // REQUIRES: the alert exists.
  absl::Status Add(Silence silence, int64_t now_ns);
  // Returns whether the alert was silenced.
  bool Unsilence(const std::string& id);

  // The silences as a JSON text, for a file. Restore replaces all silences, and drops those that
  // have ended. Error: DATA_LOSS (not such a text).
  std::string SilencesText() const;
  absl::Status Restore(const std::string& text, int64_t now_ns, int64_t unix_now_ms);
  // Returns whether the silences have changed since the last call.
  bool TakeSilencesChanged();

 private:
  struct Entry {
    std::string id;
    Finding finding;
    int64_t first_held_ns = 0;
    int64_t last_held_ns = 0;
    int64_t unix_since_ms = 0;
    bool begun = false;
    bool announced = false;
    bool was_silenced = false;  // in the previous look
  };
  struct Kept {
    Silence silence;
    int64_t last_needed_ns = 0;  // when its alert existed last, or when it was added
  };

  Alert AlertOf(const AlertKey& key, const Entry& entry) const;
  void RemoveSilence(std::map<std::string, Kept>::iterator silence);
  void EndSilences(int64_t now_ns, int64_t unix_now_ms);
  void Rank();

  std::map<AlertKey, Entry> entries_;
  std::map<std::string, Kept> silences_;  // by the id of the alert
  std::vector<Alert> ranked_;
  std::map<std::string, size_t> places_;  // index in ranked_ by id
  bool silences_changed_ = false;
};

}  // namespace sweepstake::alerts
