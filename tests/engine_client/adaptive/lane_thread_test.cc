// Tests the lane's own thread: it has the lowest priority on a shared core, stops if no core is
// spare, and measures its thread time.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "engine_client/adaptive/shadow_lane.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/host/usable_cores.h"
#include "tests/engine_client/adaptive/driven_lane.h"
#include "tests/support/recording_sink.h"
#include "tests/support/scripted_broad_phase.h"
#include "tests/support/scripted_clock.h"

#if defined(__linux__)
#include <sched.h>
#include <sys/resource.h>
#endif

namespace sweepstake {
namespace {

using test_support::ArmScript;
using test_support::kMs;
using test_support::RecordingSink;
using test_support::ScriptedBroadPhase;
using test_support::ScriptedClock;
using test_support::ThreeMsAtATime;

ArmBackendFactory Making(const ArmScript& script, ScriptedClock& clock) {
  return [&](uint32_t) {
    return ArmBackend{nullptr, std::make_unique<ScriptedBroadPhase>(script, clock)};
  };
}

// Runs frames of 10 ms, each followed by a step of the lane.
void Play(ShadowLane& lane, ScriptedClock& clock, uint64_t& frame, uint64_t frame_count) {
  for (const uint64_t end = frame + frame_count; frame < end; ++frame) {
    clock.Advance(10 * kMs);
    lane.OnFrame(std::vector<Aabb>(20),
                 {.frame_index = frame, .frame_time_ns = 10 * kMs, .arm = 1});
    lane.Step();
  }
}

std::atomic<size_t> cores_now{0};

TEST(LaneThread, PausesWithoutASpareCore) {
  ScriptedClock clock;
  const ArmScript script{.update_ns = kMs};
  const std::atomic<Mode> mode{Mode::kAi};
  cores_now = 4;
  ShadowLane lane({.options = {},
                   .arm_count = 2,
                   .make = Making(script, clock),
                   .clock = clock,
                   .mode = mode,
                   .engine_threads = 4,
                   .usable_cores = []() noexcept { return cores_now.load(); }});
  uint64_t frame = 0;
  const auto play = [&](uint64_t count) { Play(lane, clock, frame, count); };
  EXPECT_EQ(lane.stats().state, ShadowState::kNoSpareCore);
  play(200);
  EXPECT_EQ(lane.stats().visit_count, 0U);
  EXPECT_EQ(lane.Ask(0), ShadowLane::Preparation::kNever);
  cores_now = 5;  // more cores are available from now on
  play(200);
  EXPECT_EQ(lane.stats().state, ShadowState::kRunning);
  EXPECT_GE(lane.stats().visit_count, 2U);
  cores_now = 1;
  play(200);
  const uint64_t visit_count = lane.stats().visit_count;
  EXPECT_EQ(lane.stats().state, ShadowState::kNoSpareCore);
  play(200);
  EXPECT_EQ(lane.stats().visit_count, visit_count);
}

TEST(LaneThread, PausesWhileTheGameIsFrozen) {
  ScriptedClock clock;
  const ArmScript script{.update_ns = kMs};
  const std::atomic<Mode> mode{Mode::kAi};
  std::atomic<bool> frozen{false};
  ShadowLane lane({.options = {},
                   .arm_count = 2,
                   .make = Making(script, clock),
                   .clock = clock,
                   .mode = mode,
                   .frozen = &frozen});
  uint64_t frame = 0;
  while (lane.stats().sweep_count == 0) Play(lane, clock, frame, 1);
  clock.Advance(3'600'000 * kMs);
  lane.Step();
  const auto awaiting_frames = lane.Step();
  frozen = true;
  EXPECT_GT(lane.Step(), awaiting_frames) << "the lane stops waiting for frames";
  EXPECT_EQ(lane.stats().state, ShadowState::kPaused);
  EXPECT_EQ(lane.Ask(0), ShadowLane::Preparation::kNever);
  frozen = false;
  const uint64_t sweep_count = lane.stats().sweep_count;
  Play(lane, clock, frame, 200);
  EXPECT_GT(lane.stats().sweep_count, sweep_count);
}

// The result of a lane's first sweep over two arms.
struct FirstSweep {
  FirstSweep(const ArmScript& script, uint64_t (*thread_time_ns)() noexcept,
             double (*core_speed)() noexcept) {
    ScriptedClock clock;
    RecordingSink sink;
    const std::atomic<Mode> mode{Mode::kAi};
    ShadowLane lane({.options = {},
                     .arm_count = 2,
                     .make = Making(script, clock),
                     .sink = &sink,
                     .clock = clock,
                     .mode = mode,
                     .thread_time_ns = thread_time_ns,
                     .core_speed = core_speed});
    lane.Step();
    uint64_t frame = 0;
    Play(lane, clock, frame, 1 + kShadowBurstFrames);
    visits = sink.shadows;
    busy_time_ns = lane.stats().busy_time_ns;
  }

  std::vector<ShadowSample> visits;
  uint64_t busy_time_ns = 0;
};

TEST(LaneThread, MeasuresItsThreadTime) {
  const FirstSweep sweep({.update_ns = 7 * kMs}, ThreeMsAtATime, nullptr);
  ASSERT_EQ(sweep.visits.size(), 2U);
  for (const ShadowSample& visit : sweep.visits) EXPECT_EQ(visit.detection_time_ns, 3 * kMs);
  EXPECT_EQ(sweep.busy_time_ns, (2 * kShadowBurstFrames + 1) * 3 * kMs);
}

TEST(LaneThread, ConvertsTimesToTheFastestKindOfCore) {
  const FirstSweep sweep({.build_ns = 12 * kMs, .update_ns = 8 * kMs}, nullptr,
                         []() noexcept { return 0.25; });
  ASSERT_EQ(sweep.visits.size(), 2U);
  for (const ShadowSample& visit : sweep.visits) {
    EXPECT_EQ(visit.detection_time_ns, 2 * kMs);
    EXPECT_EQ(visit.build_time_ns, 3 * kMs);
  }
}

TEST(UsableCores, AreAtLeastOneAndAtMostAllOfTheMachine) {
  EXPECT_GE(UsableCores(), 1U);
  EXPECT_LE(UsableCores(), std::max(std::thread::hardware_concurrency(), 1U));
}

#if defined(__linux__)

TEST(UsableCores, RespectTheAffinityOfTheThread) {
  size_t cores = 0;
  std::thread pinned([&] {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<size_t>(sched_getcpu()), &set);
    EXPECT_EQ(sched_setaffinity(0, sizeof set, &set), 0);
    cores = UsableCores();
  });
  pinned.join();
  EXPECT_EQ(cores, 1U);
}

struct LanePriority {
  std::atomic<int> lane_nice{-100};
};

TEST(LaneThread, HasALowerPriorityThanTheGame) {
  LanePriority seen;
  const auto note = [](const char*, void* user) {
    static_cast<LanePriority*>(user)->lane_nice = getpriority(PRIO_PROCESS, 0);
  };
  ASSERT_TRUE(SetHooks({.user = &seen, .thread_started = note}).ok());
  {
    const std::atomic<Mode> mode{Mode::kManual};
    ShadowLane lane({.options = {},
                     .arm_count = 2,
                     .make = [](uint32_t) { return ArmBackend{}; },
                     .clock = SteadyClock(),
                     .mode = mode});
    lane.Start();
    while (seen.lane_nice == -100) std::this_thread::yield();
  }
  ASSERT_TRUE(SetHooks({}).ok());
  const int own = getpriority(PRIO_PROCESS, 0);
  EXPECT_EQ(seen.lane_nice, std::min(own + 10, 19));
}

#endif

}  // namespace
}  // namespace sweepstake
