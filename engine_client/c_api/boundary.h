// The boundary between C++ and C: converts results, keeps the message of the latest failure,
// catches all exceptions of exported functions, and checks boxes and pairs. Thread-safe: each
// thread has its own message.
#pragma once

#include <span>
#include <string_view>

#include "engine_client/broad_phase/host/exceptions.h"
#include "engine_client/broad_phase/host/float_environment.h"
#include "sweepstake/aabb.h"
#include "sweepstake/c_api.h"
#include "sweepstake/status.h"

namespace sweepstake::c_api {

// Stores the message for swp_last_error, cut to 1,023 bytes, and returns `result`. Allocates
// nothing.
swp_result Fail(swp_result result, std::string_view message) noexcept;

// Returns SWP_OK, or Fail with the status's code and message.
swp_result ToResult(const Status& status) noexcept;

// Fails with "NAME must not be NULL".
swp_result NullArgument(std::string_view name) noexcept;

// Runs `body`, which returns a swp_result, in the default floating-point environment. If it throws
// an exception, returns a failure instead.
template <typename Body>
swp_result Guard(const Body& body) noexcept {
  const FloatEnvironmentScope environment;
  return CatchOutOfMemory(
      [&] { return CatchFailure(body, [](const char* what) { return Fail(SWP_INTERNAL, what); }); },
      [] { return Fail(SWP_RESOURCE_EXHAUSTED, "out of memory: use fewer objects"); });
}

// Returns the text of a C string, or `absent` for NULL.
inline std::string_view TextOr(const char* text, std::string_view absent) {
  return text == nullptr ? absent : std::string_view(text);
}

// Returns SWP_OK if `boxes` can be passed to a backend as an array of `count` boxes.
inline swp_result CheckBoxes(const swp_aabb* boxes, uint32_t count) noexcept {
  if (boxes == nullptr && count > 0) return NullArgument("boxes");
  if (count > 0x7fffffffU) return Fail(SWP_INVALID_ARGUMENT, "more than 2147483647 boxes");
  return SWP_OK;
}

inline std::span<const Aabb> ToBoxes(const swp_aabb* boxes, uint32_t count) {
  return {reinterpret_cast<const Aabb*>(boxes), count};
}

// Returns the failure for a search that max_pairs has ended.
inline swp_result TooManyPairs() noexcept {
  return Fail(SWP_RESOURCE_EXHAUSTED,
              "the boxes have more pairs than max_pairs: move objects apart, use fewer, or raise "
              "max_pairs");
}

// Returns the failure for a buffer of the caller that is too small.
inline swp_result TooFewPlaces() noexcept {
  return Fail(
      SWP_RESOURCE_EXHAUSTED,
      "the buffer is too small for the results; the call has written the size that they need");
}

inline constexpr swp_result kOk = SWP_OK;

// Writes the pairs' address and number. The pairs stay in the library's memory.
template <typename From, typename To>
swp_result GivePairs(std::span<From> pairs, const To** first, uint64_t* count) noexcept {
  static_assert(sizeof(From) == sizeof(To));
  if (first == nullptr || count == nullptr) return NullArgument("pairs and count");
  *first = reinterpret_cast<const To*>(pairs.data());
  *count = pairs.size();
  return SWP_OK;
}

}  // namespace sweepstake::c_api
