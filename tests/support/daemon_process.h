// A real `sweepstaked` as a child process on an ephemeral loopback port, for end-to-end tests.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/child_process.h"

namespace sweepstake::test_support {

class DaemonProcess {
 public:
  // Starts the daemon, which allows any time scale, and returns when it listens. `listen` may set a
  // port, to use the same one after a kill. Aborts the test program with the daemon's log if it
  // does not start.
  explicit DaemonProcess(const std::filesystem::path& data,
                         const std::string& listen = "127.0.0.1:0",
                         const std::vector<std::string>& more_arguments = {});

  const std::string& address() const { return address_; }
  // The port of --http, or -1 without that option.
  int http_port() const { return http_port_; }
  pid_t pid() const { return process_.pid(); }
  bool ended() { return process_.ended(); }  // whether it has ended by itself
  // Returns the daemon's log so far.
  std::string log() const { return process_.log(); }
  // Stops the process with SIGSTOP: connections stay open, but nothing is read or answered.
  void Pause() const;
  // Sends SIGKILL and waits for the end. The destructor calls it, too.
  void Kill() { process_.Kill(); }
  // Sends SIGTERM; returns the exit code, or -1 if a signal ended it. Prints the daemon's log
  // unless the code is 0.
  int Terminate();

 private:
  ChildProcess process_;
  std::string address_;
  int http_port_ = -1;
};

}  // namespace sweepstake::test_support
