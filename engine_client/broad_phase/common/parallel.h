// Splits a backend's loops into parts, which run with or without an Executor.
//
// Not thread-safe; a part must not access what another part writes. Errors: the first exception of
// a part, e.g. std::bad_alloc, is rethrown on the calling thread after all parts have ended.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/stop_poll.h"
#include "engine_client/broad_phase/host/exceptions.h"
#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/executor.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Calls fn(part) for each part in [0, part_count). Without an executor the calls are in order.
template <typename Fn>
void RunParts(Executor* executor, size_t part_count, const Fn& fn) {
  if (executor == nullptr || part_count <= 1) {
    for (size_t part = 0; part < part_count; ++part) fn(part);
    return;
  }
  struct Context {
    const Fn& fn;
    FirstException failure{};
  } context{fn};
  executor->RunParts(
      part_count,
      [](void* opaque, size_t part) {
        const FloatEnvironmentScope scope;  // the thread may belong to the game
        auto& shared = *static_cast<Context*>(opaque);
        shared.failure.Run([&] { shared.fn(part); });
      },
      &context);
  context.failure.Rethrow();
}

// The items [begin, end) of one part. RangeOfPart divides `item_count` items evenly, with borders
// at multiples of `granule`.
struct PartRange {
  size_t begin;
  size_t end;
};
inline PartRange RangeOfPart(size_t item_count, size_t part, size_t part_count, size_t granule) {
  const auto border = [&](size_t k) {
    return std::min(item_count, item_count * k / part_count / granule * granule);
  };
  return {border(part), part + 1 == part_count ? item_count : border(part + 1)};
}

// Returns the number of parts: up to eight per thread, so that uneven parts balance out, but at
// least `items_min` items per part.
inline size_t PartCount(const Executor* executor, size_t item_count, size_t items_min) {
  constexpr size_t kPartsPerThread = 8;
  if (executor == nullptr || executor->thread_count() <= 1) return 1;
  return std::clamp<size_t>(item_count / std::max<size_t>(items_min, 1), 1,
                            kPartsPerThread * executor->thread_count());
}

// The maximum number of parts that each fill a table of their own. Adding up more tables would take
// longer than filling them.
inline constexpr size_t kMaxTableParts = 8;

// As PartCount, for parts that each fill a table: at most one per thread, and kMaxTableParts.
// REQUIRES: items_min > 0.
inline size_t TablePartCount(const Executor* executor, size_t item_count, size_t items_min) {
  if (executor == nullptr) return 1;
  return std::clamp<size_t>(item_count / items_min, 1,
                            std::min(executor->thread_count(), kMaxTableParts));
}

// Finds pairs in parts and joins the results in the order of the parts, so that the order of pairs
// does not depend on the number of threads. Owns one pair buffer per part, kept between calls.
class PairParts {
 public:
  // Calls find(begin, end, pairs) for each part's items and returns the sum of the checks. `find`
  // appends to `pairs`, which is `out` itself for the first part, and returns its AABB checks.
  // `find` must poll `stop` too. After a stop, no further part starts, and `out` gets only the
  // first part's pairs.
  template <typename Find>
  uint64_t Run(Executor* executor, size_t item_count, size_t items_min, size_t granule,
               PairBuffer& out, const Find& find, StopRequest* stop = nullptr) {
    const size_t part_count = PartCount(executor, item_count, items_min);
    if (part_count == 1) return find(size_t{0}, item_count, out);
    if (parts_.size() < part_count) parts_.resize(part_count);
    RunParts(executor, part_count, [&](size_t part) {
      PairBuffer& pairs = part == 0 ? out : parts_[part].pairs;
      if (part != 0) pairs.Clear();
      const PartRange range = RangeOfPart(item_count, part, part_count, granule);
      parts_[part].checks = IsStopped(stop) ? 0 : find(range.begin, range.end, pairs);
    });
    Join(executor, part_count, out, stop);
    uint64_t checks = 0;
    for (size_t part = 0; part < part_count; ++part) checks += parts_[part].checks;
    return checks;
  }

  size_t native_bytes() const {
    size_t bytes = parts_.capacity() * sizeof(Part);
    for (const Part& part : parts_) bytes += part.pairs.capacity_bytes();
    return bytes;
  }

 private:
  // Each part has its own cache line, since threads that write to one line wait for one another.
  struct alignas(64) Part {
    PairBuffer pairs;
    uint64_t checks = 0;
    size_t offset = 0;
  };

  void Join(Executor* executor, size_t part_count, PairBuffer& out, StopRequest* stop) {
    constexpr size_t kPairsToCopyInParallel = 32'768;
    size_t total = 0;
    for (size_t part = 1; part < part_count; ++part) {
      parts_[part].offset = total;
      total += parts_[part].pairs.size();
    }
    const size_t joined_bytes = (out.size() + total) * sizeof(OverlapPair);
    const size_t known_bytes = std::min(joined_bytes, out.capacity_bytes());
    if (total == 0 || (stop != nullptr && stop->WantsStop(joined_bytes - known_bytes, 0))) return;
    OverlapPair* const end = out.EnsureRoom(total);
    RunParts(total < kPairsToCopyInParallel ? nullptr : executor, part_count - 1,
             [&](size_t index) {
               const Part& part = parts_[index + 1];
               const auto pairs = part.pairs.pairs();
               std::copy(pairs.begin(), pairs.end(), end + part.offset);
             });
    out.Advance(total);
  }

  HookedVector<Part> parts_;
};

}  // namespace sweepstake
