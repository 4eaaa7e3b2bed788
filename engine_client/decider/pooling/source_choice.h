// Which sources of a scene speak for it, where it has more of them than are heard.
//
// Whoever holds a token begins as many sessions as it likes. If the latest sources spoke, its own
// would soon be all that new sessions learn from; so places go to tokens, and only what one leaves
// goes to the others. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sweepstake::decision {

// For each place so many of the latest sources are looked at.
inline constexpr uint32_t kSourcesPerPlace = 8;

// `tokens` are those that the sources began with, the latest source first; 0 counts as one more
// token. Returns the places in it of up to `limit` sources, ascending: no token has two more than
// another that has sources left. A token's latest ones come first. Where there are more tokens than
// places for their next ones, a hash of their numbers decides: nothing is gained by coming last,
// and a tenth of the tokens is some tenth of those chosen.
std::vector<size_t> ChooseSources(std::span<const int64_t> tokens, size_t limit);

}  // namespace sweepstake::decision
