// Tests the limit of open connections per address.
#include "server/rpc/open_connections.h"

#include <gtest/gtest.h>

#include <string>

#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {
namespace {

constexpr int kMost = 2 + OpenConnections::kSpare;

class OpenConnectionsTest : public ::testing::Test {
 protected:
  OpenConnectionsTest() { options_.max_streams_per_address = 2; }
  // Opens `count` connections, and returns how many are accepted.
  int Open(const std::string& address, int count, bool is_own = false) {
    int admitted = 0;
    for (int i = 0; i < count; ++i) {
      const auto added = connections_.Add(address + ":" + std::to_string(++port_), is_own);
      admitted += added.ok() ? 1 : 0;
      if (added.ok()) continue;
      EXPECT_EQ(ReasonOfRefusal(added.status()), v1::ERROR_REASON_TOO_MANY_STREAMS);
    }
    return admitted;
  }

  RpcOptions options_;
  OpenConnections connections_{options_};
  int port_ = 0;
};

TEST_F(OpenConnectionsTest, EachAddressHasItsOwnLimit) {
  EXPECT_EQ(Open("ipv4:192.0.2.7", 2 * kMost), kMost);
  EXPECT_EQ(Open("ipv4:192.0.2.8", 10), 10);
  EXPECT_EQ(Open("ipv6:%5B2001:db8::1%5D", kMost), kMost);
  EXPECT_EQ(Open("ipv6:%5B2001:db8::2%5D", 1), 0) << "connections are counted per network";
}

TEST_F(OpenConnectionsTest, TheOwnMachineHasNoLimit) {
  EXPECT_EQ(Open("ipv4:127.0.0.1", 2 * kMost), 2 * kMost);
  EXPECT_EQ(Open("ipv4:192.0.2.1", 2 * kMost, /*is_own=*/true), 2 * kMost);
  connections_.Remove("");
}

TEST_F(OpenConnectionsTest, ClosedConnectionsMakeRoom) {
  ASSERT_EQ(Open("ipv4:192.0.2.7", kMost + 1), kMost);
  const std::string address = "ipv4:192.0.2.7";
  for (int i = 0; i < 10; ++i) connections_.Remove(address);
  EXPECT_EQ(Open(address, 20), 10);
}

}  // namespace
}  // namespace sweepstake::rpc
