// The boundary between C++ and C: results, the message of the latest failure, and the guard that
// catches every exception of an exported function. Thread-safe: each thread has its own message.
#pragma once

#include <exception>
#include <new>
#include <string_view>

#include "sweepstake/c_api.h"
#include "sweepstake/status.h"

namespace sweepstake::c_api {

// Keeps the message for swp_last_error, cut to 1,023 bytes, and returns `result`. Does not
// allocate.
swp_result Fail(swp_result result, std::string_view message) noexcept;

// SWP_OK, or Fail with the status's code and message.
swp_result ToResult(const Status& status) noexcept;

// "NAME must not be NULL".
swp_result NullArgument(std::string_view name) noexcept;

// "struct_size of NAME is … and must be …" where the two differ, else SWP_OK.
swp_result CheckStructSize(std::string_view name, uint32_t given, size_t expected) noexcept;

// Checks the first member of an options struct; NULL is valid. It must be called before anything
// else of the struct is read: a caller compiled against another version may own fewer bytes.
template <typename Options>
swp_result CheckStruct(std::string_view name, const Options* options) noexcept {
  if (options == nullptr) return SWP_OK;
  return CheckStructSize(name, options->struct_size, sizeof(Options));
}

// Runs `body`, which returns a swp_result, and turns an exception into one.
template <typename Body>
swp_result Guard(const Body& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return Fail(SWP_RESOURCE_EXHAUSTED, "memory is out: use fewer objects");
  } catch (const std::exception& error) {
    return Fail(SWP_INTERNAL, error.what());
  } catch (...) {
    return Fail(SWP_INTERNAL, "an unknown exception");
  }
}

// The text of a C string, or `absent` for NULL.
inline std::string_view TextOr(const char* text, std::string_view absent) {
  return text == nullptr ? absent : std::string_view(text);
}

}  // namespace sweepstake::c_api
