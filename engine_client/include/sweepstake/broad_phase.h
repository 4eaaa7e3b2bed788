// The contract of the interchangeable broad phases (paper §3, Table 1).
//
// Call order: Build first, then Update and FindPairs once per frame. Build may be called at any
// time and discards all state. The boxes are read during the call only, and the id of an object is
// its index in the span. Thread safety: one thread at a time per object; distinct objects are
// independent, unless they share an Executor. Units: world units of the caller. Memory is kept for
// reuse until destruction. Errors: if memory runs out, a call ends as OutOfMemory() says (hooks.h),
// and the next call must be Build.
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

// Ends a backend's call from within, for a caller that cannot wait for its end: the shadow lane.
class StopRequest {
 public:
  virtual ~StopRequest() = default;
  // Returns whether the call is to end now; true stays true until the call has returned. The
  // backend asks on each thread that runs a part of the call: in a search every few hundred
  // thousand checks, which take 2 ms or less, and in Build and Update for each block of some ten
  // thousand boxes in the passes that load and sort them. It does not ask while it splits a whole
  // tree in two, or doubles a pair buffer and copies it. Measured on a machine with other work, a
  // call ended 7 ms or less after it was to with 300,000 boxes, and 40 ms or less with 1,000,000.
  // `grown_bytes` is what its pair buffers have grown by since it last asked.
  virtual bool WantsStop(uint64_t grown_bytes) noexcept = 0;
};

class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  // Returns the family's name as in BroadPhaseNames().
  virtual std::string_view name() const = 0;

  // Returns the version, which is incremented by every change that could alter the backend's cost.
  // Evidence about one version is kept apart from that about others.
  virtual uint32_t version() const = 0;

  // Discards all state and takes these boxes: 0 to 2^31 − 1.
  virtual void Build(std::span<const Aabb> boxes) = 0;

  // Takes the boxes of the next frame. A larger count adds objects behind the last one, a smaller
  // count removes the last ones; the others keep their ids. REQUIRES: Build was called before.
  virtual void Update(std::span<const Aabb> boxes) = 0;

  // Appends every overlapping pair (aabb.h) of the latest boxes exactly once, with a < b. The order
  // of the pairs is unspecified, but the same for the same history of calls, whatever the number of
  // threads. May be called once per Build or Update.
  virtual void FindPairs(PairBuffer& out) = 0;

  // Returns the number of AABB–AABB checks of the latest Build or Update and FindPairs. One lane of
  // a vector comparison is one check, and the bounds of nodes count as AABBs.
  virtual uint64_t aabb_check_count() const = 0;

  // Returns the capacity of the backend's own buffers in bytes, whether it is used or not.
  virtual size_t native_bytes() const = 0;

  // Has `stop`, which is borrowed, asked during the calls that follow; null, as at first: nobody.
  // A call that it ends returns early, with some of the pairs, and the next call must be Build.
  void SetStop(StopRequest* stop) { stop_ = stop; }

 protected:
  StopRequest* stop() const { return stop_; }

 private:
  StopRequest* stop_ = nullptr;
};

// Returns the seven families in the paper's order: BruteForce, Grid, SAP, AxisSweep, DBVT, Tracy,
// KDTree.
std::span<const std::string_view> BroadPhaseNames();

struct BroadPhaseOptions {
  // Runs the parts of large searches (executor.h). It is borrowed and must outlive the backend.
  // With null, the calling thread does all the work.
  Executor* executor = nullptr;
};

// Returns kNotFound for an unknown name, with a message that lists the valid ones, and
// kInvalidArgument if SWEEPSTAKE_CLIENT_SIMD (simd.h) names no instruction set of this machine.
Result<std::unique_ptr<BroadPhase>> MakeBroadPhase(std::string_view name,
                                                   const BroadPhaseOptions& options = {});

}  // namespace sweepstake
