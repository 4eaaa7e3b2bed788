// The search of LeafTree: all pairs of which the one box is in a given run of blocks.
//
// A block is 16 leaves. Its bounds go down the levels once and bring up the leaves near it, those
// of later blocks included; each of its leaves is then tested against that short list, the boxes
// of the leaves found against the leaf's bounds, and the boxes found against the leaf's 16 boxes at
// once. Each stage is a loop over a list in the cache: descending from the top for every leaf
// spends half the time waiting for what one level says of the next.
//
// Thread-safe: reads what it is given, keeps its lists on the stack (60 KiB).
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/kd/leaf_boxes.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Appends the pairs of the boxes in the blocks [begin, end) with one another and with those of
// later blocks; returns the AABB checks. REQUIRES: `levels` are the bounds of `boxes`, at least one
// level.
uint64_t FindLeafPairs(const LeafBlock* leaves, const LeafTree::Level* levels, size_t level_count,
                       size_t begin, size_t end, PairBuffer& out);

}  // namespace sweepstake
