// Frames and decisions in every floating-point environment that a game may have set are those of
// the default one. Code in KeepsMode's braces must not compute with floating-point numbers itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/scene/box_scenes.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/session.h"
#include "tests/support/float_modes.h"
#include "tests/support/recording_sink.h"
#include "tests/support/scripted_clock.h"

namespace sweepstake {
namespace {

using test_support::FloatMode;
using test_support::FloatModes;
using test_support::KeepsMode;

class DecisionsInEachFloatMode : public testing::TestWithParam<FloatMode> {};

// Returns the audit log of ten minutes of a game, its beliefs and its priors. The arms' costs swap
// every two minutes, and one frame is a bail-out.
std::string DecisionsOf(const std::string& policy) {
  std::string log;
  EmbeddedOptions options;
  options.policy = policy;
  options.source_id = "test";
  options.machine_class = "test";
  options.on_audit_row = [&](std::string_view row) { log.append(row).push_back('\n'); };
  const std::vector<std::string> arms = {"SAP", "DBVT", "KDTree"};
  const std::vector<uint32_t> versions = {1, 1, 1};
  const auto decider = std::move(*EmbeddedDecider::Create(options, arms, versions, 0));
  constexpr uint64_t kDetectionMs[2][3] = {{9, 4, 5}, {3, 8, 5}};
  FrameSample frame{.object_count = 1000};
  for (uint64_t now_ns = 0; now_ns < 600'000 * test_support::kMs; ++frame.frame_index) {
    const uint64_t regime = now_ns / (120'000 * test_support::kMs) % 2;
    frame.detection_time_ns =
        (kDetectionMs[regime][frame.arm] * 1000 + frame.frame_index * 7919 % 500) * 1000;
    frame.frame_time_ns = frame.detection_time_ns + 12 * test_support::kMs;
    frame.flags = 0;
    if (frame.frame_index == 9000) {
      frame.frame_time_ns = frame.detection_time_ns = 6'000 * test_support::kMs;
      frame.flags = kFrameBailOut;
    }
    now_ns += frame.frame_time_ns;
    decider->Observe(std::span<const FrameSample>(&frame, 1), now_ns);
    decider->Observe(SceneDescriptor{.object_count = 1000,
                                     .density_ratio = regime == 0 ? 0.1F : 0.4F,
                                     .size_spread = 0.5F,
                                     .speed_mean = 1e-3F,
                                     .speed_spread = 1e-40F,
                                     .clustering_ratio = 1,
                                     .static_ratio = 0});
    const ShadowSample shadow{
        .first_frame_index = frame.frame_index / 30 * 30,
        .detection_time_ns = kDetectionMs[regime][frame.frame_index % 3] * test_support::kMs,
        .build_time_ns = 20 * test_support::kMs,
        .arm = static_cast<uint32_t>(frame.frame_index % 3),
        .object_count = 1000,
        .frame_count = 8,
        .flags = frame.frame_index % 3 == frame.arm ? kShadowActive : 0U};
    if (frame.frame_index % 30 < 3) decider->Observe({&shadow, 1});
    if (const auto command = decider->Poll(now_ns)) {
      if (command->arm != frame.arm) ++frame.switch_epoch;
      frame.arm = command->arm;
      decider->Observe(SwitchOutcome{.command_id = command->command_id,
                                     .arm = frame.arm,
                                     .switch_epoch = frame.switch_epoch,
                                     .reason = command->reason,
                                     .executed = 1},
                       now_ns);
    }
  }
  for (const ArmBelief& belief : decider->beliefs()) {
    for (const double value : {belief.alpha, belief.beta}) {
      log += std::to_string(std::bit_cast<uint64_t>(value)) + '\n';
    }
  }
  return log + decider->ExportPriors();
}

TEST_P(DecisionsInEachFloatMode, AreThoseOfTheDefaultEnvironment) {
  for (const std::string policy : {"paper", "default"}) {
    static std::map<std::string, std::string> expected;  // by policy
    if (expected[policy].empty()) expected[policy] = DecisionsOf(policy);
    std::string found;
    EXPECT_TRUE(KeepsMode(GetParam(), [&] { found = DecisionsOf(policy); }));
    EXPECT_EQ(std::hash<std::string>()(found), std::hash<std::string>()(expected[policy]))
        << policy;
  }
}

TEST(DecisionsInFloatModes, TheScriptedGameSwitchesAndLogs) {
  const std::string log = DecisionsOf("default");
  EXPECT_GT(std::ranges::count(log, '\n'), 300);
  EXPECT_EQ(log, DecisionsOf("default"));
  EXPECT_NE(log, DecisionsOf("paper"));
}

// Returns the samples, descriptors, switch outcomes and pairs of some frames. Every tenth frame
// switches; it and the next one take longer. One frame is a bail-out without a decider.
std::string FramesOf(const std::vector<std::vector<Aabb>>& frames) {
  constexpr size_t kBailOutFrame = 75;
  test_support::RecordingSink sink;
  test_support::ScriptedClock clock;
  AdaptiveOptions options;
  options.shadow.enabled = ShadowMode::kOff;
  options.settling_ns = 64 * test_support::kMs;
  const auto adaptive = std::move(*AdaptiveBroadPhase::Create(options, &sink, clock));
  adaptive->SetPosteriorMeans(std::vector<double>{0.1, 0.2, 0.7, 0.3, 0.4, 0.5, 0.6});
  std::string bytes;
  for (size_t frame = 0; frame < frames.size(); ++frame) {
    const bool bails_out = frame == kBailOutFrame;
    if (frame % 10 == 9) {
      (void)adaptive->SelectArm(adaptive->arms()[frame / 10 % adaptive->arms().size()]);
    }
    adaptive->BeginFrame();
    clock.SetReading(bails_out ? kBailOutNs : 1000);
    for (const OverlapPair& pair : adaptive->FindPairs(frames[frame])) {
      bytes.append(reinterpret_cast<const char*>(&pair), sizeof pair);
    }
    const uint64_t frame_ms = (frame + 1) % 10 < 2 ? 21 : 16;
    adaptive->EndFrame(
        {.frame_time_ns = bails_out ? 2 * kBailOutNs : frame_ms * test_support::kMs});
  }
  for (const FrameSample& sample : sink.frames) {
    bytes.append(reinterpret_cast<const char*>(&sample), sizeof sample);
  }
  for (const SceneDescriptor& descriptor : sink.descriptors) {
    bytes.append(reinterpret_cast<const char*>(&descriptor), sizeof descriptor);
  }
  for (const SwitchOutcome& outcome : sink.switches) {
    bytes += std::to_string(outcome.arm) + ' ' + std::to_string(outcome.settling_cost_ns) + '\n';
  }
  EXPECT_GT(sink.descriptors.size(), 0U);
  EXPECT_TRUE(std::ranges::any_of(
      sink.switches, [](const SwitchOutcome& outcome) { return outcome.settling_cost_ns > 0; }));
  EXPECT_EQ(sink.frames[kBailOutFrame + 1].arm, 2U) << "the arm with the highest mean";
  return bytes;
}

TEST_P(DecisionsInEachFloatMode, FramesHaveTheSamplesAndDescriptorsOfTheDefaultEnvironment) {
  static const std::vector<std::vector<Aabb>> frames = [] {
    BoxScene scene("mixture", 300, 5);
    std::vector<std::vector<Aabb>> made;
    for (int frame = 0; frame < 150; ++frame, scene.Step()) {
      made.emplace_back(scene.boxes().begin(), scene.boxes().end());
    }
    return made;
  }();
  static const std::string expected = FramesOf(frames);
  std::string found;
  EXPECT_TRUE(KeepsMode(GetParam(), [&] { found = FramesOf(frames); }));
  EXPECT_EQ(found == expected, true);
}

TEST_P(DecisionsInEachFloatMode, OptionsThatAreNanAreRefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::string> arms = {"SAP", "DBVT"};
  const std::vector<uint32_t> versions = {1, 1};
  StatusCode decider = StatusCode::kOk;
  StatusCode session = StatusCode::kOk;
  EXPECT_TRUE(KeepsMode(GetParam(), [&] {
    EmbeddedOptions embedded;
    embedded.time_scale = kNan;
    decider = EmbeddedDecider::Create(embedded, arms, versions, 0).status().code();
    SessionOptions options;
    options.time_scale = kNan;
    session = MakeEmbeddedSession({}, options).status().code();
  }));
  EXPECT_EQ(decider, StatusCode::kInvalidArgument);
  EXPECT_EQ(session, StatusCode::kInvalidArgument);
}

// The sender thread starts in the environment of the thread that calls Start.
TEST_P(DecisionsInEachFloatMode, ASessionDecidesOnItsThread) {
  std::string priors;
  EXPECT_TRUE(KeepsMode(GetParam(), [&] {
    EmbeddedOptions embedded;
    embedded.decision_interval_ns = 1;
    const auto session = std::move(*MakeEmbeddedSession(embedded, {}));
    const auto adaptive = std::move(*AdaptiveBroadPhase::Create({}, &session->sink()));
    if (!session->Start(*adaptive).ok()) return;
    constexpr Aabb kBox = {{0, 0, 0}, {1, 1, 1}};
    for (int frame = 0; frame < 300; ++frame) {
      adaptive->BeginFrame();
      adaptive->FindPairs({&kBox, 1});
      adaptive->EndFrame({.frame_time_ns = 16 * test_support::kMs});
    }
    session->Stop();
    priors = *session->ExportPriors();
  }));
  EXPECT_NE(priors, "");
}

INSTANTIATE_TEST_SUITE_P(, DecisionsInEachFloatMode, testing::ValuesIn(FloatModes()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace sweepstake
