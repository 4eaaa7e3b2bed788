// A C++ game that finds pairs with every backend, and receives the decisions of the embedded
// decider.
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

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

// Plays 100 frames of 16 ms, in which one decision is due, and expects that both callbacks are
// called.
bool ReportsADecision() {
  std::vector<sweepstake::DecisionEvent> events;
  std::vector<std::string> audit_rows;
  sweepstake::EmbeddedOptions options;
  options.on_decision = [&](const sweepstake::DecisionEvent& event) { events.push_back(event); };
  options.on_audit_row = [&](std::string_view row) { audit_rows.emplace_back(row); };
  auto scene = sweepstake::MakeScene("suite-b", {});
  auto adaptive = sweepstake::AdaptiveBroadPhase::Create({}, nullptr);
  if (!scene.ok() || !adaptive.ok()) return false;
  auto decider = sweepstake::EmbeddedDecider::Create(options, (*adaptive)->arms(),
                                                     (*adaptive)->arm_versions(), 0);
  if (!decider.ok()) return false;
  bool finds_pairs = true;
  for (uint64_t frame = 1; frame <= 100; ++frame) {
    (*adaptive)->BeginFrame();
    finds_pairs = finds_pairs && !(*adaptive)->FindPairs((*scene)->aabbs()).empty();
    (*adaptive)->EndFrame({16'000'000, 0});
    const uint64_t now_ns = frame * 16'000'000;
    (*decider)->Observe(std::span(&(*adaptive)->last_sample(), 1), now_ns);
    if (const auto command = (*decider)->Poll(now_ns)) (*adaptive)->mailbox().Post(*command);
  }
  return finds_pairs && events.size() == 1 && events[0].decision_id == 1 &&
         events[0].beliefs.size() == (*adaptive)->arms().size() && audit_rows.size() >= 2 &&
         sweepstake::EmbeddedDecider::AuditHeader().starts_with("item,session,");
}

}  // namespace

int main() {
  for (const std::string_view name : sweepstake::BroadPhaseNames()) {
    if (FindsTheOnePair(name)) continue;
    std::fprintf(stderr, "%s is wrong\n", std::string(name).c_str());
    return 1;
  }
  return ReportsADecision() ? 0 : 1;
}
