// Counts the system calls that something makes, by a seccomp filter in a child process: every call
// but the return from a signal handler traps, is counted, and is not carried out. The clock counts
// like any other call; where the kernel serves it without one (vDSO), it makes none.
//
// For programs with one thread at the time of the call. Linux only.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace sweepstake::test_support {

struct SystemCallCount {
  uint64_t count = 0;
  int last_number = -1;  // the latest call's number, as in <sys/syscall.h>
};

// Runs `work` in a copy of this process. Absent where the kernel has no such filter, or the copy
// ended otherwise than by finishing its work.
std::optional<SystemCallCount> CountSystemCalls(const std::function<void()>& work);

}  // namespace sweepstake::test_support
