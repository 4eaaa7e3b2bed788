// Checks the sizes of structs of the C ABI, so that structs can grow while compiled callers stay
// the same. A struct whose first member is struct_size may grow at its end. Its caller sets
// struct_size to the size it was compiled with, and the library accepts
//
//   its own size                      unchanged,
//   the size of an earlier revision   with defaults for the missing members,
//   a larger size (a newer caller)    if all bytes beyond the library's own size are zero,
//
// and refuses every other size. Nothing beyond the caller's size is read or written.
//
// To extend a struct: add fields at its end without padding, add its previous size to kEarlierSizes
// below, increment SWP_ABI_REVISION, and write the golden files again (abi_test.py).
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

// Overwrites the beginning of `known`, which holds the defaults, with the caller's values.
swp_result TakeSized(const SizedStruct& type, const void* given, void* known) noexcept;

// Copies `known` to the caller's struct as far as it fits, and fills the rest with zeros;
// struct_size stays unchanged.
swp_result GiveSized(const SizedStruct& type, const void* known, void* out) noexcept;

// Reads options of the caller; for NULL `options` keeps the defaults.
template <typename Options>
swp_result TakeOptions(std::string_view name, const Options* given, Options& options) noexcept {
  static_assert(offsetof(Options, struct_size) == 0);
  if (given == nullptr) return SWP_OK;
  return TakeSized({name, sizeof(Options), kEarlierSizes<Options>}, given, &options);
}

// Writes to a struct of the caller.
template <typename Struct>
swp_result Give(std::string_view name, const Struct& known, Struct* out) noexcept {
  static_assert(offsetof(Struct, struct_size) == 0);
  if (out == nullptr) return NullArgument(name);
  return GiveSized({name, sizeof(Struct), kEarlierSizes<Struct>}, &known, out);
}

}  // namespace sweepstake::c_api
