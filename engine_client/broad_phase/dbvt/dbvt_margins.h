// What DBVT keeps while little moves: each object's box enlarged by a margin, and the pairs of
// enlarged boxes that overlap ("candidates").
//
// The tree holds the enlarged boxes meanwhile. An object that stays inside its own costs one
// comparison; one that leaves it gets another place in the tree and its candidates anew. The exact
// boxes of the candidates are tested in the end, so that no margin is seen outside.
//
// Margin: kMarginFrames frames of the object's own motion, within 2 % and 10 % of the median
// middle side of all boxes; an object that outruns the most in one frame gets the least, since no
// margin would hold it.
//
// Not thread-safe. Owns its memory, none before the first Start. Cost: Follow 2 ns per object and
// 0.4 us per one that left; FindPairs 1 ns per candidate (at 10,000 objects). Memory: 53 bytes per
// object and 8 to 16 per candidate; with more than 24 of them per object nothing rests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "sweepstake/aabb.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

class DbvtMargins {
 public:
  // Takes the measure of these boxes, for Step and all margins until the next call.
  void MeasureSide(std::span<const Aabb> boxes);
  // Motion in one frame up to which a margin holds for many frames.
  float Step() const;

  // Encloses all boxes, whose mean motion this is, in margins, the objects of the tree too, and
  // finds all candidates. False where there are too many to keep: the tree is as it was. REQUIRES:
  // the tree holds exactly those of the boxes that take part.
  bool Start(std::span<const Aabb> boxes, float motion, DbvtTree& tree, Executor* executor);

  // Takes the boxes of the next frame, however many. False: so many left their margins, or have
  // candidates, that the tree is better refitted; it holds objects 0 … boxes.size() − 1 then, with
  // boxes of no use, and the margins are void until the next Start. Adds the AABB checks made to
  // `checks`.
  bool Follow(std::span<const Aabb> boxes, DbvtTree& tree, Executor* executor, uint64_t& checks);

  // As BroadPhase::FindPairs; returns the AABB checks.
  uint64_t FindPairs(Executor* executor, PairParts& parts, PairBuffer& out);

  size_t native_bytes() const;

 private:
  bool AreWorthKeeping() const;
  float MarginFor(float motion) const;
  void Resize(size_t count, DbvtTree& tree);
  void Reserve(size_t count, size_t kept);
  void CollectLeavers(std::span<const Aabb> boxes, Executor* executor);
  size_t TakePart(std::span<const Aabb> boxes, size_t begin, size_t end);
  void Replace(uint32_t object, DbvtTree& tree);
  void DropCandidatesOfLeavers();

  AlignedBuffer<Aabb> exact_;  // and room for one more: see KeepOverlapping
  AlignedBuffer<Aabb> fat_;
  AlignedBuffer<uint32_t> left_;  // objects
  AlignedBuffer<uint8_t> has_left_;
  std::vector<size_t> left_counts_;  // by part
  std::vector<float> sides_;
  PairBuffer candidates_;
  size_t count_ = 0;
  size_t left_count_ = 0;
  float side_ = 0;
};

}  // namespace sweepstake
