// The places where the library calls a game's hooks (sweepstake/hooks.h): zones, threads, and
// vectors whose memory comes from the hooks. Thread-safe.
#pragma once

#include <atomic>
#include <cstddef>
#include <limits>
#include <vector>

#include "sweepstake/hooks.h"

namespace sweepstake {

// The hooks of the process; null: none were set.
extern std::atomic<const Hooks*> installed_hooks;

// A stretch of work that a profiler shows, from here to the end of the scope.
//
//   const Zone zone("sweepstake: find pairs");
class Zone {
 public:
  // `name` is a literal.
  explicit Zone(const char* name) noexcept
      : hooks_(installed_hooks.load(std::memory_order_relaxed)), name_(name) {
    if (hooks_ != nullptr && hooks_->zone_begin != nullptr) hooks_->zone_begin(name_, hooks_->user);
  }
  ~Zone() {
    if (hooks_ != nullptr && hooks_->zone_end != nullptr) hooks_->zone_end(name_, hooks_->user);
  }
  Zone(const Zone&) = delete;
  Zone& operator=(const Zone&) = delete;

 private:
  const Hooks* hooks_;
  const char* name_;
};

// Called first on each thread that the library starts. `name` is a literal of at most 15
// characters, what Linux shows.
inline void NoteThreadStarted(const char* name) noexcept {
  const Hooks* hooks = installed_hooks.load(std::memory_order_relaxed);
  if (hooks != nullptr && hooks->thread_started != nullptr) {
    hooks->thread_started(name, hooks->user);
  }
}

template <typename T>
struct HookAllocator {
  using value_type = T;

  HookAllocator() = default;
  template <typename U>
  HookAllocator(const HookAllocator<U>& /*other*/) noexcept {}  // NOLINT: allocators convert

  T* allocate(size_t count) {
    if (count > (std::numeric_limits<size_t>::max)() / sizeof(T)) OutOfMemory();
    return static_cast<T*>(AllocateMemory(count * sizeof(T), alignof(T)));
  }
  void deallocate(T* pointer, size_t count) noexcept {
    ReleaseMemory(pointer, count * sizeof(T), alignof(T));
  }

  friend bool operator==(const HookAllocator&, const HookAllocator&) { return true; }
};

// For lists that grow with the number of boxes, proxies or pairs.
template <typename T>
using HookedVector = std::vector<T, HookAllocator<T>>;

}  // namespace sweepstake
