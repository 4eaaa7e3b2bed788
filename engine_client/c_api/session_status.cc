// The functions of a session for any thread, and for the caller's transport.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <variant>

#include "engine_client/c_api/session.h"
#include "engine_client/c_api/sized_struct.h"

using sweepstake::FrameSample;
using sweepstake::LastDecision;
using sweepstake::QueuedItem;
using sweepstake::SampleQueue;
using sweepstake::SceneDescriptor;
using sweepstake::SceneVerdict;
using sweepstake::ShadowSample;
using sweepstake::ShadowStats;
using sweepstake::SwitchOutcome;
using sweepstake::SwitchReason;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

namespace {

constexpr uint64_t kCommandIdLimit = uint64_t{1} << 48;

void KeepOutcome(Session& session, const SwitchOutcome& outcome) {
  if (session.outcomes.size() == SampleQueue::kNoteCapacity) {
    session.outcomes.pop_front();
    ++session.dropped_outcome_count;
  }
  session.outcomes.push_back(outcome);
}

// Keeps outcomes and descriptors. A change of mode is dropped: the caller made it.
void KeepNote(Session& session, const QueuedItem& item) {
  if (const auto* outcome = std::get_if<SwitchOutcome>(&item)) KeepOutcome(session, *outcome);
  if (const auto* seen = std::get_if<SceneDescriptor>(&item)) session.descriptor = *seen;
}

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

swp_result CheckDrain(const Session& session, const void* out, uint32_t capacity,
                      const uint32_t* count) {
  if (count == nullptr) return NullArgument("count");
  if (out == nullptr && capacity > 0) return NullArgument("the buffer");
  if (!session.decider_loop && !session.link_is_attached) return SWP_OK;
  return Fail(SWP_FAILED_PRECONDITION, "the attached decider or link takes the samples");
}

swp_result CheckArm(const Session& session, uint32_t arm) {
  if (arm < session.adaptive->arms().size()) return SWP_OK;
  return Fail(SWP_INVALID_ARGUMENT, "there is no such arm: see swp_session_arm_count");
}

}  // namespace

swp_result swp_session_arm_count(const swp_session* session, uint32_t* count) {
  return Use(session, [&](const Session& live) {
    if (count == nullptr) return NullArgument("count");
    *count = static_cast<uint32_t>(live.adaptive->arms().size());
    return kOk;
  });
}

swp_result swp_session_arm_name(const swp_session* session, uint32_t arm, const char** name) {
  return Use(session, [&](const Session& live) {
    if (name == nullptr) return NullArgument("name");
    if (const swp_result wrong = CheckArm(live, arm); wrong != SWP_OK) return wrong;
    *name = live.adaptive->arms()[arm].c_str();
    return kOk;
  });
}

swp_result swp_session_arm_version(const swp_session* session, uint32_t arm,
                                   uint32_t* backend_version) {
  return Use(session, [&](const Session& live) {
    if (backend_version == nullptr) return NullArgument("backend_version");
    if (const swp_result wrong = CheckArm(live, arm); wrong != SWP_OK) return wrong;
    *backend_version = live.adaptive->arm_versions()[arm];
    return kOk;
  });
}

swp_result swp_session_verdict(const swp_session* session, swp_verdict* verdict) {
  return Use(session, [&](const Session& live) {
    if (verdict == nullptr) return NullArgument("verdict");
    *verdict = ToC(live.adaptive->verdict());
    return kOk;
  });
}

swp_result swp_session_dropped(const swp_session* session, uint64_t* sample_count,
                               uint64_t* note_count) {
  return Use(session, [&](const Session& live) {
    if (sample_count != nullptr) *sample_count = live.queue.dropped_frame_count();
    if (note_count != nullptr) {
      *note_count = live.queue.dropped_note_count() + live.dropped_outcome_count;
    }
  });
}

swp_result swp_session_last_decision(const swp_session* session, swp_decision* decision) {
  return Use(session, [&](const Session& live) {
    const std::optional<LastDecision> latest = live.adaptive->last_decision();
    swp_decision told{};
    told.candidate_arm = told.command_arm = SWP_NO_ARM;
    if (latest) Tell(*latest, told);
    return Give("swp_decision", told, decision);
  });
}

swp_result swp_session_last_outcome(const swp_session* session, swp_switch_outcome* outcome) {
  return Use(session, [&](const Session& live) {
    if (outcome == nullptr) return NullArgument("outcome");
    const SwitchOutcome none{.reason = SwitchReason{0}};
    const SwitchOutcome latest = live.adaptive->last_outcome().value_or(none);
    std::memcpy(outcome, &latest, sizeof *outcome);
    return kOk;
  });
}

swp_result swp_session_drain_samples(swp_session* session, swp_frame_sample* samples,
                                     uint32_t capacity, uint32_t* count) {
  return Use(session, [&](Session& live) {
    const swp_result wrong = CheckDrain(live, samples, capacity, count);
    if (wrong != SWP_OK) return wrong;
    uint32_t drained = 0;
    while (drained < capacity) {
      const std::optional<QueuedItem> item = live.queue.Pop();
      if (!item) break;
      if (const auto* sample = std::get_if<FrameSample>(&*item)) {
        std::memcpy(&samples[drained++], sample, sizeof *sample);
      } else {
        KeepNote(live, *item);
      }
    }
    *count = drained;
    return kOk;
  });
}

swp_result swp_session_drain_outcomes(swp_session* session, swp_switch_outcome* outcomes,
                                      uint32_t capacity, uint32_t* count) {
  return Use(session, [&](Session& live) {
    const swp_result wrong = CheckDrain(live, outcomes, capacity, count);
    if (wrong != SWP_OK) return wrong;
    uint32_t drained = 0;
    for (; drained < capacity && !live.outcomes.empty(); ++drained) {
      std::memcpy(&outcomes[drained], &live.outcomes.front(), sizeof *outcomes);
      live.outcomes.pop_front();
    }
    *count = drained;
    return kOk;
  });
}

swp_result swp_session_drain_shadow(swp_session* session, swp_shadow_sample* samples,
                                    uint32_t capacity, uint32_t* count) {
  return Use(session, [&](Session& live) {
    const swp_result wrong = CheckDrain(live, samples, capacity, count);
    if (wrong != SWP_OK) return wrong;
    uint32_t drained = 0;
    for (; drained < capacity; ++drained) {
      const std::optional<ShadowSample> sample = live.queue.PopShadow();
      if (!sample) break;
      std::memcpy(&samples[drained], &*sample, sizeof *samples);
    }
    *count = drained;
    return kOk;
  });
}

swp_result swp_session_shadow_stats(const swp_session* session, swp_shadow_stats* stats) {
  return Use(session, [&](const Session& live) {
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

swp_result swp_session_descriptor(const swp_session* session, swp_scene_descriptor* descriptor) {
  return Use(session, [&](const Session& live) {
    const SceneDescriptor& latest = live.descriptor;
    const swp_scene_descriptor now = {
        sizeof now,        latest.object_count, latest.density_ratio,    latest.size_spread,
        latest.speed_mean, latest.speed_spread, latest.clustering_ratio, latest.static_ratio};
    return Give("swp_scene_descriptor", now, descriptor);
  });
}

swp_result swp_session_post_switch(swp_session* session, const swp_switch_command* command) {
  return Use(session, [&](Session& live) {
    if (command == nullptr) return NullArgument("command");
    if (const swp_result wrong = CheckArm(live, command->arm); wrong != SWP_OK) return wrong;
    if (command->reason < SWP_SWITCH_POLICY || command->reason > SWP_SWITCH_MANUAL) {
      return Fail(SWP_INVALID_ARGUMENT, "reason must be one of SWP_SWITCH_*, 1 to 4");
    }
    if (command->command_id >= kCommandIdLimit) {
      return Fail(SWP_INVALID_ARGUMENT, "command_id must be below 2^48");
    }
    live.adaptive->mailbox().Post(
        {command->command_id, command->arm, static_cast<SwitchReason>(command->reason)});
    return kOk;
  });
}

swp_result swp_session_set_decider_present(swp_session* session, uint32_t present) {
  return Use(session, [&](Session& live) {
    if (present > 1) return Fail(SWP_INVALID_ARGUMENT, "present must be 0 or 1");
    live.adaptive->SetDeciderPresent(present == 1);
    return kOk;
  });
}

swp_result swp_session_set_posterior_means(swp_session* session, const double* means,
                                           uint32_t count) {
  return Use(session, [&](Session& live) {
    if (means == nullptr) return NullArgument("means");
    if (count != live.adaptive->arms().size()) {
      return Fail(SWP_INVALID_ARGUMENT,
                  "there must be one mean per arm: see swp_session_arm_count");
    }
    const std::span<const double> given(means, count);
    const bool valid =
        std::all_of(given.begin(), given.end(), [](double mean) { return mean >= 0 && mean <= 1; });
    if (!valid) return Fail(SWP_INVALID_ARGUMENT, "each mean must be from 0 to 1");
    live.adaptive->SetPosteriorMeans(given);
    return kOk;
  });
}

swp_result swp_session_set_verdict(swp_session* session, const swp_verdict* verdict) {
  return Use(session, [&](Session& live) {
    if (verdict == nullptr) return NullArgument("verdict");
    if (const swp_result wrong = CheckArm(live, verdict->leader_arm); wrong != SWP_OK) return wrong;
    if (verdict->kind > SWP_VERDICT_DEGRADED) {
      return Fail(SWP_INVALID_ARGUMENT, "kind must be one of SWP_VERDICT_*, 0 to 4");
    }
    if (!(verdict->leader_probability >= 0 && verdict->leader_probability <= 1)) {
      return Fail(SWP_INVALID_ARGUMENT, "leader_probability must be from 0 to 1");
    }
    live.adaptive->SetVerdict({static_cast<sweepstake::Verdict>(verdict->kind), verdict->leader_arm,
                               verdict->leader_probability});
    return kOk;
  });
}

swp_result swp_session_set_settling(swp_session* session, uint64_t settling_ns) {
  return Use(session, [&](Session& live) { live.adaptive->SetSettling(settling_ns); });
}

swp_result swp_session_set_bail_out_limit(swp_session* session, uint64_t limit_ns) {
  return Use(session, [&](Session& live) {
    if (limit_ns == 0) {
      return Fail(SWP_INVALID_ARGUMENT, "limit_ns is 0; give the longest frame in ns");
    }
    live.adaptive->SetBailOutLimit(limit_ns);
    return kOk;
  });
}
