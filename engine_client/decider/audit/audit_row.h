// A row of the audit log as a plain value, and the list of its fields.
//
// A session's log has one row per decision and one per event that decisions depend on. A replay
// derives every decision again, bit for bit, on any platform (rederive.h).
//
// A segment is the lifetime of one DecisionSession. It begins with its `setup` row, and its rows
// are numbered from 1. Frames are not logged one by one, because a game produces about 3 kB of them
// per second. Instead, each event's row contains the state that the frames before it led to: the
// arms' runs (decider/session/arm_runs.h).
//
// A log may end early, without its last rows. If a daemon removed the oldest rows, or failed to
// write some, a `missing` row replaces them. Later decisions of the segment cannot be derived.
//
// VisitFields(row, visit) calls visit(name, member) for every field, in an order that never
// changes. The member is a number, an enumeration, a string, a struct with fields of its own, or a
// std::optional or std::vector of these. The hash, the CSV file and the protobuf message
// (sweepstake.v1.AuditRow) have these fields under these names. VisitFields unpacks each struct
// completely, so a struct with a new member does not compile until the member is visited.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/session/session_setup.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// The same values as sweepstake.v1.AuditKind.
enum class AuditKind : uint32_t {
  kSetup = 1,    // the segment begins
  kTick = 2,     // a decision at the time of a tick
  kBailOut = 3,  // a decision because of a frame over the limit
  kSwitch = 4,   // the game executed a switch
  kRefusal = 5,  // the game refused a command
  kMode = 6,     // the game changed its mode
  kOrder = 7,    // an operator ordered the game to change its mode
  kMissing = 8,  // rows from this number on are missing
  kAdmin = 9,    // an action of an administrator
};

// The text of each kind, indexed by its value.
inline constexpr std::array<std::string_view, 10> kAuditKindNames = {
    "", "setup", "tick", "bail-out", "switch", "refusal", "mode", "order", "missing", "admin"};

// Describes the origin of a segment, for readers of the log. Decisions do not depend on it.
struct AuditOrigin {
  std::string session_id;
  uint32_t segment = 1;  // a session that continues after a restart has a new segment
  std::string project;
  std::string scene;
  std::string machine_class;
  std::string program_version;
  std::vector<uint32_t> backend_versions;  // one per arm, or empty
  int64_t unix_start_ms = 0;               // wall clock; 0 if unknown
  // One text per group of prior sources: its description and weight.
  std::vector<std::string> prior_sources = {};
};

struct AuditSetup {
  AuditOrigin origin;  // session_id and segment are not logged here: AuditRow has them
  SessionSetup setup;
};

// The result of a tick or a bail-out. Each list has one item per arm, or is empty.
struct AuditDecision {
  uint64_t id = 0;
  std::string policy;
  uint32_t reward_version = 0;
  std::string active_arm;
  std::string candidate;  // empty: none
  DecisionOutcome outcome{};
  std::optional<double> reward;  // absent: no window was learnt from
  std::optional<Increment> increment;
  std::vector<BetaPosterior> posteriors;  // after the update
  std::vector<double> draws;
  std::vector<double> best_probability;
  std::string leader;  // empty: nothing was learnt yet
  double expected_loss_ratio = 0;
  double entropy = 0;
  Verdict verdict = Verdict::kUnknown;
  std::optional<GateTerms> gate;
  double propensity = 1;
};

// The comment on a field names the kinds of rows that use it. Inputs come before results, so each
// result depends only on earlier fields and earlier rows. `runs`, `frame`, `switch_cost`, `shadow`
// and increments refer to arms by index.
struct AuditRow {
  std::string session;
  uint32_t segment = 1;
  uint64_t row = 1;
  AuditKind kind{};
  std::optional<int64_t> time_ns = {};        // time of the decider's steady clock
  std::optional<AuditSetup> setup = {};       // setup
  std::optional<ArmRuns> runs = {};           // tick, bail-out, switch, mode
  std::optional<FrameSample> frame = {};      // bail-out
  std::vector<ShadowSample> shadow = {};      // tick
  std::optional<SceneDescriptor> scene = {};  // tick
  std::optional<uint64_t> command_id = {};    // refusal: the refused command; decision: its command
  // switch, mode: the arm that is active from now on; order: the ordered arm; decision: the
  // commanded arm
  std::string arm = {};
  SwitchReason reason{};                       // switch, or decision with a command; 0: none
  std::optional<uint32_t> switch_epoch = {};   // switch
  std::optional<SwitchCost> switch_cost = {};  // switch
  Mode mode{};                                 // mode, order; 0: none
  std::string operator_name = {};              // order, admin
  std::optional<int64_t> unix_ms = {};         // admin: wall clock
  std::string action = {};                     // admin: what the operator did
  std::optional<AuditDecision> decision = {};  // tick, bail-out
  // Hash of the segment up to and including this row. It reveals an edit even of a field that no
  // decision depends on. It protects against accidents, not against forgery.
  uint64_t log_hash = 0;
};

template <typename T, typename Value>
concept EitherConst = std::same_as<std::remove_const_t<T>, Value>;

template <EitherConst<BetaPosterior> T, typename Visit>
void VisitFields(T& posterior, Visit&& visit) {
  auto& [alpha, beta] = posterior;
  visit("alpha", alpha);
  visit("beta", beta);
}

template <EitherConst<AuditSetup> T, typename Visit>
void VisitFields(T& logged, Visit&& visit) {
  auto& [session_id, segment, project, scene, machine_class, program_version, backend_versions,
         unix_start_ms, prior_sources] = logged.origin;
  visit("project", project);
  visit("scene", scene);
  visit("machine_class", machine_class);
  visit("program_version", program_version);
  visit("backend_versions", backend_versions);
  visit("unix_start_ms", unix_start_ms);
  visit("prior_sources", prior_sources);
  // The log leaves out the initial arm, because no decision depends on it.
  auto& [options, arms, priors, regime_priors, seed, mode, active_arm, initial_arm, switch_epoch,
         start_ns, explored_arm_count, decision_count, stops_trials] = logged.setup;
  // The two other times are logged as the session uses them, so regime_interval_ns is left out.
  auto& [policy, weights, decision_interval_ns, cooldown_ns, settling_ns, regime_interval_ns,
         bail_out_ns, exploration_warm_up_ns, exploration_measure_ns, explore, bail_out_penalty,
         fps_floor] = options;
  auto& [weight_fps, weight_detection, weight_memory, weight_checks] = weights;
  visit("arms", arms);
  visit("policy", policy);
  visit("weight_fps", weight_fps);
  visit("weight_detection", weight_detection);
  visit("weight_memory", weight_memory);
  visit("weight_checks", weight_checks);
  visit("decision_interval_ns", decision_interval_ns);
  visit("cooldown_ns", cooldown_ns);
  visit("settling_ns", settling_ns);
  visit("bail_out_ns", bail_out_ns);
  visit("exploration_warm_up_ns", exploration_warm_up_ns);
  visit("exploration_measure_ns", exploration_measure_ns);
  visit("explore", explore);
  visit("bail_out_penalty", bail_out_penalty);
  visit("fps_floor", fps_floor);
  visit("priors", priors);
  auto& [buckets, posteriors, stored_count] = regime_priors;
  visit("regimes", buckets);
  visit("regime_priors", posteriors);
  visit("stored_regime_count", stored_count);
  visit("seed", seed);
  visit("mode", mode);
  visit("active_arm", active_arm);
  visit("switch_epoch", switch_epoch);
  visit("start_ns", start_ns);
  visit("explored_arm_count", explored_arm_count);
  visit("decision_count", decision_count);
  visit("stops_trials", stops_trials);
}

// Handles classes with private members (Window, ArmRun, ArmRuns): they provide VisitFields as a
// static member function.
template <typename T, typename Visit>
requires requires(T& fields, Visit& visit) { T::VisitFields(fields, visit); }
void VisitFields(T& fields, Visit&& visit) { T::VisitFields(fields, visit); }

// Leaves out the frame's index, its pairs and invalid boxes, because decisions do not depend on
// them.
template <EitherConst<FrameSample> T, typename Visit>
void VisitFields(T& frame, Visit&& visit) {
  auto& [index, frame_time_ns, detection_time_ns, aabb_check_count, native_bytes, pair_count,
         object_count, arm, switch_epoch, flags, invalid_box_count] = frame;
  visit("frame_time_ns", frame_time_ns);
  visit("detection_time_ns", detection_time_ns);
  visit("aabb_check_count", aabb_check_count);
  visit("native_bytes", native_bytes);
  visit("object_count", object_count);
  visit("arm", arm);
  visit("switch_epoch", switch_epoch);
  visit("flags", flags);
}

template <EitherConst<TrialEnd> T, typename Visit>
void VisitFields(T& end, Visit&& visit) {
  auto& [arm, detection_time_ns] = end;
  visit("arm", arm);
  visit("detection_time_ns", detection_time_ns);
}

template <EitherConst<SwitchCost> T, typename Visit>
void VisitFields(T& cost, Visit&& visit) {
  auto& [rebuild_time_ns, settling_cost_ns, ended_trial] = cost;
  visit("rebuild_time_ns", rebuild_time_ns);
  visit("settling_cost_ns", settling_cost_ns);
  visit("ended_trial", ended_trial);
}

template <EitherConst<ShadowSample> T, typename Visit>
void VisitFields(T& sample, Visit&& visit) {
  auto& [first_frame_index, detection_time_ns, build_time_ns, aabb_check_count, native_bytes, arm,
         object_count, frame_count, flags] = sample;
  visit("first_frame_index", first_frame_index);
  visit("detection_time_ns", detection_time_ns);
  visit("build_time_ns", build_time_ns);
  visit("aabb_check_count", aabb_check_count);
  visit("native_bytes", native_bytes);
  visit("arm", arm);
  visit("object_count", object_count);
  visit("frame_count", frame_count);
  visit("flags", flags);
}

// A value that was not measured is absent in the log.
template <EitherConst<SceneDescriptor> T, typename Visit>
void VisitFields(T& scene, Visit&& visit) {
  const auto visit_value = [&](std::string_view name, auto& value) {
    std::optional<double> measured;
    if (IsMeasured(value)) measured = value;
    visit(name, measured);
    if constexpr (!std::is_const_v<T>) value = static_cast<float>(measured.value_or(-1));
  };
  auto& [object_count, density_ratio, size_spread, speed_mean, speed_spread, clustering_ratio,
         static_ratio] = scene;
  visit_value("object_count", object_count);
  visit_value("density_ratio", density_ratio);
  visit_value("size_spread", size_spread);
  visit_value("speed_mean", speed_mean);
  visit_value("speed_spread", speed_spread);
  visit_value("clustering_ratio", clustering_ratio);
  visit_value("static_ratio", static_ratio);
}

template <EitherConst<Increment> T, typename Visit>
void VisitFields(T& increment, Visit&& visit) {
  auto& [arm, alpha, beta, window_count, bail_out_count] = increment;
  visit("arm", arm);
  visit("alpha", alpha);
  visit("beta", beta);
  visit("window_count", window_count);
  visit("bail_out_count", bail_out_count);
}

template <EitherConst<GateTerms> T, typename Visit>
void VisitFields(T& gate, Visit&& visit) {
  auto& [gain, loss, horizon_s, cooldown_s, cost_s] = gate;
  visit("gain", gain);
  visit("loss", loss);
  visit("horizon_s", horizon_s);
  visit("cooldown_s", cooldown_s);
  visit("cost_s", cost_s);
}

template <EitherConst<AuditDecision> T, typename Visit>
void VisitFields(T& decision, Visit&& visit) {
  visit("id", decision.id);
  visit("policy", decision.policy);
  visit("reward_version", decision.reward_version);
  visit("active_arm", decision.active_arm);
  visit("candidate", decision.candidate);
  visit("outcome", decision.outcome);
  visit("reward", decision.reward);
  visit("increment", decision.increment);
  visit("posteriors", decision.posteriors);
  visit("draws", decision.draws);
  visit("best_probability", decision.best_probability);
  visit("leader", decision.leader);
  visit("expected_loss_ratio", decision.expected_loss_ratio);
  visit("entropy", decision.entropy);
  visit("verdict", decision.verdict);
  visit("gate", decision.gate);
  visit("propensity", decision.propensity);
}

// Visits all fields of the row except log_hash.
template <EitherConst<AuditRow> T, typename Visit>
void VisitHashedFields(T& row, Visit&& visit) {
  visit("session", row.session);
  visit("segment", row.segment);
  visit("row", row.row);
  visit("kind", row.kind);
  visit("time_ns", row.time_ns);
  visit("setup", row.setup);
  visit("runs", row.runs);
  visit("frame", row.frame);
  visit("shadow", row.shadow);
  visit("scene", row.scene);
  visit("command_id", row.command_id);
  visit("arm", row.arm);
  visit("reason", row.reason);
  visit("switch_epoch", row.switch_epoch);
  visit("switch_cost", row.switch_cost);
  visit("mode", row.mode);
  visit("operator_name", row.operator_name);
  visit("unix_ms", row.unix_ms);
  visit("action", row.action);
  visit("decision", row.decision);
}

template <EitherConst<AuditRow> T, typename Visit>
void VisitFields(T& row, Visit&& visit) {
  VisitHashedFields(row, visit);
  visit("log_hash", row.log_hash);
}

// Let visitors detect a struct with fields, a std::optional and a std::vector.
template <typename T>
concept AuditStruct = requires(T& fields) {
  decision::VisitFields(fields, [](std::string_view, auto&) {});
};
template <typename T>
inline constexpr bool kIsOptional = false;
template <typename T>
inline constexpr bool kIsOptional<std::optional<T>> = true;
template <typename T>
inline constexpr bool kIsList = false;
template <typename T>
inline constexpr bool kIsList<std::vector<T>> = true;

}  // namespace sweepstake::decision
