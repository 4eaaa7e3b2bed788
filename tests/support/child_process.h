// A program that runs as a child process of the test.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

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

}  // namespace sweepstake::test_support
