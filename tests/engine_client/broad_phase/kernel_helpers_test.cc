// Compares the building blocks of the kernels with loops over lanes, for each mask and instruction
// set.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "tests/engine_client/broad_phase/each_simd_target.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/engine_client/broad_phase/kernel_helpers_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/overlap_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

using Ids = hn::CappedTag<uint32_t, 16>;
constexpr uint32_t kFirstId = 100;

// Returns the first error in the ids that the mask moved to the front, or "" if there is none.
std::string CompressError(const uint32_t* compressed, uint32_t bits) {
  for (uint32_t lane = 0; lane < 16; ++lane) {
    if ((bits >> lane & 1) != 0 && *compressed++ != kFirstId + lane)
      return "mask " + std::to_string(bits) + ", lane " + std::to_string(lane);
  }
  return "";
}

std::string CompressErrors() {
  const Ids d;
  const auto ids = NumbersFrom(d, kFirstId);
  uint32_t found[16];
  std::string error;
  for (uint32_t bits = 0; bits < 1U << hn::Lanes(d) && error.empty(); ++bits) {
    const auto mask = MaskOfBits(d, bits);
    if (BitsOfMask(d, mask) != bits) return "bits of mask " + std::to_string(bits);
    hn::StoreU(CompressBits(ids, bits), d, found);
    error = CompressError(found, bits);
    if (!error.empty()) break;
    hn::StoreU(CompressLanes(ids, mask), d, found);
    error = CompressError(found, bits);
  }
  return error;
}

// Returns the first error in the pairs of `self` with partners from kFirstId on, or "" if there is
// none.
template <bool kAlways>
std::string PairsError(uint32_t self) {
  const Ids d;
  for (size_t count = 0; count <= hn::Lanes(d); ++count) {
    OverlapPair pairs[32] = {};
    StorePairs<kAlways>(hn::Set(d, self), NumbersFrom(d, kFirstId), count, pairs);
    for (uint32_t k = 0; k < count; ++k) {
      const uint32_t partner = kFirstId + k;
      if (pairs[k].a != std::min(self, partner) || pairs[k].b != std::max(self, partner))
        return "pair " + std::to_string(k) + " of " + std::to_string(count);
    }
  }
  return "";
}

// Tests own ids that are smaller than the ids of all partners, larger, and in between.
std::string StorePairsErrors() {
  std::string errors;
  for (const uint32_t self : {0U, kFirstId + 1, 4'000'000'000U})
    errors += PairsError<false>(self) + PairsError<true>(self);
  return errors;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {
namespace {

using test_support::OnEachSimdTarget;

HWY_EXPORT(CompressErrors);
HWY_EXPORT(StorePairsErrors);

TEST(CompressBits, MovesTheLanesOfEachMaskToTheFront) {
  OnEachSimdTarget([] { EXPECT_EQ(HWY_DYNAMIC_DISPATCH(CompressErrors)(), ""); });
}

TEST(StorePairs, PutsTheLesserIdFirstForAnyNumberOfPairs) {
  OnEachSimdTarget([] { EXPECT_EQ(HWY_DYNAMIC_DISPATCH(StorePairsErrors)(), ""); });
}

}  // namespace
}  // namespace sweepstake

#endif  // HWY_ONCE
