// Chooses the sources of a scene that new sessions use, if there are more sources than places.
//
// The owner of a token can begin as many sessions as it likes. If the latest sources were chosen,
// its sources would soon be the only ones. So places are divided among the tokens, and places that
// one token leaves free go to the others. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sweepstake::decision {

// Number of the latest sources that are considered per place.
inline constexpr uint32_t kSourcesPerPlace = 8;

// `tokens` are the tokens that began the sources, the latest source first; 0 counts as another
// token. Returns the positions of up to `limit` sources, ascending. No token gets two more than
// another token that has sources left. The latest sources of a token come first. If there are more
// tokens than places in a round, a hash of their numbers decides. A token therefore gains nothing
// by starting its sources last, and any tenth of the tokens gets about a tenth of the places.
std::vector<size_t> ChooseSources(std::span<const int64_t> tokens, size_t limit);

}  // namespace sweepstake::decision
