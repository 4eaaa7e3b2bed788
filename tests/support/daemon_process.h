// A real `sweepstaked` as a child process on an ephemeral loopback port, for end-to-end tests.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/child_process.h"

namespace sweepstake::test_support {

class DaemonProcess {
 public:
  // Starts the daemon, which allows any time scale, and returns when it listens. `listen` may name
  // a port to come back on after a kill. Aborts the test program with the daemon's log when it does
  // not start.
  explicit DaemonProcess(const std::filesystem::path& data,
                         const std::string& listen = "127.0.0.1:0",
                         const std::vector<std::string>& more_arguments = {});

  const std::string& address() const { return address_; }
  // The port of --http, or -1 if the daemon was started without.
  int http_port() const { return http_port_; }
  pid_t pid() const { return process_.pid(); }
  bool ended() { return process_.ended(); }  // by itself
  // What the daemon has logged so far.
  std::string log() const { return process_.log(); }
  // Stops running without ending: connections stay open, nothing is read or answered any more.
  void Pause() const;
  // kill -9, and waits for the end. It happens by itself when the object ends.
  void Kill() { process_.Kill(); }
  // SIGTERM; the exit code, or -1 when a signal ended it. Prints the daemon's log unless it is 0.
  int Terminate();

 private:
  ChildProcess process_;
  std::string address_;
  int http_port_ = -1;
};

}  // namespace sweepstake::test_support
