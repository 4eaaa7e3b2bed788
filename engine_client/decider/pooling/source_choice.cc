#include "engine_client/decider/pooling/source_choice.h"

#include <algorithm>
#include <map>
#include <utility>

#include "engine_client/math/hash.h"

namespace sweepstake::decision {
namespace {

using Indices = std::vector<size_t>;

uint64_t HashOf(int64_t token_id, uint64_t seed) {
  return math::Mix64(math::Mix64(seed) + static_cast<uint64_t>(token_id));
}
// FNV-1a alone orders similar texts similarly.
uint64_t HashOf(std::string_view party, uint64_t seed) {
  return math::Mix64(math::Mix64(seed) + math::Fnv1a(math::kFnv1aStart, party));
}

// Takes one index of each list in turn, in the order of the keys' hashes.
template <typename Key>
Indices InRounds(const std::map<Key, Indices>& lists, uint64_t seed) {
  std::vector<std::pair<uint64_t, const Indices*>> order;
  for (const auto& [key, list] : lists) order.emplace_back(HashOf(key, seed), &list);
  std::sort(order.begin(), order.end());
  Indices taken;
  for (size_t round = 0; !order.empty(); ++round) {
    std::erase_if(order, [&](const auto& entry) { return entry.second->size() <= round; });
    for (const auto& [hash, list] : order) taken.push_back((*list)[round]);
  }
  return taken;
}

// Removes the earlier sources of known parties that have more than the median.
void LimitToMedian(std::map<std::string_view, Indices>& lists) {
  std::vector<size_t> sizes;
  for (const auto& [party, list] : lists) {
    if (!party.empty()) sizes.push_back(list.size());
  }
  if (sizes.empty()) return;
  const auto median = sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), median, sizes.end());
  for (auto& [party, list] : lists) {
    if (!party.empty()) list.resize(std::min(list.size(), *median));
  }
}

}  // namespace

std::vector<size_t> ChooseSources(std::span<const SourceOwner> owners, size_t limit,
                                  uint64_t seed) {
  std::map<int64_t, std::map<std::string_view, Indices>> parties;
  for (size_t i = 0; i < owners.size(); ++i)
    parties[owners[i].token_id][owners[i].party].push_back(i);
  std::map<int64_t, Indices> tokens;
  for (auto& [token_id, lists] : parties) {
    LimitToMedian(lists);
    tokens[token_id] = InRounds(lists, seed);
  }
  Indices chosen = InRounds(tokens, seed);
  chosen.resize(std::min(chosen.size(), limit));
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace sweepstake::decision
