// Puts overlap pairs into ascending order, by a and then by b: for callers whose outcome must not
// depend on the backend, and for comparing one frame with another.
//
// Not thread-safe. Owns scratch memory, kept between calls: 8 bytes per pair and 48 KiB. Cost:
// O(pairs) whatever their ids are, a pass for each 11 bits in which ids differ; see proxy_set.h for
// figures.
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

  // Equal pairs stay, side by side. Throws std::bad_alloc when memory is out; the order is then
  // unspecified and no pair is lost.
  void Sort(std::span<OverlapPair> pairs);

  size_t native_bytes() const;

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace sweepstake
