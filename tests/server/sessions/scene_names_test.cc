// Tests a client that names a new scene in every session. The environment variable TEST_NAMES sets
// the number of names. The suite uses 20,000; tests/README.md has the command for a million.
#include <unistd.h>

#include <fstream>
#include <memory>
#include <vector>

#include "server/rpc/common/error_reasons.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/rpc/services/prompt_daemon.h"
#include "tests/support/sanitizers/active.h"
#include "tests/support/size_of_run.h"

namespace sweepstake::rpc {
namespace {

constexpr uint64_t kMaxGrowthBytes = 50 << 20;

uint64_t ResidentBytes() {
  uint64_t pages = 0;
  std::ifstream statm("/proc/self/statm");
  statm >> pages >> pages;
  return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

v1::Hello HelloOf(uint64_t scene) {
  v1::Hello hello = OneArmHello();
  hello.set_scene("scene " + std::to_string(scene));
  return hello;
}

class SceneNamesTest : public ::testing::Test {
 protected:
  SceneNamesTest() { daemon_.options.max_scenes = 100; }
  // Opens streams of new scenes, which stay open, until one is refused. Returns how many were
  // accepted.
  size_t OpenUntilRefused() {
    const size_t before = streams_.size();
    while (streams_.size() < 1'000) {
      auto stream = std::make_unique<PromptStream>(daemon_);
      stream->Send(Request(HelloOf(next_scene_++)));
      if (stream->end()) {
        EXPECT_EQ(ReasonOfRefusal(*stream->end()), v1::ERROR_REASON_TOO_MANY_SCENES);
        return streams_.size() - before;
      }
      streams_.push_back(std::move(stream));
    }
    ADD_FAILURE() << "none was refused";
    return streams_.size() - before;
  }
  void Open(size_t count, const std::string& project = "game") {
    for (; count > 0; --count) {
      v1::Hello hello = HelloOf(next_scene_++);
      hello.set_project(project);
      streams_.push_back(std::make_unique<PromptStream>(daemon_));
      EXPECT_TRUE(streams_.back()->Send(Request(hello)));
    }
  }
  void Decide() {
    daemon_.Advance(daemon_.options.decision.decision_interval_ns);
    daemon_.Advance(daemon_.options.decision.decision_interval_ns);
  }
  void Learn(PromptStream& stream) {
    EXPECT_TRUE(stream.Send(Frames(1, 30)));
    Decide();
  }
  void LearnAll() {
    for (const auto& stream : streams_) EXPECT_TRUE(stream->Send(Frames(1, 30)));
    Decide();
  }

  static RpcOptions Prompt() {
    RpcOptions options;
    options.decision.explore = false;
    options.decision.settling_ns = 0;
    return options;
  }
  PromptDaemon daemon_{Prompt()};
  uint64_t next_scene_ = 0;
  std::vector<std::unique_ptr<PromptStream>> streams_;
};

TEST_F(SceneNamesTest, ScenesOfSilentSessionsCount) {
  EXPECT_EQ(OpenUntilRefused(), 100u);
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->names, 0u);
  PromptStream known(daemon_);
  EXPECT_TRUE(known.Send(Request(HelloOf(3)))) << "this name already counts";
  v1::Hello other = HelloOf(next_scene_);
  other.set_project("other");
  PromptStream elsewhere(daemon_);
  EXPECT_TRUE(elsewhere.Send(Request(other)));
}

TEST_F(SceneNamesTest, AStoredSceneCountsOnceAndALostSessionsSceneStopsCountingWithIt) {
  daemon_.options.resume_window_ns = 60 * kSecondNs;
  EXPECT_EQ(OpenUntilRefused(), 100u);
  for (size_t i = 0; i < 40; ++i) Learn(*streams_[i]);
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->names, 40u);
  EXPECT_EQ(OpenUntilRefused(), 0u) << "40 stored, 60 in memory";
  streams_.clear();
  EXPECT_EQ(OpenUntilRefused(), 0u) << "lost sessions may be resumed";
  daemon_.Advance(70 * kSecondNs);
  daemon_.Advance(70 * kSecondNs);
  EXPECT_EQ(OpenUntilRefused(), 60u);
}

TEST_F(SceneNamesTest, ScenesStoredDuringTheReadOfAHelloCountExactlyOnce) {
  Open(99);
  daemon_.store.HoldReads();
  PromptStream last(daemon_);
  last.Send(Request(HelloOf(next_scene_++)));
  PromptStream beyond(daemon_);
  beyond.Send(Request(HelloOf(next_scene_++)));
  LearnAll();
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->names, 99u);
  daemon_.store.EndReads();
  daemon_.Advance(0);
  EXPECT_TRUE(last.welcomed());
  ASSERT_TRUE(beyond.end());
  EXPECT_EQ(ReasonOfRefusal(*beyond.end()), v1::ERROR_REASON_TOO_MANY_SCENES);
}

TEST_F(SceneNamesTest, ScenesOfAnotherProjectDoNotCount) {
  Open(100, "other");
  daemon_.store.HoldReads();
  PromptStream first(daemon_);
  first.Send(Request(HelloOf(next_scene_++)));
  LearnAll();
  daemon_.store.EndReads();
  daemon_.Advance(0);
  EXPECT_TRUE(first.welcomed());
}

TEST_F(SceneNamesTest, ProjectsOfSilentSessionsCount) {
  daemon_.options.max_projects = 2;
  const auto opens = [&](const std::string& project) {
    v1::Hello hello = HelloOf(next_scene_++);
    hello.set_project(project);
    PromptStream stream(daemon_);
    return stream.Send(Request(hello));
  };
  Open(2, "a");
  Open(1, "b");
  EXPECT_TRUE(opens("a")) << "another scene of a project that already counts";
  EXPECT_FALSE(opens("c"));
  LearnAll();
  EXPECT_EQ(*daemon_.store.store.CountProjects(), 2u);
  EXPECT_TRUE(opens("b"));
  EXPECT_FALSE(opens("c"));
  daemon_.options.max_projects = 3;
  EXPECT_TRUE(opens("c")) << "each of the stored ones counts once";
}

TEST_F(SceneNamesTest, ProjectsCountEvenIfTheStoreIsTooSlow) {
  daemon_.options.max_projects = 2;
  const auto opens_slowly = [&](const std::string& project) {
    v1::Hello hello = HelloOf(next_scene_++);
    hello.set_project(project);
    streams_.push_back(std::make_unique<PromptStream>(daemon_));
    streams_.back()->Send(Request(hello));
    daemon_.Advance(daemon_.options.load_patience_ns);
    return streams_.back()->welcomed();
  };
  Open(2, "a");
  Learn(*streams_[0]);
  daemon_.store.HoldReads();
  EXPECT_TRUE(opens_slowly("a"));
  daemon_.store.EndReads();
  Open(1, "b");
  EXPECT_EQ(*daemon_.store.store.CountProjects(), 1u) << "this project must not also count as held";
  daemon_.store.HoldReads();
  EXPECT_TRUE(opens_slowly("b"));
  EXPECT_TRUE(opens_slowly("c")) << "the store has not answered which projects it has";
  EXPECT_FALSE(opens_slowly("d"));
  const auto& refusal = streams_.back()->end();
  ASSERT_TRUE(refusal);
  EXPECT_EQ(ReasonOfRefusal(*refusal), v1::ERROR_REASON_TOO_MANY_PROJECTS);
  daemon_.store.EndReads();
}

TEST_F(SceneNamesTest, AMillionSceneNamesCostNoMemory) {
  const uint64_t count = test_support::FromEnvironment("TEST_NAMES", 20'000);
  EXPECT_EQ(OpenUntilRefused(), 100u);
  for (const auto& stream : streams_) Learn(*stream);
  [[maybe_unused]] const uint64_t before = ResidentBytes();
  for (uint64_t i = 0; i < count; ++i) {
    PromptStream stream(daemon_);
    stream.Send(Request(HelloOf(next_scene_++)));
    ASSERT_TRUE(stream.end() && absl::IsResourceExhausted(*stream.end()));
    ASSERT_EQ(ReasonOfRefusal(*stream.end()), v1::ERROR_REASON_TOO_MANY_SCENES);
    if (i % 1'000 == 0) daemon_.Advance(kSecondNs);
  }
  daemon_.Advance(kSecondNs);
#if !SWEEPSTAKE_ASAN && !SWEEPSTAKE_TSAN  // sanitizers keep freed memory
  EXPECT_LT(ResidentBytes(), before + kMaxGrowthBytes);
#endif
  EXPECT_EQ(daemon_.sessions.size(), 100u);
  EXPECT_EQ(daemon_.sessions.new_scenes().size(), 0u);
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->names, 100u);
}

}  // namespace
}  // namespace sweepstake::rpc
