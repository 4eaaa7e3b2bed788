// A client's connection with a guard in front of gRPC (net/http2_guard.h).
//
// gRPC gets one end of a pair of local sockets. This object copies the bytes between the other end
// and the client's socket, through the guard. It reads from one side only after the other side has
// taken everything, so a slow side slows the other one and no queue grows. While nothing arrives it
// has no buffers.
//
// All functions run on the thread of the io_context. The object keeps itself alive until both
// sockets are closed.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "server/net/http2_guard.h"
#include "server/rpc/common/options.h"
#include "server/tls/tls_session.h"

namespace sweepstake::rpc {

class GuardedConnection : public std::enable_shared_from_this<GuardedConnection> {
 public:
  // Makes the pair of sockets. The client uses TLS unless `tls` is null. Our end has the name
  // `name` in the abstract namespace, so that gRPC reports it as the peer of each call. Error:
  // RESOURCE_EXHAUSTED (no free descriptors).
  static absl::StatusOr<std::shared_ptr<GuardedConnection>> Make(
      boost::asio::ip::tcp::socket client, const std::string& name,
      const std::shared_ptr<tls::TlsContext>& tls, std::shared_ptr<net::Http2Use> use,
      net::Http2Guard::OnRefusal on_refusal);

  // Returns the descriptor for gRPC, which closes it. Call it once, before Start.
  int TakeServerEnd();
  // Begins to copy. `on_end` is called when the connection has ended.
  void Start(std::function<int64_t()> now_ns, std::function<void()> on_end);
  // Ends the calls whose first message is late. Call it about once per second.
  void EndLateCalls();
  void Close();

 private:
  using Client = boost::asio::ip::tcp::socket;
  using Server = boost::asio::local::stream_protocol::socket;

  GuardedConnection(Client client, Server server, int server_end,
                    std::unique_ptr<tls::TlsSession> tls, std::shared_ptr<net::Http2Use> use,
                    net::Http2Guard::OnRefusal on_refusal)
      : client_(std::move(client)),
        server_(std::move(server)),
        server_end_(server_end),
        tls_(std::move(tls)),
        guard_({.max_message_bytes = kMaxMessageBytes}, std::move(use), std::move(on_refusal)) {}

  void AwaitClient();
  void AwaitServer();
  void OnClientReadable();
  // Adds plain bytes to to_client_. Returns false if TLS has failed.
  bool SendToClient(std::string_view plain);
  // Adds the answers to refused calls to to_client_.
  bool SendAnswers();
  void OnServerReadable();
  // Writes what is pending. Then reads from the other side again, unless it does so already.
  void FlushToServer();
  void FlushToClient();

  Client client_;
  Server server_;
  int server_end_;
  const std::unique_ptr<tls::TlsSession> tls_;  // null: plain text
  net::Http2Guard guard_;
  std::function<int64_t()> now_ns_;
  std::function<void()> on_end_;
  std::string to_server_;
  std::string to_client_;
  bool waits_for_client_ = false;  // for bytes of the client
  bool waits_for_server_ = false;  // for bytes of gRPC
  bool writes_to_server_ = false;  // waits until gRPC takes bytes
  bool writes_to_client_ = false;  // waits until the client takes bytes
  bool client_ended_ = false;      // it sends nothing more
  bool server_ended_ = false;
};

}  // namespace sweepstake::rpc
