#include "sweepstake/hooks.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "engine_client/broad_phase/host/exceptions.h"
#include "engine_client/broad_phase/host/hook_points.h"

namespace sweepstake {

constinit std::atomic<const Hooks*> installed_hooks{nullptr};

namespace {

constinit Hooks hooks_of_process;
// The number of blocks that were allocated and not released. It changes only when a buffer grows or
// is freed.
constinit std::atomic<size_t> live_block_count{0};

void* NewBlock(size_t bytes, size_t alignment) {
  const Hooks* hooks = installed_hooks.load(std::memory_order_relaxed);
  if (hooks != nullptr && hooks->allocate != nullptr) {
    return hooks->allocate(bytes, alignment, hooks->user);
  }
  return ::operator new (bytes, std::align_val_t{alignment}, std::nothrow);
}

}  // namespace

Status SetHooks(const Hooks& hooks) {
  if ((hooks.allocate == nullptr) != (hooks.release == nullptr)) {
    return {StatusCode::kInvalidArgument, "give both allocate and release, or neither"};
  }
  if ((hooks.zone_begin == nullptr) != (hooks.zone_end == nullptr)) {
    return {StatusCode::kInvalidArgument, "give both zone_begin and zone_end, or neither"};
  }
  if (live_block_count.load() > 0) {
    return {StatusCode::kFailedPrecondition,
            "memory from the present hooks is in use: call SetHooks before creating any object"};
  }
  hooks_of_process = hooks;
  installed_hooks.store(&hooks_of_process);
  return {};
}

void* AllocateMemory(size_t bytes, size_t alignment) {
  void* const block = NewBlock(std::max<size_t>(bytes, 1), alignment);
  if (block == nullptr) OutOfMemory();
  live_block_count.fetch_add(1, std::memory_order_relaxed);
  return block;
}

void ReleaseMemory(void* pointer, size_t bytes, size_t alignment) noexcept {
  if (pointer == nullptr) return;
  live_block_count.fetch_sub(1, std::memory_order_relaxed);
  const Hooks* hooks = installed_hooks.load(std::memory_order_relaxed);
  if (hooks != nullptr && hooks->release != nullptr) {
    hooks->release(pointer, std::max<size_t>(bytes, 1), alignment, hooks->user);
  } else {
    ::operator delete (pointer, std::align_val_t{alignment});
  }
}

void OutOfMemory() {
  ThrowOutOfMemory();
  const Hooks* hooks = installed_hooks.load(std::memory_order_relaxed);
  if (hooks != nullptr && hooks->out_of_memory != nullptr) hooks->out_of_memory(hooks->user);
  std::fputs("sweepstake: out of memory\n", stderr);
  std::abort();
}

}  // namespace sweepstake
