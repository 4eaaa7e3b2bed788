// `Status` is the outcome of an operation that can fail: a code for programs, and a message for
// people. `Result<T>` is a value, or the status that explains why there is none. Both may be copied
// between threads. Constructing an OK status does not allocate. X11/Xlib.h has a macro named
// Status: see names/begin.h.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "sweepstake/names/begin.h"

namespace sweepstake {

// The values are stable: swp_result of the C ABI has the same ones.
enum class StatusCode : int32_t {
  kOk = 0,
  kInvalidArgument = 1,     // The caller's value is wrong.
  kNotFound = 2,            // No such file or name.
  kDataLoss = 3,            // A file exists and its content is broken.
  kUnavailable = 4,         // Something cannot be reached; trying again may help.
  kResourceExhausted = 5,   // A documented bound was reached.
  kFailedPrecondition = 6,  // Calls in the wrong order.
  kInternal = 7,            // A bug in this library.
};

class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(StatusCode code, std::string message) : code_(code), message_(std::move(message)) {}

  bool ok() const { return code_ == StatusCode::kOk; }
  StatusCode code() const { return code_; }
  // Returns a single line without a full stop at the end; empty if ok.
  const std::string& message() const { return message_; }

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string message_;
};

// A value, or the status that explains why there is none.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}         // NOLINT: returned values convert
  Result(Status status) : state_(std::move(status)) {}  // NOLINT. REQUIRES: !status.ok()

  bool ok() const { return std::holds_alternative<T>(state_); }
  Status status() const { return ok() ? Status() : std::get<Status>(state_); }

  // REQUIRES: ok().
  T& operator*() { return std::get<T>(state_); }
  const T& operator*() const { return std::get<T>(state_); }
  T* operator->() { return &std::get<T>(state_); }
  const T* operator->() const { return &std::get<T>(state_); }

 private:
  std::variant<Status, T> state_;
};

}  // namespace sweepstake

#include "sweepstake/names/end.h"
