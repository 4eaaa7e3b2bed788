// How long the decision core takes for one decision on this machine: processor time of the thread,
// which does not count what other programs take.
#pragma once

#include <cstdint>
#include <string>

namespace sweepstake::cli {

// The time that 99 % of the ticks stay below, in milliseconds: `arm_count` arms, each tick with a
// window of frames and a sweep of the shadow lane over all arms to learn from. The best of a few
// rounds, since others may use the machine. Takes some seconds. REQUIRES: one of PolicyNames(); 1
// to kMaxArms arms.
double DecisionP99Ms(const std::string& policy, uint32_t arm_count);

}  // namespace sweepstake::cli
