// The members of a setup's cell (cells.h) in their order, for the writer and the reader.
#pragma once

#include "engine_client/decider/audit/cells.h"

namespace sweepstake::decision {

// Calls visit(key, member) for every member. A new member does not compile until it is here.
template <EitherConst<DecisionOptions> Options, typename Visit>
void VisitOptions(Options& options, Visit& visit) {
  auto& [policy, weights, decision_interval_ns, cooldown_ns, settling_ns, bail_out_ns,
         exploration_warm_up_ns, exploration_measure_ns, explore, bail_out_penalty, fps_floor] =
      options;
  auto& [weight_fps, weight_detection, weight_memory, weight_checks] = weights;
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
}

template <EitherConst<SessionSetup> Setup, typename Visit>
void VisitSetup(Setup& setup, Visit& visit) {
  auto& [options, arms, priors, seed, mode, active_arm, switch_epoch, start_ns, explored_arm_count,
         decision_count] = setup;
  visit("arms", arms);
  VisitOptions(options, visit);
  visit("priors", priors);
  visit("seed", seed);
  visit("mode", mode);
  visit("active_arm", active_arm);
  visit("switch_epoch", switch_epoch);
  visit("start_ns", start_ns);
  visit("explored_arm_count", explored_arm_count);
  visit("decision_count", decision_count);
}

// Calls visit.IfAny for a list that is omitted if it is empty.
template <EitherConst<AuditOrigin> Origin, typename Visit>
void VisitOrigin(Origin& origin, Visit& visit) {
  visit("project", origin.project);
  visit("scene", origin.scene);
  visit("machine_class", origin.machine_class);
  visit("program_version", origin.program_version);
  visit("backend_versions", origin.backend_versions);
  visit("unix_start_ms", origin.unix_start_ms);
  visit.IfAny("prior_sources", origin.prior_sources);
}

}  // namespace sweepstake::decision
