// A backend with scripted costs: each operation takes its scripted time on a scripted clock, finds
// the scripted number of pairs, and is counted.
#pragma once

#include <string>
#include <utility>

#include "sweepstake/broad_phase.h"
#include "tests/support/scripted_clock.h"

namespace sweepstake::test_support {

struct ArmScript {
  std::string name = "Scripted";
  uint32_t version = 1;
  uint64_t build_ns = 0;
  uint64_t update_ns = 0;
  uint64_t find_ns = 0;
  uint64_t stopped_ns = 0;  // time in a search during which the process is stopped
  uint64_t waiting_ns = 0;  // time in a search during which two other threads compute
  // The number of times that each build, update and search polls its StopRequest, evenly
  // distributed over its time. After a stop it does nothing more.
  uint32_t poll_count = 0;
  uint64_t check_count = 0;
  size_t bytes = 0;
  uint32_t pair_count = 0;
  bool descending = false;  // whether pairs are in descending order
};

class ScriptedBroadPhase final : public BroadPhase {
 public:
  ScriptedBroadPhase(ArmScript script, ScriptedClock& clock)
      : script_(std::move(script)), clock_(clock) {}

  std::string_view name() const override { return script_.name; }
  uint32_t version() const override { return script_.version; }
  void DoBuild(std::span<const Aabb>) override {
    ++build_count;
    Work(script_.build_ns);
  }
  void DoUpdate(std::span<const Aabb>) override {
    ++update_count;
    Work(script_.update_ns);
  }
  void DoFindPairs(PairBuffer& out) override {
    ++find_count;
    if (!Work(script_.find_ns)) return;
    clock_.AdvanceWaiting(script_.stopped_ns);
    clock_.AdvanceWaiting(script_.waiting_ns, 2 * script_.waiting_ns);
    for (uint32_t i = 0; i < script_.pair_count; ++i) {
      const uint32_t a = script_.descending ? script_.pair_count - 1 - i : i;
      out.Append({a, a + 1});
    }
  }
  uint64_t aabb_check_count() const override { return script_.check_count; }
  size_t native_bytes() const override { return script_.bytes; }

  // The test may change the script between frames.
  ArmScript& script() { return script_; }

  int build_count = 0;
  int update_count = 0;
  int find_count = 0;

 private:
  // Returns false if the work was stopped.
  bool Work(uint64_t time_ns) {
    const uint32_t polls = stop() == nullptr ? 0 : script_.poll_count;
    for (uint32_t poll = 0; poll < polls; ++poll) {
      clock_.Advance(time_ns / polls);
      if (stop()->WantsStop(0, 0)) return false;
    }
    clock_.Advance(polls == 0 ? time_ns : time_ns % polls);
    return true;
  }

  ArmScript script_;
  ScriptedClock& clock_;
};

}  // namespace sweepstake::test_support
