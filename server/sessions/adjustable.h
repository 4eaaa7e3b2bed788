// A number that may change while others read it. Thread-safe; copies are numbers of their own.
#pragma once

#include <atomic>

namespace sweepstake::rpc {

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

}  // namespace sweepstake::rpc
