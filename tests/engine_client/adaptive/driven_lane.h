// A shadow lane that the test drives step by step, with arms whose costs are scripted.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "engine_client/adaptive/shadow_lane.h"
#include "tests/support/recording_sink.h"
#include "tests/support/scripted_clock.h"

namespace sweepstake::test_support {

struct LaneScript {
  uint64_t build_ns = 5 * kMs;
  uint64_t update_ns = 1 * kMs;
  uint64_t find_ns = 1 * kMs;
  size_t bytes = 1000;
  std::function<void()> in_build = [] {};
  // A search checks question_count times whether it should stop. Before each check it takes
  // question_ns, and with each check its memory grows by question_bytes.
  uint64_t question_count = 0;
  uint64_t question_ns = 0;
  uint64_t question_bytes = 0;
  std::function<void(uint64_t)> in_search = [](uint64_t) {};  // argument: number of the check
};

// A backend that takes its scripted time and records its boxes.
class LaneBackend final : public BroadPhase {
 public:
  LaneBackend(const LaneScript& script, ScriptedClock& clock) : script_(script), clock_(clock) {}

  std::string_view name() const override { return "Lane"; }
  uint32_t version() const override { return 1; }
  void DoBuild(std::span<const Aabb> boxes) override {
    shown.assign(1, boxes.size());
    script_.in_build();
    clock_.Advance(script_.build_ns);
  }
  void DoUpdate(std::span<const Aabb> boxes) override {
    shown.push_back(boxes.size());
    clock_.Advance(script_.update_ns);
  }
  void DoFindPairs(PairBuffer&) override {
    clock_.Advance(script_.find_ns);
    for (questions = 1; questions <= script_.question_count; ++questions) {
      clock_.Advance(script_.question_ns);
      script_.in_search(questions);
      if (stop()->WantsStop(script_.question_bytes, 0)) return;
    }
  }
  uint64_t aabb_check_count() const override { return 100 * shown.size(); }
  size_t native_bytes() const override { return shown.empty() ? 0 : script_.bytes; }

  std::vector<size_t> shown;  // object counts since the build
  uint64_t questions = 0;     // checks in the latest search

 private:
  const LaneScript& script_;
  ScriptedClock& clock_;
};

// Bytes of a sweep's copies of 20 objects. The lane reserves room for 20 / 8 + 64 more objects.
inline constexpr uint64_t kCopiesBytes = kShadowBurstFrames * (20 + 2 + 64) * sizeof(Aabb);

// A clock of thread time that advances by 3 ms with each reading, independent of the real time.
inline uint64_t ThreeMsAtATime() noexcept {
  static std::atomic<uint64_t> ran_ns{0};
  return ran_ns += 3 * kMs;
}

// Runs each frame followed by a step of the lane.
class DrivenLane : public ::testing::Test {
 protected:
  void SetUp() override { Make({}); }

  void Make(const ShadowOptions& options) { Make(options, clock_); }
  void Make(const ShadowOptions& options, Clock& clock) {
    sink_ = RecordingSink();
    made_count_ = 0;
    lane_ = std::make_unique<ShadowLane>(ShadowLane::Setup{
        .options = options,
        .arm_count = static_cast<uint32_t>(scripts_.size()),
        .make = [this](uint32_t arm) { return MakeBackend(arm); },
        .sink = &sink_,
        .clock = clock,
        .mode = mode_,
        .thread_time_ns = thread_time_ns_,
    });
    MakeItCost(0);
  }

  // Simulates the lane's cost: a search while the lane works takes 1 + `slowdown` times as long as
  // the search before it.
  void MakeItCost(uint64_t slowdown) {
    LaneCost& cost = lane_->cost();
    cost.End(cost.Begin(), search_ns_, 0);
    cost.BeginWork();
    cost.End(cost.Begin(), (1 + slowdown) * search_ns_, 0);
    cost.EndWork((1 + slowdown) * search_ns_);
  }

  virtual ArmBackend MakeBackend(uint32_t arm) {
    ++made_count_;
    return {nullptr, std::make_unique<LaneBackend>(scripts_[arm], clock_)};
  }

  void Frame() {
    clock_.Advance(frame_ns_);
    LaneCost& cost = lane_->cost();
    cost.End(cost.Begin(), frame_ns_ / frames_per_search_time_, 0);
    lane_->OnFrame(std::vector<Aabb>(object_count_),
                   {.frame_index = frame_index_++, .frame_time_ns = frame_ns_, .arm = 1});
    lane_->Step();
  }
  void Frames(int count) {
    for (int i = 0; i < count; ++i) Frame();
  }
  // Runs the first sweep: the lane first requests memory for copies, and then records its frames.
  void FirstSweep() {
    lane_->Step();
    Frames(1 + static_cast<int>(kShadowBurstFrames));
  }
  // Runs frames until the lane has prepared the arm, at most 100. Returns their number.
  int FramesUntilReady(uint32_t arm) {
    int frames = 0;
    while (lane_->Ask(arm) == ShadowLane::Preparation::kUnderWay && frames < 100) {
      Frame();
      ++frames;
    }
    return frames;
  }

  ScriptedClock clock_;
  std::atomic<Mode> mode_{Mode::kAi};
  uint64_t (*thread_time_ns_)() noexcept = nullptr;
  std::vector<LaneScript> scripts_{3};
  RecordingSink sink_;
  PairBuffer pairs_;
  std::unique_ptr<ShadowLane> lane_;
  uint64_t frame_index_ = 0;
  size_t object_count_ = 20;
  uint64_t frame_ns_ = 10 * kMs;
  uint64_t search_ns_ = 100'000 * kMs;   // time of the first search in MakeItCost
  uint64_t frames_per_search_time_ = 1;  // a frame's time ÷ its searches' time
  int made_count_ = 0;
};

}  // namespace sweepstake::test_support
