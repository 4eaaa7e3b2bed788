#include "engine_client/decider/pooling/source_choice.h"

#include <algorithm>
#include <map>

#include "engine_client/math/hash.h"

namespace sweepstake::decision {
namespace {

uint64_t HashOf(int64_t token) { return math::SplitMix64{static_cast<uint64_t>(token)}.Next(); }

}  // namespace

std::vector<size_t> ChooseSources(std::span<const int64_t> tokens, size_t limit) {
  std::vector<std::vector<size_t>> rounds;  // each round has at most one source per token
  std::map<int64_t, size_t> counts;
  for (size_t place = 0; place < std::min(tokens.size(), kSourcesPerPlace * limit); ++place) {
    const size_t round = counts[tokens[place]]++;
    if (round == rounds.size()) rounds.emplace_back();
    rounds[round].push_back(place);
  }
  std::vector<size_t> chosen;
  for (std::vector<size_t>& round : rounds) {
    std::sort(round.begin(), round.end(),
              [&](size_t a, size_t b) { return HashOf(tokens[a]) < HashOf(tokens[b]); });
    round.resize(std::min(round.size(), limit - chosen.size()));
    chosen.insert(chosen.end(), round.begin(), round.end());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace sweepstake::decision
