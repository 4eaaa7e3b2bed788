// Chooses which sources of a scene new sessions use, if a scene has more sources than the limit.
//
// One client can start any number of sessions. If the latest sources were chosen, one client could
// soon supply all of them. So the places are divided among the tokens, and the places of a token
// among its parties. Places that a token or party does not fill go to the others, except that no
// party of several has more than the median party has sources. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace sweepstake::decision {

// For each place, readers should offer about this many of the latest sources.
inline constexpr uint32_t kSourcesPerPlace = 8;

// The token and the party that began a source.
struct SourceOwner {
  int64_t token_id = 0;  // 0 (no token) counts as one more token
  // The player that the ticket names, or the network of the client's address; empty if unknown,
  // which stands for any number of parties.
  std::string_view party;
};

// `owners` has the owner of each source, latest source first. Returns the indices of up to `limit`
// sources, ascending.
// - Each round gives one place to every token that has sources left. Within a token, each round
//   gives one place to every party that has sources left, for the latest of them.
// - Each known party of a token is limited to the median number of their sources. So one party gets
//   no more than most others, even if they leave places free. The median of two is the larger one.
// - If a round has fewer places than tokens or parties, a hash of them and of `seed` decides. So
//   they gain nothing by starting their sources last, and any tenth of them gets about a tenth of
//   the places. Keep the seed secret: a client could choose a network by its hash.
std::vector<size_t> ChooseSources(std::span<const SourceOwner> owners, size_t limit, uint64_t seed);

}  // namespace sweepstake::decision
