// Tests the zones and threads that a game's hooks (hooks.h) observe in the frame path and the lane.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <memory>
#include <string_view>
#include <thread>
#include <utility>

#if defined(__linux__)
#include <pthread.h>
#endif

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/scene/suite_scene.h"
#include "sweepstake/hooks.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {
namespace {

// Counts the zones that have begun, by name, and the zones that are open.
struct Seen {
  static constexpr std::array<std::string_view, 6> kNames = {
      "sweepstake: begin frame",     "sweepstake: update",     "sweepstake: search",
      "sweepstake: resolve proxies", "sweepstake: lane visit", "sweepstake: lane preparation"};

  std::array<std::atomic<int>, kNames.size()> begun{};
  std::atomic<int> other_count{0};
  std::atomic<int> open_count{0};
  std::atomic<int> lane_count{0};
  std::atomic<bool> thread_has_its_name{false};

  int Count(std::string_view name) const {
    for (size_t k = 0; k < kNames.size(); ++k) {
      if (kNames[k] == name) return begun[k];
    }
    return 0;
  }
};

void OnBegin(const char* name, void* user) {
  Seen& seen = *static_cast<Seen*>(user);
  ++seen.open_count;
  for (size_t k = 0; k < Seen::kNames.size(); ++k) {
    if (Seen::kNames[k] != name) continue;
    ++seen.begun[k];
    return;
  }
  ++seen.other_count;
}

void OnThread(const char* name, void* user) {
  Seen& seen = *static_cast<Seen*>(user);
  if (std::string_view(name) == "swp lane") ++seen.lane_count;
  seen.thread_has_its_name = true;
#if defined(__linux__)
  char system_name[16] = {};
  pthread_getname_np(pthread_self(), system_name, sizeof system_name);
  seen.thread_has_its_name = std::string_view(system_name) == name;
#endif
}

ArmBackend SapOrKdTree(uint32_t arm) {
  return {nullptr, std::move(*MakeBroadPhase(arm == 0 ? "SAP" : "KDTree"))};
}

class ZonesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(SetHooks({.user = &seen_,
                          .zone_begin = OnBegin,
                          .zone_end = [](const char*,
                                         void* user) { --static_cast<Seen*>(user)->open_count; },
                          .thread_started = OnThread})
                    .ok());
    scene_ = MakeSuiteBrownian(200);
  }
  void TearDown() override {
    adaptive_.reset();
    scene_.reset();
    EXPECT_EQ(seen_.open_count, 0) << "each zone has ended";
    EXPECT_EQ(seen_.other_count, 0) << "hooks.h lists all zones";
    ASSERT_TRUE(SetHooks({}).ok());
  }
  void Make(ShadowMode shadow) {
    std::vector<ArmBackend> backends;
    for (uint32_t arm = 0; arm < 2; ++arm) backends.push_back(SapOrKdTree(arm));
    AdaptiveOptions options;
    options.shadow.enabled = shadow;
    const LaneParts lane{SapOrKdTree, []() noexcept { return size_t{8}; }};
    adaptive_ = std::move(
        *AdaptiveFactory::Make(options, std::move(backends), lane, nullptr, SteadyClock()));
  }
  void Frame() {
    adaptive_->BeginFrame();
    adaptive_->FindPairs(scene_->aabbs());
    adaptive_->EndFrame({.frame_time_ns = 1000});
    scene_->Step();
  }

  Seen seen_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(ZonesTest, AFrameBeginsEachOfItsZonesOnce) {
  Make(ShadowMode::kOff);
  for (int frame = 0; frame < 5; ++frame) Frame();
  EXPECT_EQ(seen_.Count("sweepstake: begin frame"), 5);
  EXPECT_EQ(seen_.Count("sweepstake: update"), 5);
  EXPECT_EQ(seen_.Count("sweepstake: search"), 5);
  EXPECT_EQ(seen_.Count("sweepstake: lane visit"), 0);
  ProxySet proxies;
  proxies.Resolve({});
  EXPECT_EQ(seen_.Count("sweepstake: resolve proxies"), 1);
}

TEST_F(ZonesTest, TheLaneHasZonesOnANamedThread) {
  Make(ShadowMode::kOn);
  while (seen_.Count("sweepstake: lane visit") < 2) Frame();
  EXPECT_EQ(seen_.lane_count, 1);
  EXPECT_TRUE(seen_.thread_has_its_name);
  for (uint64_t command = 1; seen_.Count("sweepstake: lane preparation") == 0; ++command) {
    adaptive_->mailbox().Post({.command_id = command,
                               .arm = 1 - adaptive_->active_arm(),
                               .reason = SwitchReason::kPolicy});
    for (int frame = 0; frame < 20; ++frame) {
      Frame();
      std::this_thread::yield();
    }
  }
}

}  // namespace
}  // namespace sweepstake
