// Measures how much of its stack a function uses.
#pragma once

#include <cstddef>
#include <functional>

namespace sweepstake::test_support {

// The size of the stack on which `function` runs.
inline constexpr size_t kMeasuredStackBytes = 1 << 20;

// Runs `function` on a new thread and returns the bytes of the thread's stack that it has written,
// without those that an idle thread uses. Linux only; 0 elsewhere, and with a sanitizer, which has
// frames of its own. `function` must not use more than kMeasuredStackBytes.
size_t StackBytesOf(const std::function<void()>& function);

}  // namespace sweepstake::test_support
