// Measures how much of its stack a function uses.
#pragma once

#include <cstddef>
#include <functional>

#include "tests/support/sanitizers/active.h"

// 1 on Linux without a sanitizer, which has frames of its own; otherwise 0.
#if defined(__linux__) && !SWEEPSTAKE_ASAN && !SWEEPSTAKE_TSAN
#define SWEEPSTAKE_MEASURES_STACK 1
#else
#define SWEEPSTAKE_MEASURES_STACK 0
#endif

namespace sweepstake::test_support {

// The size of the stack on which `function` runs.
inline constexpr size_t kMeasuredStackBytes = 1 << 20;

// Runs `function` on a new thread and returns the bytes of the thread's stack that it has written,
// without those that an idle thread uses. Returns 0 if SWEEPSTAKE_MEASURES_STACK is 0. `function`
// must not use more than kMeasuredStackBytes.
size_t StackBytesOf(const std::function<void()>& function);

}  // namespace sweepstake::test_support
