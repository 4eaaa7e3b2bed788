// A game that the system really stops (SIGSTOP) within a search and between two searches.
#if defined(__linux__)

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <memory>
#include <thread>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "sweepstake/embedded_decider.h"

namespace sweepstake {
namespace {

constexpr uint64_t kLimitNs = 500'000'000;
constexpr std::chrono::seconds kStop{2};

// An arm that finds nothing. Stops the process in a search if the test wants it.
class StoppingArm final : public BroadPhase {
 public:
  explicit StoppingArm(std::string_view name) : name_(name) {}

  std::string_view name() const override { return name_; }
  uint32_t version() const override { return 1; }
  void DoBuild(std::span<const Aabb>) override {}
  void DoUpdate(std::span<const Aabb>) override {}
  void DoFindPairs(PairBuffer&) override {
    if (stops) raise(SIGSTOP);
  }
  uint64_t aabb_check_count() const override { return 0; }
  size_t native_bytes() const override { return 0; }

  bool stops = false;

 private:
  const std::string_view name_;
};

// What the child process reports to the test.
struct GameReport {
  bool is_complete;
  std::array<FrameSample, 4> frames;
  std::array<double, 2> beta_before;
  std::array<double, 2> beta_after;
  uint64_t decision_count;
};

// Passes frames to the decider as soon as they end.
class DeciderFeed final : public FrameSink {
 public:
  explicit DeciderFeed(EmbeddedDecider& decider) : decider_(decider) {}
  void OnFrame(const FrameSample& sample) noexcept override {
    decider_.Observe(std::span(&sample, 1), SteadyClock().NowNs());
  }
  void OnDescriptor(const SceneDescriptor&) noexcept override {}
  void OnSwitch(const SwitchOutcome&) noexcept override {}

 private:
  EmbeddedDecider& decider_;
};

std::array<double, 2> BetasOf(const EmbeddedDecider& decider) {
  return {decider.beliefs()[0].beta, decider.beliefs()[1].beta};
}

// Plays four frames. The process is stopped in the search of the second frame, and between the
// search and the end of the third.
void Play(GameReport& report) {
  EmbeddedOptions options;
  options.policy = "paper";
  const auto decider =
      std::move(*EmbeddedDecider::Create(options, std::vector<std::string>{"A", "B"},
                                         std::vector<uint32_t>{1, 1}, SteadyClock().NowNs()));
  DeciderFeed feed(*decider);
  std::vector<std::unique_ptr<BroadPhase>> arms;
  arms.push_back(std::make_unique<StoppingArm>("A"));
  arms.push_back(std::make_unique<StoppingArm>("B"));
  auto& arm = static_cast<StoppingArm&>(*arms[0]);
  const auto adaptive = std::move(
      *AdaptiveFactory::Make({.bail_out_ns = kLimitNs}, std::move(arms), &feed, SteadyClock()));
  report.beta_before = BetasOf(*decider);
  for (size_t frame = 0; frame < report.frames.size(); ++frame) {
    const uint64_t begin_ns = SteadyClock().NowNs();
    arm.stops = frame == 1;
    adaptive->BeginFrame();
    adaptive->FindPairs(std::vector<Aabb>(4));
    if (frame == 2) raise(SIGSTOP);
    adaptive->EndFrame({.frame_time_ns = SteadyClock().NowNs() - begin_ns});
    report.frames[frame] = adaptive->last_sample();
  }
  report.beta_after = BetasOf(*decider);
  report.decision_count = decider->decision_count();
  report.is_complete = true;
}

// Runs Play in a child process and continues it kStop after each stop. Returns the number of stops.
int RunStoppedGame(GameReport& report) {
  const pid_t child = fork();
  if (child == 0) {
    Play(report);
    _exit(0);
  }
  int stop_count = 0;
  int status = 0;
  while (waitpid(child, &status, WUNTRACED) == child && WIFSTOPPED(status)) {
    ++stop_count;
    std::this_thread::sleep_for(kStop);
    kill(child, SIGCONT);
  }
  return stop_count;
}

TEST(StoppedGame, AStopIsNeitherABailOutNorEvidence) {
  void* const shared =
      mmap(nullptr, sizeof(GameReport), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  GameReport& report = *new (shared) GameReport{};
  EXPECT_EQ(RunStoppedGame(report), 2);
  ASSERT_TRUE(report.is_complete);
  EXPECT_GT(report.frames[1].detection_time_ns, kLimitNs);
  EXPECT_GT(report.frames[2].frame_time_ns, kLimitNs);
  for (const size_t stopped : {1U, 2U}) {
    EXPECT_EQ(report.frames[stopped].flags & (kFrameSuspended | kFrameBailOut), kFrameSuspended);
  }
  EXPECT_EQ(report.frames[3].arm, 0U) << "the game keeps the arm";
  EXPECT_EQ(report.beta_after, report.beta_before);
  EXPECT_EQ(report.decision_count, 0U) << "no bail-out was decided";
  munmap(shared, sizeof(GameReport));
}

}  // namespace
}  // namespace sweepstake

#endif
