// Tests the end of a daemon: the messages to clients, and the times at which they reconnect.
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using Response = v1::StreamTelemetryResponse;

class DrainTest : public RpcTest {
 protected:
  DrainTest() {
    options_.reconnect_delay_ms = 500;
    options_.reconnects_per_s = 2;
  }
};

TEST_F(DrainTest, DrainingRequestsClientsToReconnectAndEnds) {
  TelemetryClient silent(channel_);
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  server_->Drain(std::chrono::minutes(10));
  client.Await(&Response::has_reconnect);
  EXPECT_EQ(ReasonOf(client.Finish()), v1::ERROR_REASON_DRAINING);
  EXPECT_FALSE(silent.Finish().ok());
}

TEST_F(DrainTest, ReconnectDelaysOfClientsAreStaggered) {
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  for (int i = 0; i < 4; ++i) {
    clients.push_back(std::make_unique<TelemetryClient>(channel_));
    clients.back()->Open(HelloMessage());
  }
  clients.push_back(std::make_unique<TelemetryClient>(channel_));  // a client without a session
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_stream_count == 5; }));
  server_->Drain(std::chrono::minutes(10));
  std::multiset<uint32_t> delays_ms;
  for (const auto& client : clients) {
    const Response last = client->Await(&Response::has_reconnect);
    delays_ms.insert(last.reconnect().delay_ms());
  }
  EXPECT_THAT(delays_ms, ::testing::ElementsAre(500, 1'000, 1'500, 2'000, 2'500));
}

TEST(ReconnectDelayTest, TenThousandClientsReconnectOverTwentySecondsAtFiveHundredPerSecond) {
  std::map<uint32_t, int> clients_by_second;
  for (uint64_t rank = 0; rank < 10'000; ++rank) {
    const uint32_t delay_ms = ReconnectDelayMs(RpcOptions{}, rank);
    ASSERT_GE(delay_ms, 500u);
    ++clients_by_second[(delay_ms - 500) / 1'000];
  }
  EXPECT_EQ(clients_by_second.size(), 20u);
  for (const auto& [second, count] : clients_by_second) EXPECT_EQ(count, 500) << second;
}

}  // namespace
}  // namespace sweepstake::rpc
