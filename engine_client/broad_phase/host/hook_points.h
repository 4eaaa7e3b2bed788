// Calls the hooks that a game has installed (sweepstake/hooks.h): profiler zones, thread starts,
// and memory for vectors. Thread-safe.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "sweepstake/hooks.h"

namespace sweepstake {

// The hooks of the process, or null if none were set.
extern std::atomic<const Hooks*> installed_hooks;

// Names of the zones that hooks.h documents.
inline constexpr char kZoneBeginFrame[] = "sweepstake: begin frame";
inline constexpr char kZoneUpdate[] = "sweepstake: update";
inline constexpr char kZoneSearch[] = "sweepstake: search";
inline constexpr char kZoneResolveProxies[] = "sweepstake: resolve proxies";
inline constexpr char kZoneLaneVisit[] = "sweepstake: lane visit";
inline constexpr char kZoneLanePreparation[] = "sweepstake: lane preparation";
inline constexpr char kZoneDecide[] = "sweepstake: decide";

// Marks a section of work for a profiler, from the constructor to the end of the scope.
//
//   const Zone zone(kZoneSearch);
class Zone {
 public:
  // `name` must live as long as the library.
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

enum class ThreadPriority { kOfTheStarter, kLow };

// Each thread that the library starts calls this function first. It sets the default
// floating-point environment, the name and the priority of the thread, and calls the hook. `name`
// is a literal of at most 15 characters, the limit of Linux.
void NoteThreadStarted(const char* name,
                       ThreadPriority priority = ThreadPriority::kOfTheStarter) noexcept;

// Returns the id of this process. A forked child has another id, and none of its parent's threads:
// it must not join them, nor use locks that they may hold. Makes a system call.
uint64_t ProcessId() noexcept;

// Return the CPU time of the calling thread, and of all threads of the process, in nanoseconds.
// Windows counts it in ticks of 16 ms. Return 0 if the system does not report it. Make a system
// call.
uint64_t ThreadCpuNs() noexcept;
uint64_t ProcessCpuNs() noexcept;

// Returns ThreadCpuNs() if it is precise enough to measure work of microseconds. Otherwise, on
// Windows, returns 0.
uint64_t ThreadTimeNs() noexcept;

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

// A vector for lists that grow with the number of boxes, proxies or pairs.
template <typename T>
using HookedVector = std::vector<T, HookAllocator<T>>;

}  // namespace sweepstake
