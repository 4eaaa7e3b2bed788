// A C++ game that finds pairs with every backend and lets the embedded decider look on.
#include <cstdio>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/scene.h"

namespace {

bool FindsTheOnePair(std::string_view name) {
  const sweepstake::Aabb boxes[] = {
      {{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}, {{5, 5, 5}, {6, 6, 6}}};
  sweepstake::PairBuffer pairs;
  auto backend = sweepstake::MakeBroadPhase(name);
  if (!backend.ok()) return false;
  (*backend)->Build(boxes);
  (*backend)->FindPairs(pairs);
  return pairs.size() == 1 && pairs.pairs()[0] == sweepstake::OverlapPair{0, 1};
}

bool PlaysAFrame() {
  auto scene = sweepstake::MakeScene("suite-b", {});
  auto adaptive = sweepstake::AdaptiveBroadPhase::Create({}, nullptr);
  if (!scene.ok() || !adaptive.ok()) return false;
  auto decider =
      sweepstake::EmbeddedDecider::Create({}, (*adaptive)->arms(), (*adaptive)->arm_versions(), 0);
  if (!decider.ok()) return false;
  (*adaptive)->BeginFrame();
  const auto pairs = (*adaptive)->FindPairs((*scene)->aabbs());
  (*adaptive)->EndFrame({16'000'000, 0});
  (*decider)->Observe(std::span(&(*adaptive)->last_sample(), 1), 16'000'000);
  return !pairs.empty();
}

}  // namespace

int main() {
  for (const std::string_view name : sweepstake::BroadPhaseNames()) {
    if (FindsTheOnePair(name)) continue;
    std::fprintf(stderr, "%s is wrong\n", std::string(name).c_str());
    return 1;
  }
  return PlaysAFrame() ? 0 : 1;
}
