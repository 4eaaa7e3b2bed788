// A program that runs beside the test.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace sweepstake::test_support {

class ChildProcess {
 public:
  // Starts `arguments[0]`, which is looked for in PATH, and appends to `log` what it says on
  // stderr. Aborts the test program if it cannot be started.
  ChildProcess(std::vector<std::string> arguments, std::filesystem::path log);
  ~ChildProcess();  // kill -9 when still running
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  // What it has said so far.
  std::string log() const;
  // Returns whether it has ended by itself.
  bool ended();
  void Signal(int signal) const;
  // kill -9, and waits for the end.
  void Kill();
  // SIGTERM; the exit code, or -1 when it ended before or a signal ended it.
  int Terminate();

 private:
  // The exit code, or -1.
  int Await();

  std::filesystem::path log_;
  pid_t pid_ = -1;  // -1 from its end on
};

}  // namespace sweepstake::test_support
