// Contains everything in the library that depends on whether it was built with exceptions. Without
// exceptions, these functions only call their argument `body`, and running out of memory ends the
// program (OutOfMemory in sweepstake/hooks.h).
#pragma once

#include <atomic>
#include <exception>
#include <new>

// __cpp_exceptions is the standard macro, _CPPUNWIND is MSVC's.
#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
#define SWEEPSTAKE_HAS_EXCEPTIONS 1
#else
#define SWEEPSTAKE_HAS_EXCEPTIONS 0
#endif

namespace sweepstake {

#if SWEEPSTAKE_HAS_EXCEPTIONS
inline namespace with_exceptions {

[[noreturn]] inline void ThrowOutOfMemory() { throw std::bad_alloc(); }

// Returns body(), or recover() if memory runs out in it.
template <typename Body, typename Recover>
auto CatchOutOfMemory(const Body& body, const Recover& recover) -> decltype(body()) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return recover();
  }
}

// Returns body(), or recover(message) if it throws any exception except std::bad_alloc.
template <typename Body, typename Recover>
auto CatchFailure(const Body& body, const Recover& recover) -> decltype(body()) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return recover(error.what());
  } catch (...) {
    return recover("an unknown exception");
  }
}

// Stores the first exception of several threads, so that the waiting thread can rethrow it.
class FirstException {
 public:
  template <typename Body>
  void Run(const Body& body) noexcept {
    try {
      body();
    } catch (...) {
      if (!has_failed_.exchange(true)) error_ = std::current_exception();
    }
  }
  // Rethrows the stored exception, if there is one. REQUIRES: no thread is in Run.
  void Rethrow() const {
    if (has_failed_) std::rethrow_exception(error_);
  }

 private:
  std::atomic<bool> has_failed_{false};
  std::exception_ptr error_;
};

}  // namespace with_exceptions
#else
inline namespace without_exceptions {

inline void ThrowOutOfMemory() {}

template <typename Body, typename Recover>
auto CatchOutOfMemory(const Body& body, const Recover& /*recover*/) -> decltype(body()) {
  return body();
}

template <typename Body, typename Recover>
auto CatchFailure(const Body& body, const Recover& /*recover*/) -> decltype(body()) {
  return body();
}

class FirstException {
 public:
  template <typename Body>
  void Run(const Body& body) noexcept {
    body();
  }
  void Rethrow() const {}
};

}  // namespace without_exceptions
#endif

}  // namespace sweepstake
