// The interface that all broad phases implement (paper §3, Table 1).
//
// Call order: Build first, then Update and FindPairs once per frame. Build may be called again at
// any time and discards all state. The boxes are read only during the call. The id of an object is
// its index in the span. Thread safety: one thread at a time per object; distinct objects are
// independent, unless they share an Executor. Lengths are in world units of the caller. Memory is
// kept for reuse until destruction. The results do not depend on the caller's floating-point
// environment (rounding mode, flush to zero, trapped exceptions), which is restored on return.
// Errors: if memory runs out, a call ends as described at
// OutOfMemory() (hooks.h), and the next call must be Build.
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

struct BroadPhaseOptions;

// Stops a call of a backend early. Used by the shadow lane, which cannot wait for the end of a long
// call, and by the frame thread during a trial (SwitchCommand).
class StopRequest {
 public:
  virtual ~StopRequest() = default;
  // Returns whether the call must end now. Once it returns true, it must keep doing so until the
  // call has returned. Each call reports what the search has added since the previous WantsStop:
  // `grown_bytes` is the growth of the backend's pair buffers, and `found_pairs` is the number of
  // pairs found.
  //
  // The backend calls this function on each thread that runs a part of the call. A search calls it
  // every half a million checks, which take 2 ms or less. Build and Update call it for each block
  // of about ten thousand boxes in the passes that load and sort them. They do not call it while a
  // whole tree is split in two, or while a pair buffer doubles and is copied. On a machine with
  // other load, a call was measured to end within 7 ms with 300,000 boxes, and within 40 ms with
  // 1,000,000.
  virtual bool WantsStop(uint64_t grown_bytes, uint64_t found_pairs) noexcept = 0;
  // Called with the rest of these numbers when a part of a search has ended. Nothing is left to be
  // stopped in this part, so a request that only measures time can ignore the call.
  virtual void OnEnd(uint64_t grown_bytes, uint64_t found_pairs) noexcept {
    WantsStop(grown_bytes, found_pairs);
  }
};

class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  // Returns the name of the backend, one of BroadPhaseNames().
  virtual std::string_view name() const = 0;

  // Returns the backend's version. Every change that could alter the backend's cost increments it.
  // Evidence about different versions is kept apart.
  virtual uint32_t version() const = 0;

  // Discards all state and starts with these boxes; their number is 0 to 2^31 − 1.
  void Build(std::span<const Aabb> boxes);

  // Sets the boxes of the next frame. If there are more boxes than before, the new objects are at
  // the end; if there are fewer, the last objects are removed. All others keep their ids. If more
  // than an eighth of the boxes have gone, counted from the largest number since the latest Build,
  // it does the work of Build, at most every 32 frames. So objects that once lived cost nothing
  // later. REQUIRES: Build was called.
  void Update(std::span<const Aabb> boxes);

  // Appends every overlapping pair (aabb.h) of the latest boxes exactly once, with a < b. The order
  // of the pairs is unspecified. It is the same for the same sequence of calls, whatever the number
  // of threads. May be called once per Build or Update. If there are more pairs than
  // BroadPhaseOptions::max_pairs, the search ends early, appends nothing, and pairs_exceeded() is
  // true; the next call must be Build.
  void FindPairs(PairBuffer& out);

  // Returns whether the latest FindPairs ended because of BroadPhaseOptions::max_pairs.
  bool pairs_exceeded() const { return pairs_exceeded_; }

  // Returns the number of AABB–AABB checks of the latest Build or Update, and FindPairs. A vector
  // comparison counts as one check per element. Checks against the bounds of tree nodes count too.
  virtual uint64_t aabb_check_count() const = 0;

  // Returns the capacity, in bytes, of the backend's own buffers, including unused parts.
  virtual size_t native_bytes() const = 0;

  // Sets the StopRequest for later calls; borrowed. With null, the default, calls are never
  // stopped. A stopped call returns early with only some of the pairs, and the next call must be
  // Build.
  void SetStop(StopRequest* stop) { stop_ = stop; }

 protected:
  StopRequest* stop() const { return stop_; }

 private:
  class StopScope;
  // Calls Start, Advance and Search, within its own FloatEnvironmentScope.
  friend class AdaptiveBroadPhase;
  // Sets max_pairs_.
  friend Result<std::unique_ptr<BroadPhase>> MakeBroadPhase(std::string_view name,
                                                            const BroadPhaseOptions& options);

  // Called by the public functions of the same names, in the default floating-point environment.
  virtual void DoBuild(std::span<const Aabb> boxes) = 0;
  virtual void DoUpdate(std::span<const Aabb> boxes) = 0;
  virtual void DoFindPairs(PairBuffer& out) = 0;
  // Build, Update and FindPairs without the change of the floating-point environment.
  void Start(std::span<const Aabb> boxes);
  void Advance(std::span<const Aabb> boxes);
  void Search(PairBuffer& out);

  StopRequest* stop_ = nullptr;
  uint64_t max_pairs_ = 0;
  bool pairs_exceeded_ = false;
  // Both fit into the padding. With a larger base, the grids of Grid cross cache lines, and its
  // frames take 10 % longer (AMD Zen 5).
  uint8_t frames_to_start_ = 0;  // the frames until Advance may call Start
  uint32_t peak_count_ = 0;      // the largest number of boxes since the latest Start
};

// Returns the seven backends in the paper's order: BruteForce, Grid, SAP, AxisSweep, DBVT, Tracy,
// KDTree.
std::span<const std::string_view> BroadPhaseNames();

struct BroadPhaseOptions {
  // Runs the parts of large searches (executor.h). It is borrowed and must outlive the backend.
  // With null, the calling thread does all the work.
  Executor* executor = nullptr;
  // The maximum number of pairs of a search; 0: no limit. It protects memory if the boxes collapse
  // to one place: 100,000 boxes then have 5 billion pairs (40 GB). FindPairs ends a search with
  // more pairs (pairs_exceeded). Until then each thread may find half a million pairs above the
  // limit. A pair takes 8 bytes, and twice that while its buffer grows. Backends that keep pairs
  // between frames hold at most 50 more per box.
  uint64_t max_pairs = 0;
};

// Makes a backend. Errors:
// - kNotFound for an unknown name; the message lists the valid ones
// - kInvalidArgument if SWEEPSTAKE_CLIENT_SIMD (simd.h) names an instruction set that this machine
//   lacks
Result<std::unique_ptr<BroadPhase>> MakeBroadPhase(std::string_view name,
                                                   const BroadPhaseOptions& options = {});

}  // namespace sweepstake
