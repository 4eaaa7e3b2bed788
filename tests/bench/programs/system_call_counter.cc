#include "tests/bench/programs/system_call_counter.h"

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>

namespace sweepstake::test_support {
namespace {

// This memory is shared with the parent process, because the signal handler cannot report its
// counts in another way.
struct Tally {
  SystemCallCount calls;
  bool finished;
};
Tally* tally = nullptr;

void OnTrap(int, siginfo_t* trap, void*) {
  ++tally->calls.count;
  tally->calls.last_number = trap->si_syscall;
}

// Traps every system call except the return from a signal handler and the end of the process.
bool TrapSystemCalls() {
  struct sigaction action = {};
  action.sa_sigaction = OnTrap;
  action.sa_flags = SA_SIGINFO | SA_NODEFER;
  if (sigaction(SIGSYS, &action, nullptr) != 0) return false;
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_rt_sigreturn, 2, 0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program = {sizeof filter / sizeof filter[0], filter};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

[[noreturn]] void RunChild(const std::function<void()>& work) {
  if (TrapSystemCalls()) {
    work();
    tally->finished = true;
  }
  _exit(0);
}

}  // namespace

std::optional<SystemCallCount> CountSystemCalls(const std::function<void()>& work) {
  void* const shared =
      mmap(nullptr, sizeof(Tally), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) return std::nullopt;
  tally = new (shared) Tally{};
  const pid_t child = fork();
  if (child == 0) RunChild(work);
  if (child > 0) (void)waitpid(child, nullptr, 0);
  const Tally result = *tally;
  (void)munmap(shared, sizeof(Tally));
  tally = nullptr;
  return child > 0 && result.finished ? std::optional(result.calls) : std::nullopt;
}

}  // namespace sweepstake::test_support
