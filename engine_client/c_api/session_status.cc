// The functions of a session that any thread may call.
#include <algorithm>
#include <cstring>

#include "engine_client/c_api/session.h"
#include "engine_client/c_api/sized_struct.h"

using sweepstake::LastDecision;
using sweepstake::SceneVerdict;
using sweepstake::ShadowStats;
using sweepstake::SwitchOutcome;
using sweepstake::SwitchReason;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

namespace {

swp_verdict ToC(const SceneVerdict& verdict) {
  return {static_cast<swp_verdict_kind>(verdict.verdict), verdict.leader_arm,
          verdict.leader_probability};
}

void Tell(const LastDecision& decision, swp_decision& told) {
  told.outcome = static_cast<swp_decision_outcome>(decision.outcome);
  told.decision_id = decision.decision_id;
  told.time_ns = decision.time_ns;
  told.active_arm = decision.active_arm;
  told.candidate_arm = decision.candidate_arm.value_or(SWP_NO_ARM);
  if (decision.command) {
    told.command_id = decision.command->command_id;
    told.command_arm = decision.command->arm;
    told.command_reason = static_cast<swp_switch_reason>(decision.command->reason);
  }
  told.verdict = ToC(decision.verdict);
  told.expected_loss_ratio = decision.expected_loss_ratio;
  std::copy(decision.best_probability.begin(), decision.best_probability.end(),
            told.best_probability);
}

swp_result CheckArm(const LiveSession& session, uint32_t arm) {
  if (arm < session.adaptive->arms().size()) return SWP_OK;
  return Fail(SWP_INVALID_ARGUMENT, "arm must be below swp_session_arm_count");
}

}  // namespace

swp_result swp_session_arm_count(const swp_session* session, uint32_t* count) {
  return Get(session, "count", count,
             [](const LiveSession& live) { return live.adaptive->arms().size(); });
}

swp_result swp_session_arm_name(const swp_session* session, uint32_t arm, const char** name) {
  return Use(session, [&](const LiveSession& live) {
    if (name == nullptr) return NullArgument("name");
    if (const swp_result wrong = CheckArm(live, arm); wrong != SWP_OK) return wrong;
    *name = live.adaptive->arms()[arm].c_str();
    return kOk;
  });
}

swp_result swp_session_arm_version(const swp_session* session, uint32_t arm,
                                   uint32_t* backend_version) {
  return Use(session, [&](const LiveSession& live) {
    if (backend_version == nullptr) return NullArgument("backend_version");
    if (const swp_result wrong = CheckArm(live, arm); wrong != SWP_OK) return wrong;
    *backend_version = live.adaptive->arm_versions()[arm];
    return kOk;
  });
}

swp_result swp_session_verdict(const swp_session* session, swp_verdict* verdict) {
  return Get(session, "verdict", verdict,
             [](const LiveSession& live) { return ToC(live.adaptive->verdict()); });
}

swp_result swp_session_dropped(const swp_session* session, uint64_t* sample_count,
                               uint64_t* note_count) {
  return Use(session, [&](const LiveSession& live) {
    if (sample_count != nullptr) *sample_count = live.queue.dropped_frame_count();
    if (note_count != nullptr) {
      *note_count = live.queue.dropped_note_count();
    }
  });
}

swp_result swp_session_last_decision(const swp_session* session, swp_decision* decision) {
  return Use(session, [&](const LiveSession& live) {
    const std::optional<LastDecision> latest = live.adaptive->last_decision();
    swp_decision told{};
    told.candidate_arm = told.command_arm = SWP_NO_ARM;
    if (latest) Tell(*latest, told);
    return Give("swp_decision", told, decision);
  });
}

swp_result swp_session_last_outcome(const swp_session* session, swp_switch_outcome* outcome) {
  return Use(session, [&](const LiveSession& live) {
    if (outcome == nullptr) return NullArgument("outcome");
    const SwitchOutcome none{.reason = SwitchReason{0}};
    const SwitchOutcome latest = live.adaptive->last_outcome().value_or(none);
    std::memcpy(outcome, &latest, sizeof *outcome);
    return kOk;
  });
}

swp_result swp_session_shadow_stats(const swp_session* session, swp_shadow_stats* stats) {
  return Use(session, [&](const LiveSession& live) {
    const ShadowStats seen = live.adaptive->shadow_stats();
    const swp_shadow_stats now = {sizeof now,
                                  static_cast<swp_shadow_state>(seen.state),
                                  seen.sweep_count,
                                  seen.visit_count,
                                  seen.capped_visit_count,
                                  seen.busy_time_ns,
                                  seen.memory_bytes,
                                  seen.copied_frame_count,
                                  seen.copy_time_ns,
                                  seen.warm_switch_count,
                                  seen.cold_switch_count};
    return Give("swp_shadow_stats", now, stats);
  });
}
