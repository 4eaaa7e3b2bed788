#include "tests/server/host/notify_socket.h"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>

namespace sweepstake::test_support {

NotifySocket::NotifySocket(const std::filesystem::path& folder,
                           std::chrono::microseconds watchdog_limit)
    : socket_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const std::string path = folder / "notify";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  if (bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    std::perror("bind");
    std::abort();
  }
  const timeval patience{.tv_sec = 60, .tv_usec = 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setenv("NOTIFY_SOCKET", path.c_str(), /*overwrite=*/1);
  setenv("WATCHDOG_USEC", std::to_string(watchdog_limit.count()).c_str(), /*overwrite=*/1);
}

NotifySocket::~NotifySocket() {
  unsetenv("NOTIFY_SOCKET");
  unsetenv("WATCHDOG_USEC");
  close(socket_);
}

std::string NotifySocket::ReceiveNow() { return Receive(MSG_DONTWAIT); }

std::string NotifySocket::Receive(int flags) {
  std::array<char, 4096> message;
  const ssize_t size = recv(socket_, message.data(), message.size(), flags);
  return {message.data(), size > 0 ? static_cast<size_t>(size) : 0};
}

}  // namespace sweepstake::test_support
