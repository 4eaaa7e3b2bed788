#include "engine_client/cli/daemon/daemon_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sweepstake::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(OpenChannel, ChecksTheFormOfTheAddress) {
  EXPECT_TRUE(OpenChannel({"127.0.0.1:7433"}).ok());
  EXPECT_TRUE(OpenChannel({"[::1]:7433"}).ok());
  for (const char* address : {"", "nowhere", "host:", ":7433", "host:0", "host:65536", "a b:1"}) {
    const auto channel = OpenChannel({address});
    ASSERT_FALSE(channel.ok()) << address;
    EXPECT_EQ(channel.status().code(), StatusCode::kInvalidArgument) << address;
  }
}

TEST(ToStatus, SuggestsToStartADaemonIfNoneAnswers) {
  for (const grpc::StatusCode code :
       {grpc::StatusCode::UNAVAILABLE, grpc::StatusCode::DEADLINE_EXCEEDED}) {
    const Status status = ToStatus({code, "connection refused"}, {"host:1"});
    EXPECT_EQ(status.code(), StatusCode::kUnavailable);
    EXPECT_THAT(status.message(),
                AllOf(HasSubstr("no daemon answered at host:1 (connection refused)"),
                      HasSubstr("sweepstaked --listen HOST:PORT")));
  }
}

TEST(ToStatus, DistinguishesACallThatBrokeOff) {
  const grpc::Status lost{grpc::StatusCode::UNAVAILABLE, "Socket closed"};
  const Status read = ToStatus(lost, {"host:1"}, /*was_connected=*/true);
  EXPECT_EQ(read.code(), StatusCode::kUnavailable);
  EXPECT_EQ(read.message(), "the call to host:1 broke off (Socket closed)");
  EXPECT_EQ(ToStatus(lost, {"host:1"}, true, "sweepstake priors list").message(),
            read.message() +
                "; the change may have been made, and `sweepstake priors list` shows whether it "
                "was");
}

TEST(ToStatus, GivesAdviceIfTheConnectionIsRejected) {
  const std::string hung_up = "failed to connect to all addresses; last error: Socket closed";
  const DaemonOptions plain{.address = "host:1"};
  const DaemonOptions with_tls{.address = "host:1", .tls = TlsOptions()};
  const struct {
    const DaemonOptions& daemon;
    std::string reason;
    const char* said;
  } cases[] = {{with_tls, "SSL routines::certificate verify failed", "--tls-ca"},
               {with_tls, "Peer name host is not in peer certificate", "--tls-server-name"},
               {with_tls, "SSL routines::wrong version number", "connect without TLS"},
               {with_tls, hung_up, "--tls-cert and --tls-key"},
               {plain, hung_up, "--tls-ca"}};
  for (const auto& [daemon, reason, said] : cases) {
    const Status status = ToStatus({grpc::StatusCode::UNAVAILABLE, reason}, daemon);
    EXPECT_EQ(status.code(), StatusCode::kUnavailable);
    EXPECT_THAT(status.message(),
                AllOf(HasSubstr("no connection to host:1 (" + reason + "); "), HasSubstr(said)));
  }
}

TEST(ToStatus, KeepsTheMessageOfTheDaemon) {
  const struct {
    grpc::StatusCode theirs;
    StatusCode ours;
  } cases[] = {{grpc::StatusCode::NOT_FOUND, StatusCode::kNotFound},
               {grpc::StatusCode::RESOURCE_EXHAUSTED, StatusCode::kResourceExhausted},
               {grpc::StatusCode::FAILED_PRECONDITION, StatusCode::kFailedPrecondition},
               {grpc::StatusCode::INVALID_ARGUMENT, StatusCode::kInvalidArgument},
               {grpc::StatusCode::INTERNAL, StatusCode::kInternal},
               {grpc::StatusCode::UNIMPLEMENTED, StatusCode::kInternal}};
  for (const auto& [theirs, ours] : cases) {
    const Status status = ToStatus({theirs, "the reason"}, {"host:1"});
    EXPECT_EQ(status.code(), ours) << theirs;
    EXPECT_EQ(status.message(), "the reason");
  }
  EXPECT_TRUE(ToStatus(grpc::Status::OK, {"host:1"}).ok());
}

}  // namespace
}  // namespace sweepstake::cli
