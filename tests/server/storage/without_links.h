// Makes hard links fail as on file systems that have none.
#pragma once

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <functional>
#include <optional>

namespace sweepstake::storage {

// Makes every later attempt of this process fail with EPERM. Returns false if the kernel does not
// allow this.
inline bool LoseLinks() {
  constexpr unsigned kFail = SECCOMP_RET_ERRNO | EPERM;
#ifdef SYS_link
  constexpr unsigned kLink = SYS_link;
#else
  constexpr unsigned kLink = SYS_linkat;
#endif
  std::array<sock_filter, 5> filter = {{
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kLink, 1, 0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_linkat, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, kFail),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  }};
  const sock_fprog program{.len = filter.size(), .filter = filter.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

// Runs `body` in a child process without hard links and returns its result; nothing if hard links
// cannot be disabled.
inline std::optional<bool> WithoutLinks(const std::function<bool()>& body) {
  constexpr int kHasLinks = 77;
  const pid_t child = fork();
  if (child == 0) _exit(!LoseLinks() ? kHasLinks : body() ? 0 : 1);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kHasLinks) return std::nullopt;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace sweepstake::storage
