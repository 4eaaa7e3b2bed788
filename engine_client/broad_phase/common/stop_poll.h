// Polls a StopRequest (broad_phase.h) at intervals. StopPoll does so during a search, and
// ForEachBlock while boxes are loaded and sorted.
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
  // The number of checks between two polls. These checks take 10 µs if comparisons in bytes find no
  // pair, and 2 ms (4 MiB of pairs) if each check finds a pair.
  static constexpr uint64_t kChecksPerQuestion = uint64_t{1} << 19;

  // `stop` may be null; `out` is the buffer that the search grows.
  StopPoll(StopRequest* stop, const PairBuffer& out)
      : stop_(stop),
        out_(out),
        known_bytes_(out.capacity_bytes()),
        known_pairs_(out.size()),
        next_(stop == nullptr ? std::numeric_limits<uint64_t>::max() : kChecksPerQuestion) {}
  StopPoll(const StopPoll&) = delete;
  StopPoll& operator=(const StopPoll&) = delete;
  // Reports to the request how far the buffer has grown since the last poll.
  ~StopPoll() {
    if (stop_ != nullptr)
      stop_->OnEnd(out_.capacity_bytes() - known_bytes_, out_.size() - known_pairs_);
  }

  // Returns whether the search, which has made `check_count` checks so far, must end.
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
    next_ = Report() ? 0 : check_count + kChecksPerQuestion;
    return next_ == 0;
  }

  bool Report() {
    const uint64_t grown_bytes = out_.capacity_bytes() - known_bytes_;
    const uint64_t found_pairs = out_.size() - known_pairs_;
    known_bytes_ += grown_bytes;
    known_pairs_ += found_pairs;
    return stop_->WantsStop(grown_bytes, found_pairs);
  }

  StopRequest* const stop_;
  const PairBuffer& out_;
  uint64_t known_bytes_;
  uint64_t known_pairs_;
  uint64_t next_;  // the number of checks at which to poll next; 0 once the search has ended
};

// Returns whether the call in progress must end. `stop` may be null.
inline bool IsStopped(StopRequest* stop) { return stop != nullptr && stop->WantsStop(0, 0); }

// The number of boxes that are processed between two polls while boxes are loaded or sorted. In a
// sort, each pass over a box counts. Processing this number of boxes takes 1 ms or less, even if
// each access misses the caches. It is a power of two and thus a multiple of the block sizes by
// which loops are divided (ByteBoxes::kGranule and similar constants).
inline constexpr size_t kBoxesPerQuestion = size_t{1} << 15;

// Calls fn(from, to) for consecutive blocks of the items [begin, end), and polls `stop` before each
// block. Returns false if `stop` ended the loop; the remaining items are then skipped. If `stop` is
// null, all items form one block, so that the loop has no extra cost.
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
