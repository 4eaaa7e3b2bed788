#include "server/alerts/alert_rules.h"

#include <openssl/sha.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::alerts {
namespace {

// Returns the expected cost of an arm in µs, which only rewards of this version contain.
std::optional<double> CostUsOf(const sessions::GameSession& session, uint32_t arm) {
  const auto posteriors = session.decisions().posteriors();
  if (session.identity().scene.reward_version != decision::kLogCostRewardVersion ||
      arm >= posteriors.size())
    return std::nullopt;
  return std::exp(decision::BeliefOf(posteriors[arm]).mean);
}

std::optional<double> LossUs(const SessionFacts& session) {
  if (!session.leader_us) return std::nullopt;
  return session.expected_loss_ratio * *session.leader_us;
}

// Returns what a session loses per frame because its mode keeps it from the leader.
std::optional<double> ManualLossUs(const SessionFacts& session) {
  if (!session.leader_us || !session.active_us || session.verdict == Verdict::kUnknown)
    return std::nullopt;
  return std::max(0.0, *session.active_us - *session.leader_us);
}

// Returns "1 session is" or "3 sessions are".
std::string Counted(uint32_t count, const char* one, const char* many) {
  return absl::StrCat(count, " ", count == 1 ? one : many);
}

std::string NumberText(double value) {
  return value < 10 ? absl::StrFormat("%.2g", value) : absl::StrFormat("%.0f", value);
}

std::string TextOf(Rule rule, uint32_t count) {
  switch (rule) {
    case Rule::kDegraded:
      return Counted(count, "session misses the frame-rate floor because of the broad phase.",
                     "sessions miss the frame-rate floor because of the broad phase.");
    case Rule::kBailOuts:
      return Counted(count, "session had a bail-out in the last 10 minutes.",
                     "sessions had bail-outs in the last 10 minutes.");
    case Rule::kManual:
      return Counted(count, "session is in manual mode and adds no evidence.",
                     "sessions are in manual mode and add no evidence.");
    case Rule::kLostSessions:
      return Counted(count, "session has lost the connection to its game.",
                     "sessions have lost the connection to their games.");
    case Rule::kDroppedFrames:
      return Counted(count, "game has dropped measurements in the last 10 minutes.",
                     "games have dropped measurements in the last 10 minutes.");
    case Rule::kCheck:
    case Rule::kAmbiguous:
      break;  // they have their own sentences
  }
  return {};
}

}  // namespace

std::string IdOf(const AlertKey& key) {
  // A newline separates the fields, because names have no control characters.
  const std::string text =
      absl::StrJoin(std::tuple(std::string(NameOf(key.rule)), key.check, key.scene.project,
                               key.scene.scene, key.scene.machine_class, key.scene.reward_version),
                    "\n");
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  return absl::BytesToHexString(absl::string_view(reinterpret_cast<const char*>(digest.data()), 8));
}

SessionFacts FactsOf(const sessions::GameSession& session, sessions::SessionState state) {
  const decision::DecisionSession& decisions = session.decisions();
  const decision::Diagnosis& diagnosis = decisions.diagnosis();
  return {.id = session.identity().id,
          .scene = session.identity().scene,
          .is_connected = state == sessions::SessionState::kConnected,
          .is_lost = state == sessions::SessionState::kLost,
          .mode = decisions.mode(),
          .verdict = diagnosis.verdict,
          .expected_loss_ratio = diagnosis.expected_loss_ratio,
          .leader_us = CostUsOf(session, diagnosis.leader),
          .active_us = CostUsOf(session, decisions.active_arm())};
}

std::optional<double> ExpectedLossUs(const sessions::GameSession& session) {
  return LossUs(FactsOf(session, sessions::SessionState::kConnected));
}

std::string Findings::AmbiguousText(const Sum& sum) {
  const uint32_t session_count = sum.finding.session_count;
  if (!sum.has_verdict) {
    return absl::StrCat("Nothing is known about the algorithms yet; ",
                        Counted(session_count, "session waits", "sessions wait"),
                        " for measurements.");
  }
  std::string text =
      absl::StrCat("No algorithm is clearly the best yet; the leader is expected to cost up to ",
                   NumberText(100 * sum.max_loss_ratio), " % more than the best one");
  if (sum.known_loss_count > 0) {
    absl::StrAppend(&text, ", on average ", NumberText(*sum.finding.loss_us / sum.known_loss_count),
                    " µs per frame");
  }
  return absl::StrCat(text, " in ", Counted(session_count, "session", "sessions"), ".");
}

Findings::Sum& Findings::Count(Rule rule, const SessionFacts& session,
                               std::optional<double> loss_us) {
  Sum& sum = sums_[{.rule = rule, .check = {}, .scene = session.scene}];
  Finding& finding = sum.finding;
  ++finding.session_count;
  if (finding.session_ids.size() < kMaxPlaces) finding.session_ids.push_back(session.id);
  if (loss_us) {
    finding.loss_us = finding.loss_us.value_or(0) + *loss_us;
    ++sum.known_loss_count;
  }
  return sum;
}

void Findings::Add(const SessionFacts& session) {
  const auto serious = [](Sum& sum) { sum.finding.severity = Severity::kSerious; };
  if (session.bailed_out) serious(Count(Rule::kBailOuts, session));
  if (session.dropped_frames) Count(Rule::kDroppedFrames, session);
  if (session.is_lost) Count(Rule::kLostSessions, session);
  if (!session.is_connected) return;
  if (session.mode == Mode::kManual) {
    Count(Rule::kManual, session, ManualLossUs(session));
    return;
  }
  if (session.verdict == Verdict::kDegraded) {
    serious(Count(Rule::kDegraded, session, LossUs(session)));
  } else if (session.verdict == Verdict::kAmbiguous) {
    Sum& sum = Count(Rule::kAmbiguous, session, LossUs(session));
    sum.has_verdict = true;
    sum.max_loss_ratio = std::max(sum.max_loss_ratio, session.expected_loss_ratio);
    if (session.expected_loss_ratio >= kSeriousLossRatio) serious(sum);
  } else if (session.verdict == Verdict::kUnknown) {
    Count(Rule::kAmbiguous, session);
  }
}

void Findings::Add(const CheckResult& check) {
  if (check.problem.empty() && check.remark.empty()) return;
  const bool failed = !check.problem.empty();
  Finding& finding = sums_[{.rule = Rule::kCheck, .check = check.name, .scene = {}}].finding;
  finding.severity = failed ? Severity::kSerious : Severity::kNotice;
  finding.text =
      absl::StrCat("Health check ", check.name, ": ", failed ? check.problem : check.remark, ".");
}

std::map<AlertKey, Finding> Findings::Take(size_t limit) {
  std::vector<std::pair<const AlertKey, Sum>*> chosen;
  chosen.reserve(sums_.size());
  for (auto& entry : sums_) chosen.push_back(&entry);
  if (chosen.size() > limit) {
    const auto rank = [](const auto* entry) {
      const Finding& finding = entry->second.finding;
      return std::tuple(finding.severity, finding.loss_us.value_or(0), finding.session_count);
    };
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](const auto* a, const auto* b) { return rank(a) > rank(b); });
    chosen.resize(limit);
  }
  std::map<AlertKey, Finding> findings;
  for (auto* entry : chosen) {
    auto& [key, sum] = *entry;
    const uint32_t count = sum.finding.session_count;
    if (key.rule == Rule::kAmbiguous) {
      sum.finding.text = AmbiguousText(sum);
    } else if (key.rule != Rule::kCheck) {
      sum.finding.text = TextOf(key.rule, count);
    }
    findings.emplace(key, std::move(sum.finding));
  }
  sums_.clear();
  return findings;
}

}  // namespace sweepstake::alerts
