#include "tests/end_to_end/scripted_game.h"

#include <cstdio>
#include <cstdlib>
#include <thread>
#include <utility>

#include "sweepstake/scene.h"
#include "tests/support/wait_counter.h"

namespace sweepstake::test_support {
namespace {

// Number of frames between two checks of the session.
constexpr uint64_t kFramesPerLook = 16;
// Maximum number of frames that wait for the sender.
constexpr uint64_t kFramesAhead = 1024;
constexpr double kRestOfFrameMs = 1;
// The clock advances by this time at each reading, so detection takes half of a frame of 8 s. If
// the frame rebuilds the structure, the clock is read once more, and detection takes all of the
// frame.
constexpr double kBailOutDetectionMs = 4'000;

template <typename T>
T Must(Result<T> result) {
  if (!result.ok()) {
    std::fprintf(stderr, "%s\n", result.status().message().c_str());
    std::abort();
  }
  return std::move(*result);
}

}  // namespace

SessionOptions FastOptions() {
  SessionOptions options;
  options.project = "end-to-end";
  options.scene = "scripted";
  options.seed = 7;
  options.time_scale = 200;
  options.policy = "paper";  // with this policy each window is one observation
  options.backoff_min_ms = 5;
  options.backoff_max_ms = 50;
  return options;
}

// Advances by one step at each reading. FindPairs reads the clock twice, so a search takes one
// step.
class ScriptedGame::ScriptedClock final : public Clock {
 public:
  void SetStep(uint64_t step_ns) { step_ns_ = step_ns; }
  uint64_t NowNs() noexcept override { return now_ns_ += step_ns_; }

 private:
  uint64_t now_ns_ = 0;
  uint64_t step_ns_ = 0;
};

ScriptedGame::ScriptedGame(const std::string& address, SessionOptions options, ArmCostsMs costs_ms)
    : costs_ms_(std::move(costs_ms)),
      clock_(std::make_unique<ScriptedClock>()),
      session_(Must(MakeDaemonSession(address, options))),
      adaptive_(Must(
          AdaptiveBroadPhase::Create({.initial_arm = "BruteForce"}, &session_->sink(), *clock_))) {
  const auto scene = Must(MakeScene("brownian", SceneOptions{.object_count = 16}));
  boxes_.assign(scene->aabbs().begin(), scene->aabbs().end());
  if (Status status = session_->Start(*adaptive_); !status.ok()) {
    std::fprintf(stderr, "%s\n", status.message().c_str());
    std::abort();
  }
}

ScriptedGame::~ScriptedGame() { session_->Stop(); }

void ScriptedGame::RunFrame(bool bails_out) {
  const WaitCounter waits;
  adaptive_->BeginFrame();
  const double cost_ms = bails_out ? kBailOutDetectionMs : costs_ms_[adaptive_->active_arm()];
  clock_->SetStep(static_cast<uint64_t>(cost_ms * 1e6));
  adaptive_->FindPairs(boxes_);
  const double rest_ms = bails_out ? kBailOutDetectionMs : kRestOfFrameMs;
  adaptive_->EndFrame({.frame_time_ns = static_cast<uint64_t>((cost_ms + rest_ms) * 1e6)});
  wait_count_ += waits.count();
  ++frame_count_;
}

void ScriptedGame::RunFrames(uint64_t count) {
  for (uint64_t frame = 0; frame < count; ++frame) RunFrame(false);
}

void ScriptedGame::BailOut() { RunFrame(true); }

bool ScriptedGame::RunSomeFrames() {
  const SessionStats now = stats();
  if (now.sent_frame_count + now.dropped_frame_count + kFramesAhead < frame_count_) return false;
  RunFrames(kFramesPerLook);
  return true;
}

bool ScriptedGame::RunUntil(const std::function<bool(const SessionStats&)>& done,
                            uint64_t frame_limit) {
  const uint64_t first = frame_count_;
  while (frame_count_ - first < frame_limit) {
    if (done(stats())) return true;
    if (!RunSomeFrames()) std::this_thread::yield();
  }
  return false;
}

void ScriptedGame::Stop(uint32_t deadline_ms) { session_->Stop(deadline_ms); }

double LearntEvidence(const SessionStats& stats) {
  double evidence = 0;
  for (const ArmBelief& belief : stats.beliefs) evidence += belief.alpha + belief.beta - 2;
  return evidence;
}

}  // namespace sweepstake::test_support
