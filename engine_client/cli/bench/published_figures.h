// Times of broad phases that Debian has no package of, measured elsewhere: 2 cores of an AMD Zen 5,
// Debian 12, gcc 12 -O3, median milliseconds per frame over the reference suite, one thread, all
// objects updated and all exact pairs found. A figure says something about another run only as a
// quotient: what peer P takes here is about what Embree takes here × P's figure ÷ Embree's figure
// in the same cell.
//
// Pure, safe from any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sweepstake::cli {

struct PublishedPeer {
  std::string_view name;
  // The family of ours that it is compared with; empty: none, it counts among all peers only.
  std::string_view family;
};

// PhysX 5.6, Broadmark, Jolt: those without a package. Broadmark's grid reports pairs twice and is
// taken as it is.
std::span<const PublishedPeer> PublishedPeers();

// `peer` is one of PublishedPeers, or Embree or BulletDbvtDeferred, through which they are
// compared. Absent where there is no figure for the cell.
std::optional<double> PublishedFigure(std::string_view peer, std::string_view scene,
                                      uint32_t object_count);

}  // namespace sweepstake::cli
