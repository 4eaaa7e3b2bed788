// The audit log of a session: one row of CSV per decision and per event that decisions depend on,
// from which every decision can be derived again, bit for bit, on any platform (audit_rederive.h).
//
// A log is UTF-8 text by RFC 4180 with the header line below. A segment is one DecisionSession's
// life: it begins with its `setup` row and its rows are numbered from 1. Frames are not logged one
// by one (a game makes some 3 kB of them in a second): what an event depends on of them is logged
// as it is reduced, the state of the arm's run (arm_runs.h). So a log without its last rows is
// still a log, and nothing else may be missing.
//
// Numbers are the shortest decimal text that reads back as the same bits, and the last cell
// `log_hash` is a hash (FNV-1a, 64 bits) of the segment up to there, so that an edit shows even
// where no decision depends on it. It protects against accidents, not against forgers.
//
// Cost: a row of 7 arms has some 1.0 kB, up to 2 kB with many shadow visits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sweepstake::decision {

// Columns in the order of the file; empty where a row has nothing to say. Inputs come first, so
// that what is derived follows from what stands to the left of it and above. Lists have their items
// separated by spaces, in the order of the setup's arms where they are per arm; what belongs
// together in an item is separated by colons.
enum class AuditColumn : size_t {
  kSession,
  kSegment,
  kRow,
  kKind,            // setup, tick, bail-out, switch, refusal or mode
  kTimeNs,          // of the decider's steady clock
  kSetup,           // setup: key=value;… (audit_setup.h)
  kRuns,            // the arms' runs at the event (audit_runs.h)
  kFrame,           // bail-out: the members of Frame
  kShadow,          // tick: list of ShadowSample's members
  kDescriptor,      // tick: SceneDescriptor's members
  kCommandId,       // refusal: refused; decision: commanded
  kArm,             // switch, mode: active from now on; decision: commanded
  kReason,          // of the switch or of the command
  kSwitchEpoch,     // switch
  kRebuildTimeNs,   // switch
  kSettlingCostNs,  // switch
  kMode,            // mode: manual or ai
  kDecisionId,
  kPolicy,
  kVersionOfReward,
  kProgramVersion,
  kSeed,
  kContext,
  kActiveArm,
  kCandidate,
  kOutcome,
  kReward,
  kIncrementArm,
  kIncrementAlpha,
  kIncrementBeta,
  kIncrementWindowCount,
  kIncrementBailOutCount,
  kAlpha,            // list, after the update
  kBeta,             // list
  kDraws,            // list
  kBestProbability,  // list
  kLeader,
  kExpectedLossRatio,
  kEntropy,
  kVerdict,
  kGain,         // E⁺
  kLoss,         // E⁻
  kHorizonS,     // H
  kCooldownS,    // D
  kSwitchCostS,  // C
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
        "context",
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

// Without a line end.
std::string AuditHeader();

// Where a segment comes from, for people; decisions do not depend on it.
struct AuditOrigin {
  std::string session_id;
  uint32_t segment = 1;  // a session that goes on after a restart begins another one
  std::string project;
  std::string scene;
  std::string machine_class;
  std::string program_version;
  std::vector<uint32_t> backend_versions;  // per arm, or none
  int64_t unix_start_ms = 0;               // of the wall clock; 0: unknown
};

// Takes the rows as they come: without a line end, valid during the call. Must not call the session
// back.
class AuditSink {
 public:
  virtual ~AuditSink() = default;
  virtual void OnAuditRow(std::string_view row) = 0;
};

}  // namespace sweepstake::decision
