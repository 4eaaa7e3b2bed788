// Receives systemd notifications like a service manager. This process and its children find the
// socket through environment variables.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

namespace sweepstake::test_support {

// Sets NOTIFY_SOCKET and WATCHDOG_USEC while it lives. REQUIRES: no other thread reads them yet.
class NotifySocket {
 public:
  NotifySocket(const std::filesystem::path& folder, std::chrono::microseconds watchdog_limit);
  ~NotifySocket();
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  // Returns the next message, or "" after a minute without one.
  std::string Receive() { return Receive(/*flags=*/0); }
  // Returns "" at once if there is no message.
  std::string ReceiveNow();

 private:
  std::string Receive(int flags);

  int socket_;
};

}  // namespace sweepstake::test_support
