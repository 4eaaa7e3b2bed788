// Sorts overlap pairs in ascending order of a and then b, for callers whose results must not depend
// on the backend, and for comparing frames.
//
// Not thread-safe. Owns scratch memory, which is kept between calls: 8 bytes per pair and 48 KiB.
// Cost: O(pairs), with one pass for each 11 bits in which ids differ; proxy_set.h has figures.
#pragma once

#include <memory>
#include <span>

#include "sweepstake/aabb.h"

namespace sweepstake {

class PairSorter {
 public:
  PairSorter();
  ~PairSorter();
  PairSorter(PairSorter&&) noexcept;
  PairSorter& operator=(PairSorter&&) noexcept;

  // Sorts the pairs; duplicates are kept. If memory runs out, it ends as described at OutOfMemory()
  // (hooks.h). The order is unspecified then, but no pair is lost.
  void Sort(std::span<OverlapPair> pairs);

  size_t native_bytes() const;

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace sweepstake
