// Moves the lanes that are set in a mask to the front of a register, for every target of Highway.
// Include after hwy/foreach_target.h.
//
// AVX-512 and SVE have an instruction for this move. Other targets use a shuffle with indices from
// a table. hn::Compress of Highway 1.0 also uses a table, but gcc 12 copies that table (1 KiB) to
// the stack in every call. This copying took more than half of the time of a search.
#if defined(SWEEPSTAKE_COMPRESS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_COMPRESS_INL_H_
#undef SWEEPSTAKE_COMPRESS_INL_H_
#else
#define SWEEPSTAKE_COMPRESS_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/compress_table.h"
#include "engine_client/broad_phase/common/lanes16-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Returns the lanes of `values` whose bits are set (BitsOfMask), in their order. The lanes behind
// them are unspecified. REQUIRES: lanes of 32 bits.
template <class V>
HWY_INLINE V CompressBits(V values, uint32_t bits) {
  using D = hn::DFromV<V>;
  static_assert(sizeof(hn::TFromD<D>) == 4);
  const D d;
#if HWY_TARGET == HWY_AVX2
  const hn::RebindToUnsigned<D> du;
  const hn::Rebind<uint8_t, D> bytes;
  const auto lanes = hn::PromoteTo(du, hn::LoadU(bytes, kCompressTable.of8[bits].data()));
  return hn::TableLookupLanes(values, hn::IndicesFromVec(d, lanes));
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_NEON
  const hn::Repartition<uint8_t, D> bytes;
  const auto places = hn::Load(bytes, kCompressTable.bytes_of4[bits].data());
  return hn::BitCast(d, hn::TableLookupBytes(hn::BitCast(bytes, values), places));
#else
  return hn::Compress(values, MaskOfBits(d, bits));
#endif
}

// Returns the lanes of `values` that are set in `mask`, like CompressBits.
template <class V, class M>
HWY_INLINE V CompressLanes(V values, M mask) {
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_NEON
  return CompressBits(values, BitsOfMask(hn::DFromV<V>(), mask));
#else
  return hn::Compress(values, mask);
#endif
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
