// A number that may change while other threads read it. Thread-safe; copies are independent.
#pragma once

#include <atomic>

namespace sweepstake::sessions {

template <typename T>
class Adjustable {
 public:
  template <typename Number>
  constexpr Adjustable(Number value) : value_(static_cast<T>(value)) {}
  Adjustable(const Adjustable& other) : value_(T{other}) {}
  Adjustable& operator=(const Adjustable& other) {
    value_.store(T{other}, std::memory_order_relaxed);
    return *this;
  }
  operator T() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<T> value_;
};

}  // namespace sweepstake::sessions
