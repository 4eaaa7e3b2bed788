#include "tests/support/stack_use.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <thread>

#if SWEEPSTAKE_MEASURES_STACK
#include <pthread.h>
#include <sys/mman.h>
#endif

namespace sweepstake::test_support {

#if SWEEPSTAKE_MEASURES_STACK
namespace {

constexpr unsigned char kPaint = 0xA5;

extern "C" {
static void* RunFunction(void* function) {
  (*static_cast<const std::function<void()>*>(function))();
  return nullptr;
}
}

// Returns the bytes of a painted stack that were overwritten. The stack grows downwards.
size_t WrittenBytes(const std::function<void()>& function) {
  void* const stack = mmap(nullptr, kMeasuredStackBytes, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK, -1, 0);
  std::memset(stack, kPaint, kMeasuredStackBytes);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstack(&attributes, stack, kMeasuredStackBytes);
  pthread_t thread;
  pthread_create(&thread, &attributes, RunFunction,
                 const_cast<void*>(static_cast<const void*>(&function)));
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  const auto* const bytes = static_cast<const unsigned char*>(stack);
  const auto* const first = std::find_if(bytes, bytes + kMeasuredStackBytes,
                                         [](unsigned char byte) { return byte != kPaint; });
  const size_t written = kMeasuredStackBytes - static_cast<size_t>(first - bytes);
  munmap(stack, kMeasuredStackBytes);
  return written;
}

}  // namespace

size_t StackBytesOf(const std::function<void()>& function) {
  const size_t idle = WrittenBytes([] {});
  const size_t written = WrittenBytes(function);
  return written - std::min(written, idle);
}

#else

size_t StackBytesOf(const std::function<void()>& function) {
  std::thread(function).join();
  return 0;
}

#endif

}  // namespace sweepstake::test_support
