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
    clock_.Advance(script_.build_ns);
  }
  void DoUpdate(std::span<const Aabb>) override {
    ++update_count;
    clock_.Advance(script_.update_ns);
  }
  void DoFindPairs(PairBuffer& out) override {
    clock_.Advance(script_.find_ns);
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

 private:
  ArmScript script_;
  ScriptedClock& clock_;
};

}  // namespace sweepstake::test_support
