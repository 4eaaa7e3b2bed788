// A pointer to a value that a thread of this process changes.
//
// A forked child does not have the thread. During the fork it may have been changing the value, or
// holding a lock in it. A child therefore does not delete the value, and loses its memory. Thread
// safety: that of the value.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "engine_client/broad_phase/host/hook_points.h"

namespace sweepstake {

class DeleteUnlessForked {
 public:
  // Returns whether this process is a forked child of the one that made this object.
  bool is_in_child() const { return ProcessId() != process_id_; }

  template <typename T>
  void operator()(T* value) const {
    if (!is_in_child()) delete value;
  }

 private:
  uint64_t process_id_ = ProcessId();
};

template <typename T>
using ThreadOwned = std::unique_ptr<T, DeleteUnlessForked>;

template <typename T, typename... Arguments>
ThreadOwned<T> MakeThreadOwned(Arguments&&... arguments) {
  return ThreadOwned<T>(new T(std::forward<Arguments>(arguments)...));
}

}  // namespace sweepstake
