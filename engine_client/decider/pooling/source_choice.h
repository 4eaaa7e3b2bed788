// Chooses which sources of a scene new sessions use, if a scene has more sources than the limit.
//
// The owner of a token can start any number of sessions. If the latest sources were chosen, one
// owner could soon supply all of them. So the places are divided among the tokens, and places that
// a token does not fill go to the others. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sweepstake::decision {

// For each place, this many of the latest sources are candidates.
inline constexpr uint32_t kSourcesPerPlace = 8;

// `tokens` has, for each source, the number of the token that began it, latest source first. 0 (no
// token) counts as one more token. Returns the indices of up to `limit` sources, ascending.
// - Each round gives one place to every token that has sources left, for the latest of them.
// - If a round has fewer places than tokens, a hash of the token numbers decides. So a token gains
//   nothing by starting its sources last, and any tenth of the tokens gets about a tenth of the
//   places.
std::vector<size_t> ChooseSources(std::span<const int64_t> tokens, size_t limit);

}  // namespace sweepstake::decision
