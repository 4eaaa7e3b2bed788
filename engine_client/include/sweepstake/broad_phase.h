// The contract of the interchangeable broad phases (paper §3, Table 1).
//
// Call order: Build, then any number of (Update, FindPairs); Build may come at any time and
// discards all state. One thread at a time per object; distinct objects are independent, unless
// they share an Executor. The boxes are read during the call only. Object id = index in the span.
// Units: world units of the caller. Memory is kept for reuse until destruction. Errors: none;
// memory exhaustion throws std::bad_alloc, and the next call must be Build.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "sweepstake/aabb.h"
#include "sweepstake/executor.h"
#include "sweepstake/pair_buffer.h"
#include "sweepstake/status.h"

namespace sweepstake {

class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  // The family's name as in BroadPhaseNames().
  virtual std::string_view name() const = 0;

  // Raised whenever a change could alter the backend's cost; evidence of different versions is kept
  // apart.
  virtual uint32_t version() const = 0;

  // Discards state and takes these boxes. Any count, 0 included, up to 2^31 − 1.
  virtual void Build(std::span<const Aabb> boxes) = 0;

  // Takes the boxes of the next frame. A larger count adds objects behind the last one, a smaller
  // one removes the last ones; the others keep their ids. REQUIRES: a Build before.
  virtual void Update(std::span<const Aabb> boxes) = 0;

  // Appends every overlapping pair (aabb.h) of the latest boxes exactly once, a < b; the order is
  // unspecified and the same for the same history of calls, whatever the number of threads. May be
  // called once per Build or Update.
  virtual void FindPairs(PairBuffer& out) = 0;

  // AABB–AABB checks of the latest Build or Update and FindPairs. One lane of a vector comparison
  // is one check, bounding volumes of nodes count as AABBs.
  virtual uint64_t aabb_check_count() const = 0;

  // Bytes held by the backend's own buffers, capacity not use.
  virtual size_t native_bytes() const = 0;
};

// The seven families in the paper's order: BruteForce, Grid, SAP, AxisSweep, DBVT, Tracy, KDTree.
std::span<const std::string_view> BroadPhaseNames();

struct BroadPhaseOptions {
  // Runs the parts of large searches (executor.h); borrowed, must outlive the backend. Null: all
  // work is done by the calling thread.
  Executor* executor = nullptr;
};

// kNotFound for an unknown name, with a message that lists the valid ones.
Result<std::unique_ptr<BroadPhase>> MakeBroadPhase(std::string_view name,
                                                   const BroadPhaseOptions& options = {});

}  // namespace sweepstake
