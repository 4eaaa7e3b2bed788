#include "engine_client/cli/replay/replay_decision_time.h"

#include <time.h>

#include <algorithm>
#include <vector>

#include "server/decision/math/random.h"
#include "server/decision/session/decision_session.h"
#include "server/decision/study/ablations.h"

namespace sweepstake::cli {
namespace {

using decision::RandomPurpose;
using decision::RandomStream;

constexpr uint32_t kRoundCount = 5;
constexpr uint32_t kTickCount = 600;      // of a round
constexpr uint32_t kFramesPerTick = 200;  // of 10 ms

decision::SessionSetup SetupOf(const std::string& policy, uint32_t arm_count) {
  decision::SessionSetup setup;
  setup.options.policy = policy;
  for (uint32_t arm = 0; arm < arm_count; ++arm) setup.arms.push_back("arm" + std::to_string(arm));
  return setup;
}

// Arms that differ by a percent each, with 10 % of noise: nothing is ever settled.
uint64_t CostNs(uint32_t arm, RandomStream& random) {
  return static_cast<uint64_t>(9e6 * (1 + 0.01 * arm) * (0.95 + 0.1 * random.NextUniform()));
}

void Observe(decision::DecisionSession& session, uint32_t epoch, uint64_t tick,
             RandomStream& random) {
  for (uint32_t i = 0; i < kFramesPerTick; ++i) {
    decision::Frame frame{.arm = session.active_arm(), .switch_epoch = epoch};
    frame.frame_time_ns = 10'000'000;
    frame.detection_time_ns = CostNs(frame.arm, random);
    frame.object_count = 1'000;
    session.ObserveFrames({&frame, 1});
  }
  for (uint32_t arm = 0; arm < session.arms().size(); ++arm) {
    decision::ShadowSample sample{.first_frame_index = tick * kFramesPerTick};
    sample.detection_time_ns = CostNs(arm, random);
    sample.arm = arm;
    sample.object_count = 1'000;
    sample.frame_count = 5;
    if (arm == session.active_arm()) sample.flags = decision::kShadowActive;
    session.ObserveShadow({&sample, 1});
  }
}

double ThreadMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

double RoundP99Ms(const std::string& policy, uint32_t arm_count) {
  decision::DecisionSession session(SetupOf(policy, arm_count), decision::StudyPolicies());
  RandomStream random(1, RandomPurpose::kChoice, 0, 0);
  uint32_t epoch = 0;
  std::vector<double> times_ms;
  for (uint64_t tick = 0; tick < kTickCount; ++tick) {
    Observe(session, epoch, tick, random);
    const int64_t now_ns = session.next_tick_ns();
    const double begin_ms = ThreadMs();
    const decision::Decision decision = session.Tick(now_ns);
    times_ms.push_back(ThreadMs() - begin_ms);
    if (decision.command) {
      session.ObserveSwitch(decision.command->arm, ++epoch, decision.command->reason, now_ns);
    }
  }
  const auto p99 = times_ms.begin() + kTickCount * 99 / 100;
  std::nth_element(times_ms.begin(), p99, times_ms.end());
  return *p99;
}

}  // namespace

double DecisionP99Ms(const std::string& policy, uint32_t arm_count) {
  double best_ms = RoundP99Ms(policy, arm_count);
  for (uint32_t round = 1; round < kRoundCount; ++round) {
    best_ms = std::min(best_ms, RoundP99Ms(policy, arm_count));
  }
  return best_ms;
}

}  // namespace sweepstake::cli
