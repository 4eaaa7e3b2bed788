// The audit log of a session has one row of CSV per decision and per event that decisions depend
// on. Every decision can be derived again from it, bit for bit, on any platform (rederive.h).
//
// A log is UTF-8 text by RFC 4180 with the header line below. A segment is the life of one
// DecisionSession: it begins with its `setup` row, and its rows are numbered from 1. Frames are not
// logged one by one, since a game makes some 3 kB of them in a second. Instead, each event logs a
// summary of the frames before it: the state of the arms' runs (decider/session/arm_runs.h). A log
// may therefore lack its last rows. Where a daemon has removed the oldest rows, or could not write
// some, a `missing` row stands in their place: the decisions after it cannot be derived.
//
// Numbers are the shortest decimal text that reads back as the same bits. The last cell,
// `log_hash`, is a hash (FNV-1a, 64 bits) of the segment up to there, so that an edit is found even
// if no decision depends on it. It protects against accidents, not against forgery.
//
// A row of 7 arms has some 1.0 kB, up to 2 kB with many shadow visits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sweepstake::decision {

class DecisionSession;

// The columns in the order of the file. A cell that does not apply to its row is empty. Inputs come
// first, so that everything derived depends only on cells to the left of it and above. The items of
// a list are separated by spaces, and are in the order of the setup's arms if there is one per arm;
// the members of an item are separated by colons.
enum class AuditColumn : size_t {
  kSession,
  kSegment,
  kRow,
  kKind,            // setup, tick, bail-out, switch, refusal, mode, order, missing or admin
  kTimeNs,          // time of the decider's steady clock
  kSetup,           // setup: key=value;… (cells.h); order: operator=NAME; admin: what was done
  kRuns,            // the arms' runs at the event (cells.h)
  kFrame,           // bail-out: the members of Frame; switch: those of TrialEnd, if it ended one
  kShadow,          // tick: list of ShadowSample's members
  kDescriptor,      // tick: SceneDescriptor's members
  kCommandId,       // refusal: the refused command; decision: the issued one
  kArm,             // switch, mode: now active; order: requested; decision: commanded
  kReason,          // reason of the switch or of the command
  kSwitchEpoch,     // switch: the epoch that it began
  kRebuildTimeNs,   // switch: SwitchCost
  kSettlingCostNs,  // switch: SwitchCost
  kMode,            // mode, order: manual or ai
  kDecisionId,
  kPolicy,
  kVersionOfReward,
  kProgramVersion,
  kSeed,
  kActiveArm,
  kCandidate,
  kOutcome,
  kReward,
  kIncrementArm,
  kIncrementAlpha,
  kIncrementBeta,
  kIncrementWindowCount,
  kIncrementBailOutCount,
  kAlpha,            // list: the posteriors after the update
  kBeta,             // list, as kAlpha
  kDraws,            // list: the values that the policy compared
  kBestProbability,  // list: each arm's probability of being the best
  kLeader,
  kExpectedLossRatio,
  kEntropy,
  kVerdict,
  kGain,  // E⁺ of GateTerms, like the next four
  kLoss,  // E⁻
  kHorizonS,
  kCooldownS,
  kSwitchCostS,
  kPropensity,
  kLogHash,
};

inline constexpr std::array<std::string_view, static_cast<size_t>(AuditColumn::kLogHash) + 1>
    kAuditColumnNames = {
        "session",
        "segment",
        "row",
        "kind",
        "time_ns",
        "setup",
        "runs",
        "frame",
        "shadow",
        "descriptor",
        "command_id",
        "arm",
        "reason",
        "switch_epoch",
        "rebuild_time_ns",
        "settling_cost_ns",
        "mode",
        "decision_id",
        "policy",
        "reward_version",
        "program_version",
        "seed",
        "active_arm",
        "candidate",
        "outcome",
        "reward",
        "increment_arm",
        "increment_alpha",
        "increment_beta",
        "increment_window_count",
        "increment_bail_out_count",
        "alpha",
        "beta",
        "draws",
        "best_probability",
        "leader",
        "expected_loss_ratio",
        "entropy",
        "verdict",
        "gain",
        "loss",
        "horizon_s",
        "cooldown_s",
        "switch_cost_s",
        "propensity",
        "log_hash",
};

// Returns the header line without its line end.
std::string AuditHeader();

// Returns the `missing` row that replaces rows that were removed or not written. `row` is the
// number of the first of these; the other cells are empty.
std::string MissingRow(std::string_view session_id, uint32_t segment, uint64_t row);

// Session id of the rows about actions of administrators. No session has this id.
inline constexpr std::string_view kAdminSession = "admin";

// Makes the rows of a segment of kAdminSession, one per action of an administrator. No decision
// follows from them; only their hashes are checked. Not thread-safe.
class AdminRows {
 public:
  explicit AdminRows(uint32_t segment);

  // `now_ns` is a time of the decider's steady clock, `unix_ms` of the wall clock. `action` and
  // `who` are lines of text. They are escaped as in a setup, so that a name cannot look like
  // another field of the row.
  std::string Next(int64_t now_ns, int64_t unix_ms, std::string_view action, std::string_view who);

 private:
  const uint32_t segment_;
  uint64_t row_count_ = 0;
  uint64_t hash_;
};

// The origin of a segment, for people. Decisions do not depend on it.
struct AuditOrigin {
  std::string session_id;
  uint32_t segment = 1;  // a session that goes on after a restart begins a new one
  std::string project;
  std::string scene;
  std::string machine_class;
  std::string program_version;
  std::vector<uint32_t> backend_versions;  // holds one per arm, or none
  int64_t unix_start_ms = 0;               // wall clock; 0 if unknown
  // Describes the sources of the priors and their weights to people. No decision depends on it.
  std::vector<std::string> prior_sources = {};
};

// Receives the rows as they are made.
class AuditSink {
 public:
  virtual ~AuditSink() = default;
  // The row has no line end and is valid during the call, which must not call the session back.
  virtual void OnAuditRow(std::string_view row) = 0;
};

// Starts the log: the sink receives the setup's row at once, then a row per event and decision. A
// session without this call makes no rows. The sink must outlive the session. REQUIRES: the session
// has observed nothing yet.
void StartAudit(DecisionSession& session, AuditSink& sink, AuditOrigin origin);

}  // namespace sweepstake::decision
