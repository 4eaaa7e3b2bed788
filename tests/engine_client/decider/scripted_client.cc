#include "tests/engine_client/decider/scripted_client.h"

#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {

SessionSetup PlainSetup(uint32_t arm_count) {
  SessionSetup setup;
  for (uint32_t arm = 0; arm < arm_count; ++arm) setup.arms.push_back("arm" + std::to_string(arm));
  setup.options.policy = "paper";
  setup.options.explore = false;
  return setup;
}

SessionSetup SetupThatWantsArmOne() {
  SessionSetup setup = PlainSetup(2);
  setup.priors = {{1, 1e6}, {1e6, 1}};
  return setup;
}

ScriptedClient::ScriptedClient(const SessionSetup& setup)
    : session(setup, ComparedPolicies()),
      now_ns(setup.start_ns),
      arm(setup.active_arm),
      epoch(setup.switch_epoch) {}

void ScriptedClient::RunFrame() {
  FrameSample next = frame;
  next.frame_index = frame_index++;
  next.arm = arm;
  next.switch_epoch = epoch;
  now_ns += static_cast<int64_t>(frame.frame_time_ns);
  session.ObserveFrames({&next, 1});
}

Decision ScriptedClient::RunToTick() {
  while (now_ns < session.next_tick_ns()) RunFrame();
  Decision decision = session.Tick(now_ns);
  log.push_back(decision);
  if (decision.command) {
    commands.push_back(*decision.command);
    if (obedient) Execute(decision.command->arm, decision.command->reason);
  }
  return decision;
}

Decision ScriptedClient::RunTicks(int count) {
  Decision last;
  for (int i = 0; i < count; ++i) last = RunToTick();
  return last;
}

void ScriptedClient::Settle() { RunTicks(2); }

void ScriptedClient::Execute(uint32_t new_arm, SwitchReason reason) {
  arm = new_arm;
  session.ObserveSwitch(arm, ++epoch, reason, now_ns);
}

}  // namespace sweepstake::decision
