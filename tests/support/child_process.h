// Child processes of a test: a program, and a fork of the test itself. SWEEPSTAKE_CAN_FORK is 1
// where a test can fork; not with ThreadSanitizer, which does not support it in programs with
// threads.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/sanitizers/active.h"

#if defined(__unix__) && !SWEEPSTAKE_TSAN
#define SWEEPSTAKE_CAN_FORK 1
#include <sys/wait.h>
#include <unistd.h>
#else
#define SWEEPSTAKE_CAN_FORK 0
#endif

namespace sweepstake::test_support {

class ChildProcess {
 public:
  // Starts `arguments[0]`, searched in PATH, and appends its stderr to `log`. Aborts the test
  // program if it cannot be started.
  ChildProcess(std::vector<std::string> arguments, std::filesystem::path log);
  ~ChildProcess();  // kill -9 if it still runs
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  // Returns the content of the log file so far.
  std::string log() const;
  // Returns whether the process has ended by itself.
  bool ended();
  void Signal(int signal) const;
  // Sends SIGKILL and waits for the end.
  void Kill();
  // Sends SIGTERM; returns the exit code, or -1 if the process had ended or a signal ended it.
  int Terminate();

 private:
  // Waits for the end; returns the exit code, or -1 if there is none.
  int Await();

  std::filesystem::path log_;
  pid_t pid_ = -1;  // -1 after its end
};

#if SWEEPSTAKE_CAN_FORK
// Returns the status of a forked child that calls `body`; 0 if `body` returns. If `body` waits for
// something that the child lacks, a signal ends the child after a minute.
template <typename Body>
int StatusOfChild(const Body& body) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    body();
    _exit(0);
  }
  int status = -1;
  return waitpid(child, &status, 0) == child ? status : -1;
}
#endif

}  // namespace sweepstake::test_support
