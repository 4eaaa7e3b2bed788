// Counts system calls with a seccomp filter in a child process: every call except the return from a
// signal handler traps, is counted, and is not executed. The clock counts like any other call; if
// the kernel serves it without a system call (vDSO), it is not counted.
//
// For programs with one thread at the time of the call. Linux only.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace sweepstake::test_support {

struct SystemCallCount {
  uint64_t count = 0;
  int last_number = -1;  // number of the latest call, see <sys/syscall.h>
};

// Runs `work` in a copy of this process. Returns nullopt if the kernel does not support the filter,
// or if the copy did not finish its work.
std::optional<SystemCallCount> CountSystemCalls(const std::function<void()>& work);

}  // namespace sweepstake::test_support
