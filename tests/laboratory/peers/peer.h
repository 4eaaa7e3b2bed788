// Broad phases of other libraries behind our own interface, so that `sweepstake-lab bench --peers`
// can time them beside our backends.
//
// A peer is used as its library intends it for many moving objects: every object gets its new box,
// then all overlapping pairs are found. If a library reports pairs of enlarged boxes, the peer
// drops the pairs whose exact boxes do not overlap. A peer does not count AABB checks or bytes, and
// its pairs are in any order. Not thread-safe.
// REQUIRES, beyond BroadPhase: every box is valid (finite and not inverted, see aabb.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sweepstake/broad_phase.h"

namespace sweepstake::cli {

class Peer : public BroadPhase {
 public:
  // `name` outlives the peer.
  explicit Peer(std::string_view name) : name_(name) {}

  std::string_view name() const final { return name_; }
  uint32_t version() const final { return 1; }
  uint64_t aabb_check_count() const final { return 0; }
  size_t native_bytes() const final { return 0; }

 private:
  std::string_view name_;
};

// One broad phase of a library.
struct PeerKind {
  std::string_view name;
  // Our backend that this peer is compared with, one of BroadPhaseNames.
  std::string_view family;
  // The maximum object count. More objects do not fit into the library's structure or take too
  // long.
  uint32_t max_object_count = 0;
  bool takes_threads = false;
  std::unique_ptr<Peer> (*make)(std::string_view name, uint32_t thread_count) = nullptr;
};

struct PeerLibrary {
  std::string_view name;
  std::string_view package;     // the name of Debian's package
  std::string version;          // empty if this build leaves the library out
  std::vector<PeerKind> kinds;  // none if this build leaves the library out
};

// Appends the pair of `a` and `b`, the smaller id first.
inline void AppendPair(PairBuffer& out, uint32_t a, uint32_t b) {
  out.Append({std::min(a, b), std::max(a, b)});
}

// Returns whether two valid boxes overlap. Unlike the function of this name in tracy_rest.cc, it
// stops at the first axis on which they do not overlap.
inline bool ValidBoxesOverlap(const Aabb& a, const Aabb& b) {
  return a.min[0] <= b.max[0] && b.min[0] <= a.max[0] && a.min[1] <= b.max[1] &&
         b.min[1] <= a.max[1] && a.min[2] <= b.max[2] && b.min[2] <= a.max[2];
}

// Returns the bounds of all boxes, enlarged on each side by a quarter of their own edge; a unit box
// if there are no boxes.
Aabb RoomyBounds(std::span<const Aabb> boxes);

// Returns all known libraries in a fixed order, including those that this build leaves out. Safe
// from any thread.
std::vector<PeerLibrary> PeerLibraries();

// Makes a peer that always uses one thread. `kArguments` follow the name in its constructor.
template <typename T, auto... kArguments>
std::unique_ptr<Peer> MakePeer(std::string_view name, uint32_t /*thread_count*/) {
  return std::make_unique<T>(name, kArguments...);
}

// Each function fills in the version and the kinds of its library and is defined in that library's
// file. If the build leaves a library out, CMakeLists.txt generates a function that fills in
// nothing.
void AddBulletPeers(PeerLibrary& library);  // the dynamic tree and the sweep along sorted axes
void AddFclPeers(PeerLibrary& library);     // broad-phase managers in double precision
void AddOdePeers(PeerLibrary& library);     // collision spaces on boxes in double precision
void AddEmbreePeers(PeerLibrary& library);  // rtcCollide of a scene with itself
void AddBoostPeers(PeerLibrary& library);   // an R-tree that is packed again every frame
void AddCgalPeers(PeerLibrary& library);    // box_self_intersection_d, a streamed segment tree

}  // namespace sweepstake::cli
