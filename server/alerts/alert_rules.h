// The rules: which conditions of sessions and of the daemon need a person. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/alerts/alert.h"
#include "server/sessions/session_table.h"

namespace sweepstake::alerts {

// Bail-outs and dropped frames count as recent for this time.
inline constexpr int64_t kLatelyNs = 600'000'000'000;
// An ambiguous scene is serious if the choice of the leader is expected to cost this share more
// than the best arm.
inline constexpr double kSeriousLossRatio = 0.2;

// What the rules use of a session. Borrows the session.
struct SessionFacts {
  const std::string& id;
  const priors::SceneKey& scene;
  bool is_connected = false;
  bool is_lost = false;
  Mode mode = Mode::kManual;
  Verdict verdict = Verdict::kUnknown;
  double expected_loss_ratio = 0;
  // The expected cost per frame in µs. Absent: not known.
  std::optional<double> leader_us = {};
  std::optional<double> active_us = {};  // of the active arm
  bool bailed_out = false;               // in the last kLatelyNs
  bool dropped_frames = false;           // in the last kLatelyNs
};

SessionFacts FactsOf(const sessions::GameSession& session, sessions::SessionState state);
// Returns what choosing the leader is expected to cost per frame more than the best arm, in µs.
std::optional<double> ExpectedLossUs(const sessions::GameSession& session);

// One check of the daemon's health.
struct CheckResult {
  std::string name;
  std::string problem = {};  // empty if the check passes
  std::string remark = {};   // of a check that passes; empty if there is none
};

// Collects the conditions that hold, from all sessions and checks.
class Findings {
 public:
  void Add(const SessionFacts& session);
  void Add(const CheckResult& check);
  // Returns the findings with their sentences. If there are more than `limit`, only the serious
  // ones with the highest losses, then the others in the same order.
  std::map<AlertKey, Finding> Take(size_t limit);

 private:
  struct Sum {
    Finding finding;
    double max_loss_ratio = 0;
    uint32_t known_loss_count = 0;  // sessions in finding.loss_us
    bool has_verdict = false;       // whether a session has learnt anything
  };

  static std::string AmbiguousText(const Sum& sum);
  Sum& Count(Rule rule, const SessionFacts& session, std::optional<double> loss_us = {});

  std::map<AlertKey, Sum> sums_;
};

}  // namespace sweepstake::alerts
