#include "server/rpc/guarded_connection.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <utility>

namespace sweepstake::rpc {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;

// Used by one read at a time on the thread of the io_context.
std::array<char, 64 * 1024>& ReadBuffer() {
  thread_local std::array<char, 64 * 1024> buffer;
  return buffer;
}

// Beyond it, the client must read before it is read from: TLS answers some of its messages.
constexpr size_t kMaxPendingBytes = 64 * 1024;

bool IsWait(const error_code& error) {
  return error == boost::asio::error::would_block || error == boost::asio::error::try_again;
}

// Binds the socket to a name that only this process may use. Returns false if that fails.
bool BindName(int descriptor, const std::string& name) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // The first byte stays 0: the name is not a file.
  const size_t length = std::min(name.size(), sizeof(address.sun_path) - 1);
  std::memcpy(address.sun_path + 1, name.data(), length);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length);
  return bind(descriptor, reinterpret_cast<const sockaddr*>(&address), size) == 0;
}

// Reads what has arrived. Returns the bytes; sets `ended` at the end of the stream or on an error.
template <typename Socket>
std::string_view ReadFrom(Socket& socket, bool& ended) {
  error_code error;
  const size_t count = socket.read_some(boost::asio::buffer(ReadBuffer()), error);
  ended = error && !IsWait(error);
  return {ReadBuffer().data(), count};
}

// Writes as much of `bytes` as the socket takes, and removes it. Returns false on an error.
template <typename Socket>
bool WriteTo(Socket& socket, std::string& bytes) {
  error_code error;
  size_t written = 0;
  while (written < bytes.size() && !error) {
    written += socket.write_some(
        boost::asio::buffer(bytes.data() + written, bytes.size() - written), error);
  }
  bytes.erase(0, written);
  if (bytes.empty()) bytes.shrink_to_fit();
  return !error || IsWait(error);
}

}  // namespace

absl::StatusOr<std::shared_ptr<GuardedConnection>> GuardedConnection::Make(
    Client client, const std::string& name, const std::shared_ptr<tls::TlsContext>& tls,
    std::shared_ptr<net::Http2Use> use, net::Http2Guard::OnRefusal on_refusal) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0)
    return absl::ResourceExhaustedError(std::string("no local sockets: ") + std::strerror(errno));
  Server server(client.get_executor(), stream_protocol(), ends[0]);
  if (!BindName(ends[0], name)) {
    close(ends[1]);
    return absl::InternalError(std::string("cannot name a local socket: ") + std::strerror(errno));
  }
  error_code ignored;
  server.non_blocking(true, ignored);
  client.non_blocking(true, ignored);
  return std::shared_ptr<GuardedConnection>(
      new GuardedConnection(std::move(client), std::move(server), ends[1],
                            tls ? std::make_unique<tls::TlsSession>(tls) : nullptr, std::move(use),
                            std::move(on_refusal)));
}

int GuardedConnection::TakeServerEnd() { return std::exchange(server_end_, -1); }

void GuardedConnection::Start(std::function<int64_t()> now_ns, std::function<void()> on_end) {
  now_ns_ = std::move(now_ns);
  on_end_ = std::move(on_end);
  AwaitClient();
  AwaitServer();
}

void GuardedConnection::AwaitClient() {
  const bool is_full = !to_server_.empty() || to_client_.size() > kMaxPendingBytes;
  if (waits_for_client_ || client_ended_ || is_full) return;
  waits_for_client_ = true;
  client_.async_wait(Client::wait_read, [self = shared_from_this()](const error_code& error) {
    self->waits_for_client_ = false;
    if (!error) self->OnClientReadable();
  });
}

void GuardedConnection::OnClientReadable() {
  std::string_view bytes = ReadFrom(client_, client_ended_);
  std::string plain;
  if (tls_) {
    if (!tls_->FromClient(bytes, plain, to_client_)) client_ended_ = true;
    bytes = plain;
  }
  if (!guard_.FromClient(bytes, now_ns_(), to_server_)) {
    if (SendAnswers()) WriteTo(client_, to_client_);
    return Close();
  }
  if (!SendAnswers()) return Close();
  FlushToServer();
  FlushToClient();
}

bool GuardedConnection::SendToClient(std::string_view plain) {
  if (tls_) return tls_->ToClient(plain, to_client_);
  to_client_ += plain;
  return true;
}

bool GuardedConnection::SendAnswers() {
  std::string answers;
  guard_.TakeAnswers(answers);
  return answers.empty() || SendToClient(answers);
}

void GuardedConnection::FlushToServer() {
  if (!WriteTo(server_, to_server_)) {
    // gRPC has closed its end. What it sent before is still read.
    to_server_.clear();
    client_ended_ = true;
    return;
  }
  if (to_server_.empty()) {
    // gRPC reads the end of the stream, ends its calls, and closes its socket.
    error_code ignored;
    if (client_ended_) server_.shutdown(Server::shutdown_send, ignored);
    return AwaitClient();
  }
  if (std::exchange(writes_to_server_, true)) return;
  server_.async_wait(Server::wait_write, [self = shared_from_this()](const error_code& error) {
    self->writes_to_server_ = false;
    if (!error) self->FlushToServer();
  });
}

void GuardedConnection::AwaitServer() {
  if (waits_for_server_ || !to_client_.empty()) return;
  waits_for_server_ = true;
  server_.async_wait(Server::wait_read, [self = shared_from_this()](const error_code& error) {
    self->waits_for_server_ = false;
    if (!error) self->OnServerReadable();
  });
}

void GuardedConnection::OnServerReadable() {
  std::string plain;
  guard_.FromServer(ReadFrom(server_, server_ended_), plain);
  if (!SendToClient(plain)) return Close();
  FlushToClient();
}

void GuardedConnection::FlushToClient() {
  if (!WriteTo(client_, to_client_)) return Close();
  if (to_client_.empty() && (server_ended_ || guard_.is_done())) return Close();
  AwaitClient();
  if (to_client_.empty()) return AwaitServer();
  if (std::exchange(writes_to_client_, true)) return;
  client_.async_wait(Client::wait_write, [self = shared_from_this()](const error_code& error) {
    self->writes_to_client_ = false;
    if (!error) self->FlushToClient();
  });
}

void GuardedConnection::EndLateCalls() {
  if (guard_.waiting_call_count() == 0 || !client_.is_open()) return;
  guard_.EndLateCalls(now_ns_(), to_server_);
  if (!SendAnswers()) return Close();
  FlushToServer();
  FlushToClient();
}

void GuardedConnection::Close() {
  if (!client_.is_open()) return;
  error_code ignored;
  client_.close(ignored);
  server_.close(ignored);
  if (server_end_ >= 0) close(std::exchange(server_end_, -1));
  if (on_end_) on_end_();
}

}  // namespace sweepstake::rpc
