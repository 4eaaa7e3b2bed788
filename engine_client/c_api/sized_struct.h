// How structs of the C ABI grow while callers stay as they are compiled: the one place that
// compares sizes. A struct whose first member is struct_size may grow at its end. Its caller sets
// struct_size to what it was compiled with, and the library takes
//
//   its own size                 as it is,
//   the size of an earlier revision   with the defaults in the place of the rest,
//   a larger one (a newer caller)     if it is all zero beyond the library's own size,
//
// and refuses every other size. Nothing beyond the caller's size is read or written.
//
// To let a struct grow: add fields at its end (none may be padding), put its former size into
// kEarlierSizes below, raise SWP_ABI_REVISION, and write the golden files again (abi_test.py).
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

// Overwrites the beginning of `known`, which holds the defaults, with what the caller gave.
swp_result TakeSized(const SizedStruct& type, const void* given, void* known) noexcept;

// Writes as much of `known` as the caller's struct holds, and zeros where it is larger; struct_size
// stays.
swp_result GiveSized(const SizedStruct& type, const void* known, void* out) noexcept;

// Takes options of the caller, where NULL leaves `options` as they are: the defaults.
template <typename Options>
swp_result TakeOptions(std::string_view name, const Options* given, Options& options) noexcept {
  static_assert(offsetof(Options, struct_size) == 0);
  if (given == nullptr) return SWP_OK;
  return TakeSized({name, sizeof(Options), kEarlierSizes<Options>}, given, &options);
}

// Fills a struct of the caller.
template <typename Struct>
swp_result Give(std::string_view name, const Struct& known, Struct* out) noexcept {
  static_assert(offsetof(Struct, struct_size) == 0);
  if (out == nullptr) return NullArgument(name);
  return GiveSized({name, sizeof(Struct), kEarlierSizes<Struct>}, &known, out);
}

}  // namespace sweepstake::c_api
