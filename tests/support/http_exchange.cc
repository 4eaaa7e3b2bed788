#include "tests/support/http_exchange.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace sweepstake::test_support {
namespace {

[[noreturn]] void Die(const char* what) {
  std::perror(what);
  std::abort();
}

}  // namespace

HttpSocket::HttpSocket(int port, int receive_bytes)
    : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  if (socket_ < 0) Die("socket");
  if (receive_bytes > 0)
    setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
  const timeval patience{.tv_sec = 60, .tv_usec = 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) Die("connect");
}

HttpSocket::~HttpSocket() {
  if (socket_ >= 0) close(socket_);
}

// Ignores errors: the server may have closed the connection already, and its answer has the reason.
void HttpSocket::Send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return;
    bytes.remove_prefix(static_cast<size_t>(sent));
  }
}

void HttpSocket::HalfClose() { shutdown(socket_, SHUT_WR); }

void HttpSocket::Reset() {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  close(std::exchange(socket_, -1));
}

bool HttpSocket::ReadMore() {
  std::array<char, 4096> bytes;
  const ssize_t count = recv(socket_, bytes.data(), bytes.size(), 0);
  if (count < 0 && errno == EAGAIN) Die("the server sends nothing");
  if (count > 0) unread_.append(bytes.data(), static_cast<size_t>(count));
  return count > 0;
}

std::string HttpSocket::ReadAll() {
  while (ReadMore()) {
  }
  return std::exchange(unread_, {});
}

std::string HttpSocket::ReadAnswer() {
  static constexpr std::string_view kLength = "Content-Length: ";
  size_t end = 0;
  while ((end = unread_.find("\r\n\r\n")) == std::string::npos) {
    if (!ReadMore()) return {};
  }
  const size_t length = unread_.find(kLength);
  if (length > end) return {};
  const size_t size = end + 4 + std::stoul(unread_.substr(length + kLength.size()));
  while (unread_.size() < size && ReadMore()) {
  }
  std::string answer = unread_.substr(0, size);
  unread_.erase(0, size);
  return answer;
}

std::string HttpSocket::ReadUntil(std::string_view text) {
  size_t found = 0;
  while ((found = unread_.find(text)) == std::string::npos) {
    if (!ReadMore()) return std::exchange(unread_, {});
  }
  std::string read = unread_.substr(0, found + text.size());
  unread_.erase(0, read.size());
  return read;
}

bool HttpSocket::WasReset() {
  std::array<char, 4096> bytes;
  ssize_t count = 0;
  while ((count = recv(socket_, bytes.data(), bytes.size(), 0)) > 0) {
  }
  if (count < 0 && errno == EAGAIN) Die("the server does not end the connection");
  return count < 0 && errno == ECONNRESET;
}

HttpAnswer Exchange(int port, std::string_view request) {
  HttpSocket socket(port);
  socket.Send(request);
  const std::string all = socket.ReadAll();
  const size_t end = all.find("\r\n\r\n");
  if (!all.starts_with("HTTP/1.") || end == std::string::npos) return {};
  return {std::stoi(all.substr(9, 3)), all.substr(0, end + 2), all.substr(end + 4)};
}

std::string Dechunked(std::string body) {
  std::string text;
  for (size_t end = 0; (end = body.find("\r\n")) != std::string::npos;) {
    const size_t size = std::stoul(body.substr(0, end), nullptr, 16);
    text += body.substr(end + 2, size);
    body.erase(0, end + 2 + size + 2);
  }
  return text;
}

HttpAnswer Get(int port, const std::string& target) {
  return Exchange(port,
                  "GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
}

}  // namespace sweepstake::test_support
