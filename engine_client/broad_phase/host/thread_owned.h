// A value that a thread of this process changes.
//
// A forked child does not have the thread. During the fork it may have been changing the value, or
// holding a lock in it. In a child the destructor therefore does nothing, and the child loses the
// value's memory. Thread safety: that of the value.
#pragma once

#include <cstdint>
#include <utility>

#include "engine_client/broad_phase/host/hook_points.h"

namespace sweepstake {

template <typename T>
class ThreadOwned {
 public:
  template <typename... Arguments>
  explicit ThreadOwned(Arguments&&... arguments) : value_(std::forward<Arguments>(arguments)...) {}
  ~ThreadOwned() {
    if (!is_in_child()) value_.~T();
  }
  ThreadOwned(const ThreadOwned&) = delete;
  ThreadOwned& operator=(const ThreadOwned&) = delete;

  // Returns whether this process is a forked child of the one that made the value.
  bool is_in_child() const { return ProcessId() != process_id_; }

  T& operator*() { return value_; }
  const T& operator*() const { return value_; }
  T* operator->() { return &value_; }
  const T* operator->() const { return &value_; }

 private:
  const uint64_t process_id_ = ProcessId();
  union {
    T value_;
  };
};

}  // namespace sweepstake
