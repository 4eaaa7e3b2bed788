// The stack that the library needs on a thread of the game, such as a fibre of its job system
// (executor.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string_view>
#include <utility>

#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"
#include "sweepstake/proxy_set.h"
#include "sweepstake/scene.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/support/stack_use.h"

namespace sweepstake {
namespace {

// Runs each part on a thread whose stack is measured.
class MeasuredParts final : public Executor {
 public:
  size_t thread_count() const noexcept override { return 4; }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    for (size_t part = 0; part < part_count; ++part) {
      most_ = std::max(most_, test_support::StackBytesOf([&] { run_part(context, part); }));
    }
    part_count_ += part_count;
  }
  size_t most() const { return most_; }
  size_t part_count() const { return part_count_; }

 private:
  size_t most_ = 0;
  size_t part_count_ = 0;
};

constexpr size_t kLimitBytes = 48 * 1024;

class StackUse : public testing::Test {
 protected:
  void SetUp() override {
    if (!SWEEPSTAKE_MEASURES_STACK) GTEST_SKIP() << "the stack is not measured";
  }
};

// A usual scene, and one so crowded that Grid and Tracy stretch their axes.
constexpr std::string_view kScenes[] = {"suite-g", "far-crowds"};

TEST_F(StackUse, PartsOfASearchNeedLittleStack) {
  for (const std::string_view name : kScenes) {
    for (const std::string_view arm : BroadPhaseNames()) {
      const auto scene = std::move(*MakeScene(name, {.object_count = 20'000}));
      MeasuredParts parts;
      const auto backend = std::move(*MakeBroadPhase(arm, {.executor = &parts}));
      PairBuffer pairs;
      backend->Build(scene->aabbs());
      backend->FindPairs(pairs);
      EXPECT_GT(parts.part_count(), 1U) << arm << " in " << name;
      EXPECT_GT(parts.most(), 0U) << arm << " in " << name;
      EXPECT_LE(parts.most(), kLimitBytes) << arm << " in " << name;
    }
  }
}

TEST_F(StackUse, PartsOfTheSearchAmongStaticProxiesNeedLittleStack) {
  const auto scene = std::move(*MakeScene("suite-g", {.object_count = 20'000}));
  MeasuredParts parts;
  ProxySet proxies({.executor = &parts});
  size_t added = 0;
  for (const Aabb& box : scene->aabbs()) proxies.Add(box, {.is_static = added++ % 2 == 0});
  proxies.Resolve({});
  EXPECT_GT(parts.part_count(), 1U);
  EXPECT_GT(parts.most(), 0U);
  EXPECT_LE(parts.most(), kLimitBytes);
}

TEST_F(StackUse, WholeCallsNeedLittleStack) {
  for (const std::string_view name : kScenes) {
    for (const std::string_view arm : BroadPhaseNames()) {
      const auto scene = std::move(*MakeScene(name, {.object_count = 10'000}));
      const auto backend = test_support::MakeOrThrow(arm);
      PairBuffer pairs;
      const size_t bytes = test_support::StackBytesOf([&] {
        backend->Build(scene->aabbs());
        backend->FindPairs(pairs);
        for (int frame = 0; frame < 3; ++frame) {
          scene->Step();
          backend->Update(scene->aabbs());
          pairs.Clear();
          backend->FindPairs(pairs);
        }
      });
      EXPECT_GT(bytes, 0U) << arm << " in " << name;
      EXPECT_LE(bytes, kLimitBytes) << arm << " in " << name;
    }
  }
}

}  // namespace
}  // namespace sweepstake
