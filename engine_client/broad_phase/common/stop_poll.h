// Polls a StopRequest (broad_phase.h) at intervals: StopPoll during a search, ForEachBlock while
// boxes are loaded and sorted.
//
// Not thread-safe: each kernel call has its own object. Borrows the request and the buffer. Cost:
// one comparison per poll point, even without a request.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "hwy/base.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

class StopPoll {
 public:
  // The number of checks between two polls. That many checks take 10 µs if comparisons in bytes
  // find no pair, and 2 ms (4 MiB of pairs) if each check finds a pair.
  static constexpr uint64_t kChecksPerQuestion = uint64_t{1} << 19;

  // `stop` may be null; `out` is the buffer that the search grows.
  StopPoll(StopRequest* stop, const PairBuffer& out)
      : stop_(stop),
        out_(out),
        known_bytes_(out.capacity_bytes()),
        next_(stop == nullptr ? std::numeric_limits<uint64_t>::max() : kChecksPerQuestion) {}
  StopPoll(const StopPoll&) = delete;
  StopPoll& operator=(const StopPoll&) = delete;
  // Reports to the request how far the buffer has grown since the last poll.
  ~StopPoll() {
    if (stop_ != nullptr) stop_->WantsStop(NewBytes());
  }

  // Returns whether the search must end; it has made `check_count` checks so far.
  bool Ends(uint64_t check_count) { return check_count >= next_ && Ask(check_count); }
  // Returns the number of checks at which to call Ends next, or the maximum value without a
  // request.
  uint64_t next_question() const { return next_; }
  // Returns whether Ends has returned true.
  bool has_ended() const { return next_ == 0; }

 private:
  // Not inlined, since the inlined call would occupy registers of the kernels' loops.
  HWY_NOINLINE bool Ask(uint64_t check_count) {
    if (next_ == 0) return true;
    next_ = stop_->WantsStop(NewBytes()) ? 0 : check_count + kChecksPerQuestion;
    return next_ == 0;
  }

  uint64_t NewBytes() {
    const uint64_t before = known_bytes_;
    known_bytes_ = out_.capacity_bytes();
    return known_bytes_ - before;
  }

  StopRequest* const stop_;
  const PairBuffer& out_;
  uint64_t known_bytes_;
  uint64_t next_;  // the number of checks at which to poll next; 0 once the search has ended
};

// Returns whether the call must end. `stop` may be null.
inline bool IsStopped(StopRequest* stop) { return stop != nullptr && stop->WantsStop(0); }

// The number of boxes that are loaded, or moved by one pass of a sort, between two polls. They take
// 1 ms or less, even if each of them misses the caches. The number is a multiple of every granule
// that loops are divided by.
inline constexpr size_t kBoxesPerQuestion = size_t{1} << 15;

// Calls fn(from, to) for consecutive blocks of the items [begin, end), and polls `stop` before
// each. Returns false if the call must end; the remaining items are then skipped. Without a request
// all items form one block, so that the loop has no extra cost.
template <typename Fn>
bool ForEachBlock(StopRequest* stop, size_t begin, size_t end, const Fn& fn,
                  size_t block = kBoxesPerQuestion) {
  if (stop == nullptr) block = std::max<size_t>(end - begin, 1);
  for (size_t from = begin; from < end; from += block) {
    if (IsStopped(stop)) return false;
    fn(from, std::min(end, from + block));
  }
  return true;
}

}  // namespace sweepstake
