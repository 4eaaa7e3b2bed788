#include <cstddef>
#include <utility>

#include "engine_client/c_api/boundary.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/c_daemon.h"
#include "sweepstake/frame_sample.h"

namespace {

// This file compares the layouts of the C structs and the C++ structs.
using namespace sweepstake;  // NOLINT(google-build-using-namespace)

// The C structs and the C++ structs have the same layout, because pointers to one are cast to the
// other.
static_assert(sizeof(swp_aabb) == sizeof(Aabb) && sizeof(swp_aabb) == 24);
static_assert(sizeof(swp_pair) == sizeof(OverlapPair) && sizeof(swp_pair) == 8);
static_assert(sizeof(swp_frame_sample) == sizeof(FrameSample) && sizeof(swp_frame_sample) == 64);
static_assert(offsetof(swp_frame_sample, native_bytes) == offsetof(FrameSample, native_bytes));
static_assert(offsetof(swp_frame_sample, pair_count) == offsetof(FrameSample, pair_count));
static_assert(offsetof(swp_frame_sample, arm) == offsetof(FrameSample, arm));
static_assert(offsetof(swp_frame_sample, flags) == offsetof(FrameSample, flags));
static_assert(sizeof(swp_switch_command) == 16);
static_assert(sizeof(swp_switch_outcome) == 40);  // it has no members about trials
static_assert(offsetof(swp_switch_outcome, settling_cost_ns) ==
              offsetof(SwitchOutcome, settling_cost_ns));
static_assert(offsetof(swp_switch_outcome, executed) == offsetof(SwitchOutcome, executed));
static_assert(SWP_SHADOW_OFF == static_cast<int>(ShadowMode::kOff));
static_assert(SWP_SHADOW_AUTO == static_cast<int>(ShadowMode::kAuto));
static_assert(SWP_SHADOW_ON == static_cast<int>(ShadowMode::kOn));
static_assert(SWP_SHADOW_STATE_OFF == static_cast<int>(ShadowState::kOff));
static_assert(SWP_SHADOW_STATE_NO_SPARE_CORE == static_cast<int>(ShadowState::kNoSpareCore));
static_assert(SWP_SHADOW_STATE_PAUSED == static_cast<int>(ShadowState::kPaused));
static_assert(SWP_SHADOW_STATE_RUNNING == static_cast<int>(ShadowState::kRunning));
static_assert(SWP_SHADOW_STATE_TOO_BIG == static_cast<int>(ShadowState::kTooBig));
static_assert(sizeof(swp_verdict) == 16);
static_assert(SWP_VERDICT_UNKNOWN == static_cast<int>(Verdict::kUnknown));
static_assert(SWP_VERDICT_STABLE == static_cast<int>(Verdict::kStable));
static_assert(SWP_VERDICT_TIE == static_cast<int>(Verdict::kTie));
static_assert(SWP_VERDICT_AMBIGUOUS == static_cast<int>(Verdict::kAmbiguous));
static_assert(SWP_VERDICT_DEGRADED == static_cast<int>(Verdict::kDegraded));
static_assert(SWP_MODE_MANUAL == static_cast<int>(Mode::kManual));
static_assert(SWP_MODE_AI == static_cast<int>(Mode::kAi));
static_assert(SWP_SWITCH_POLICY == static_cast<int>(SwitchReason::kPolicy));
static_assert(SWP_SWITCH_EXPLORATION == static_cast<int>(SwitchReason::kExploration));
static_assert(SWP_SWITCH_BAIL_OUT == static_cast<int>(SwitchReason::kBailOut));
static_assert(SWP_SWITCH_MANUAL == static_cast<int>(SwitchReason::kManual));
static_assert(static_cast<int>(SWP_FRAME_REBUILD) == kFrameRebuild);
static_assert(static_cast<int>(SWP_FRAME_PAUSED) == kFramePaused);
static_assert(static_cast<int>(SWP_FRAME_LOADING) == kFrameLoading);
static_assert(static_cast<int>(SWP_FRAME_BAIL_OUT) == kFrameBailOut);
static_assert(static_cast<int>(SWP_FRAME_SUSPENDED) == kFrameSuspended);
static_assert(static_cast<int>(SWP_FRAME_PAIRS_EXCEEDED) == kFramePairsExceeded);

constexpr std::pair<swp_struct, uint32_t> kStructSizes[] = {
    {SWP_STRUCT_AABB, sizeof(swp_aabb)},
    {SWP_STRUCT_PAIR, sizeof(swp_pair)},
    {SWP_STRUCT_COUNTERS, sizeof(swp_counters)},
    {SWP_STRUCT_DAEMON_OPTIONS, sizeof(swp_daemon_options)},
    {SWP_STRUCT_HOOKS, sizeof(swp_hooks)},
    {SWP_STRUCT_LINK_OPTIONS, sizeof(swp_link_options)},
    {SWP_STRUCT_LINK_STATS, sizeof(swp_link_stats)},
    {SWP_STRUCT_SCENE_OPTIONS, sizeof(swp_scene_options)},
    {SWP_STRUCT_SESSION_OPTIONS, sizeof(swp_session_options)},
    {SWP_STRUCT_FRAME_SAMPLE, sizeof(swp_frame_sample)},
    {SWP_STRUCT_SWITCH_COMMAND, sizeof(swp_switch_command)},
    {SWP_STRUCT_SWITCH_OUTCOME, sizeof(swp_switch_outcome)},
    {SWP_STRUCT_DECIDER_OPTIONS, sizeof(swp_decider_options)},
    {SWP_STRUCT_BELIEF, sizeof(swp_belief)},
    {SWP_STRUCT_EXECUTOR, sizeof(swp_executor)},
    {SWP_STRUCT_WORLD_OPTIONS, sizeof(swp_world_options)},
    {SWP_STRUCT_PROXIES_OPTIONS, sizeof(swp_proxies_options)},
    {SWP_STRUCT_FILTER, sizeof(swp_filter)},
    {SWP_STRUCT_PROXY_OPTIONS, sizeof(swp_proxy_options)},
    {SWP_STRUCT_PROXY_PAIR, sizeof(swp_proxy_pair)},
    {SWP_STRUCT_RAY, sizeof(swp_ray)},
    {SWP_STRUCT_SPHERE, sizeof(swp_sphere)},
    {SWP_STRUCT_BOX_SWEEP, sizeof(swp_box_sweep)},
    {SWP_STRUCT_RAY_HIT, sizeof(swp_ray_hit)},
    {SWP_STRUCT_SHADOW_STATS, sizeof(swp_shadow_stats)},
    {SWP_STRUCT_DECISION, sizeof(swp_decision)},
    {SWP_STRUCT_VERDICT, sizeof(swp_verdict)},
    {SWP_STRUCT_REWARD_WEIGHTS, sizeof(swp_reward_weights)},
};

}  // namespace

uint32_t swp_abi_version(void) { return SWP_ABI_VERSION; }
uint32_t swp_abi_revision(void) { return SWP_ABI_REVISION; }

swp_result swp_version(uint32_t* major, uint32_t* minor, uint32_t* patch) {
  if (major == nullptr || minor == nullptr || patch == nullptr) {
    return c_api::NullArgument("major, minor and patch");
  }
  *major = SWP_VERSION_MAJOR;
  *minor = SWP_VERSION_MINOR;
  *patch = SWP_VERSION_PATCH;
  return SWP_OK;
}

uint32_t swp_struct_size(swp_struct which) {
  for (const auto& [known, size] : kStructSizes) {
    if (known == which) return size;
  }
  return 0;
}
