// Checks the sizes of structs of the C ABI, so that structs can grow without recompiling callers. A
// struct whose first member is struct_size may get new members at its end. The caller sets
// struct_size to the size that the struct had when the caller was compiled. The library accepts
// - its own size: the struct is used unchanged
// - the size of an earlier revision: the missing members get their defaults
// - a larger size (of a newer caller): only if all bytes beyond the library's own size are zero and
//   rejects every other size. Nothing beyond the caller's size is read or written.
//
// To extend a struct:
// - add fields at its end, without padding
// - add its previous size to kEarlierSizes below
// - increment SWP_ABI_REVISION
// - write the golden files again (abi_test.py)
//
// Thread safety: these functions have no state.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "engine_client/c_api/boundary.h"

namespace sweepstake::c_api {

// The sizes that a struct had in earlier revisions of this ABI.
template <typename Struct>
inline constexpr std::array<uint32_t, 0> kEarlierSizes{};

struct SizedStruct {
  std::string_view name;
  uint32_t size;
  std::span<const uint32_t> earlier_sizes;
};

// Replaces the beginning of `known`, which has the defaults, by the caller's values.
swp_result TakeSized(const SizedStruct& type, const void* given, void* known) noexcept;

// Copies `known` to the caller's struct `out`, as far as it fits. If `out` is larger, the rest is
// filled with zeros. struct_size is not changed.
swp_result GiveSized(const SizedStruct& type, const void* known, void* out) noexcept;

// Reads a struct of options from the caller. If `given` is NULL, `options` keeps the defaults.
template <typename Options>
swp_result TakeOptions(std::string_view name, const Options* given, Options& options) noexcept {
  static_assert(offsetof(Options, struct_size) == 0);
  if (given == nullptr) return SWP_OK;
  return TakeSized({name, sizeof(Options), kEarlierSizes<Options>}, given, &options);
}

// Writes `known` to a struct of the caller.
template <typename Struct>
swp_result Give(std::string_view name, const Struct& known, Struct* out) noexcept {
  static_assert(offsetof(Struct, struct_size) == 0);
  if (out == nullptr) return NullArgument(name);
  return GiveSized({name, sizeof(Struct), kEarlierSizes<Struct>}, &known, out);
}

}  // namespace sweepstake::c_api
