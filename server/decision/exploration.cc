#include "server/decision/exploration.h"

#include <cassert>
#include <numeric>
#include <utility>

#include "server/decision/math/random.h"

namespace sweepstake::decision {

std::vector<uint32_t> ExplorationOrder(uint64_t seed, uint32_t arm_count) {
  std::vector<uint32_t> order(arm_count);
  std::iota(order.begin(), order.end(), 0u);
  RandomStream stream(seed, RandomPurpose::kExplorationOrder, 0, 0);
  for (uint32_t left = arm_count; left > 1; --left)
    std::swap(order[left - 1], order[stream.NextBelow(left)]);
  return order;
}

Exploration::Exploration(uint64_t seed, uint32_t arm_count, uint32_t explored)
    : order_(ExplorationOrder(seed, arm_count)), explored_(explored) {
  assert(explored <= arm_count);
}

void Exploration::EndSlot() {
  assert(!done());
  ++explored_;
  command_count_ = 0;
}

bool Exploration::CountCommand() {
  assert(!done());
  return ++command_count_ <= kMaxCommands;
}

}  // namespace sweepstake::decision
