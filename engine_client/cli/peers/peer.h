// Broad phases of other libraries behind our own interface, to be timed beside ours.
//
// A peer is used as its library means it to be for many moving objects: every object is told its
// new box, and all overlapping pairs are found, exact where the library's own answer is
// conservative. REQUIRES, beyond BroadPhase: every box takes part (aabb.h). A peer counts no checks
// and knows no bytes of its own, and its pairs come in any order. Not thread-safe.
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
  std::string_view family;    // of ours that it is compared with (BroadPhaseNames)
  uint32_t most_objects = 0;  // what it can hold, or what takes longer than anybody waits for
  bool takes_threads = false;
  std::unique_ptr<Peer> (*make)(std::string_view name, uint32_t thread_count) = nullptr;
};

struct PeerLibrary {
  std::string_view name;
  std::string_view package;  // Debian's
  std::string_view licence;
  std::string version;          // empty where it is left out of this build
  std::vector<PeerKind> kinds;  // none where it is left out
};

// Adds a pair either way round.
inline void AppendPair(PairBuffer& out, uint32_t a, uint32_t b) {
  out.Append({std::min(a, b), std::max(a, b)});
}

// The definition of overlap for boxes that take part.
inline bool Meet(const Aabb& a, const Aabb& b) {
  return a.min[0] <= b.max[0] && b.min[0] <= a.max[0] && a.min[1] <= b.max[1] &&
         b.min[1] <= a.max[1] && a.min[2] <= b.max[2] && b.min[2] <= a.max[2];
}

// Around all boxes, larger by a quarter of the side on each side; a unit box where there are none.
Aabb RoomyBounds(std::span<const Aabb> boxes);

}  // namespace sweepstake::cli
