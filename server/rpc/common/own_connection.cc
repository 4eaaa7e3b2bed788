#include "server/rpc/common/own_connection.h"

#include <grpcpp/create_channel_posix.h>
#include <grpcpp/server_posix.h>
#include <grpcpp/support/channel_arguments.h>
#include <sys/socket.h>

#include <cerrno>

#include "absl/status/status.h"

namespace sweepstake::rpc {

absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectWithin(grpc::Server& server) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0)
    return absl::ErrnoToStatus(errno, "cannot create the sockets for the daemon's internal calls");
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  grpc::AddInsecureChannelFromFd(&server, ends[0]);
  return grpc::CreateCustomInsecureChannelFromFd("sweepstaked", ends[1], arguments);
}

}  // namespace sweepstake::rpc
