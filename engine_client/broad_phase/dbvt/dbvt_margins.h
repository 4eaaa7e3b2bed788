// The data that DBVT keeps at rest: each object's box enlarged by a margin, and the candidates,
// which are the pairs of enlarged boxes that overlap. (Tracy's counterpart is tracy_rest.h.)
//
// At rest the tree holds the enlarged boxes. An object inside its enlarged box costs one comparison
// per frame. If an object leaves its enlarged box, it gets a new one, a new place in the tree and
// new candidates. FindPairs tests the exact boxes of the candidates, so that no margin is visible
// outside.
//
// A margin is the object's own motion in 8 frames, clamped to between 2 % and 10 % of a typical
// side. The typical side is the median, over all boxes, of the second longest of a box's three
// sides. An object that moves further than the maximum in one frame gets the minimum, since no
// margin would hold it.
//
// Not thread-safe. Owns its memory, none before the first Start. Cost: Follow O(objects), and a
// search in the tree for each object that has left its margin; FindPairs O(candidates). Memory: 53
// bytes per object and 8 to 16 per candidate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/aabb.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

class DbvtMargins {
 public:
  // Measures the typical side of these boxes (defined at the top of this file). Step and all
  // margins depend on it until the next call.
  void MeasureSide(std::span<const Aabb> boxes);
  // Returns the motion per frame that uses up the largest margin in 8 frames.
  float Step() const;

  // Enlarges all boxes, also those in the tree, and finds all candidates. `motion` is the mean
  // motion per frame, which determines the margin. Returns false if there are too many candidates
  // to keep (24 per object); the tree is then unchanged. The searches of Start and Follow poll
  // `stop`, which may be null. REQUIRES: the tree holds exactly the objects with valid boxes.
  bool Start(std::span<const Aabb> boxes, float motion, DbvtTree& tree, Executor* executor,
             StopRequest* stop);

  // Takes the boxes of the next frame, whose count may differ, and adds the AABB checks made to
  // `checks`. Returns false if refitting the tree is cheaper, because too many objects have left
  // their margins or there are too many candidates. The tree then has room for boxes.size() objects
  // but holds outdated boxes, and the next call must be Start.
  bool Follow(std::span<const Aabb> boxes, DbvtTree& tree, Executor* executor, uint64_t& checks,
              StopRequest* stop);

  // Appends the overlapping pairs of the latest boxes; returns the AABB checks.
  uint64_t FindPairs(Executor* executor, PairParts& parts, PairBuffer& out);

  size_t native_bytes() const;

 private:
  bool AreWorthKeeping() const;
  size_t MaxCandidateCount() const;
  float MarginFor(float motion) const;
  void Resize(size_t count, DbvtTree& tree);
  void Reserve(size_t count, size_t kept);
  void CollectObjectsOutside(std::span<const Aabb> boxes, Executor* executor);
  size_t UpdatePart(std::span<const Aabb> boxes, size_t begin, size_t end);
  void Replace(uint32_t object, DbvtTree& tree);
  void DropOutdatedCandidates();

  AlignedBuffer<Aabb> exact_;     // the latest boxes, with one element of padding behind them
  AlignedBuffer<Aabb> fat_;       // the enlarged boxes
  AlignedBuffer<uint32_t> left_;  // the objects that have left their enlarged boxes
  AlignedBuffer<uint8_t> has_left_;
  HookedVector<size_t> left_counts_;  // the number of objects that each part lists in left_
  HookedVector<float> sides_;
  PairBuffer candidates_;
  size_t count_ = 0;
  size_t left_count_ = 0;
  float side_ = 0;  // the typical side, defined at the top of this file
};

}  // namespace sweepstake
