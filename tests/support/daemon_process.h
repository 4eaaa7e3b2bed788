// A real `sweepstaked` as a child process on an ephemeral loopback port, for end-to-end tests.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace sweepstake::test_support {

class DaemonProcess {
 public:
  // Starts the daemon, which allows any time scale, and returns when it listens. `listen` may name
  // a port to come back on after a kill. Aborts the test program with the daemon's log when it does
  // not start.
  explicit DaemonProcess(const std::filesystem::path& data,
                         const std::string& listen = "127.0.0.1:0",
                         const std::vector<std::string>& more_arguments = {});
  ~DaemonProcess();  // kill -9 when still running
  DaemonProcess(const DaemonProcess&) = delete;
  DaemonProcess& operator=(const DaemonProcess&) = delete;

  const std::string& address() const { return address_; }
  // The port of --http, or -1 if the daemon was started without.
  int http_port() const { return http_port_; }
  pid_t pid() const { return pid_; }
  // What the daemon has logged so far.
  std::string log() const;
  // Stops running without ending: connections stay open, nothing is read or answered any more.
  void Pause();
  // kill -9, and waits for the end.
  void Kill();
  // SIGTERM; the exit code, or -1 when a signal ended it. Prints the daemon's log unless it is 0.
  int Terminate();

 private:
  std::filesystem::path log_;
  pid_t pid_ = -1;
  std::string address_;
  int http_port_ = -1;
};

}  // namespace sweepstake::test_support
