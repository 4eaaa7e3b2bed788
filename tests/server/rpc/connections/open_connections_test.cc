// Tests the limit of open connections per address.
#include "server/rpc/open_connections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>
#include <unistd.h>

#include <future>
#include <map>
#include <memory>
#include <sstream>
#include <string>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/refusal_log.h"
#include "server/rpc/connection_listener.h"
#include "tests/server/sessions/manual_clock.h"
#include "tests/support/http_exchange.h"

namespace sweepstake::rpc {
namespace {

constexpr int kMost = 2 + OpenConnections::kSpare;

class OpenConnectionsTest : public ::testing::Test {
 protected:
  OpenConnectionsTest() { options_.max_streams_per_address = 2; }
  // Opens connections at descriptors from `first` on, and returns how many are accepted.
  int Open(const std::string& address, int first, int count) {
    int admitted = 0;
    for (int descriptor = first; descriptor < first + count; ++descriptor) {
      names_[descriptor] = address + ":" + std::to_string(descriptor);
      const absl::Status status = connections_.Add(descriptor);
      admitted += status.ok() ? 1 : 0;
      if (status.ok()) continue;
      EXPECT_EQ(ReasonOfRefusal(status), v1::ERROR_REASON_TOO_MANY_STREAMS);
      names_.erase(descriptor);
    }
    return admitted;
  }

  RpcOptions options_;
  sessions::ManualClock clock_;
  std::map<int, std::string> names_;     // peers of the open descriptors
  std::string own_ = "ipv4:192.0.2.1:";  // prefix of peers on this machine
  OpenConnections connections_{
      options_, clock_,
      [this](int descriptor) {
        const auto found = names_.find(descriptor);
        return found == names_.end() ? "" : found->second;
      },
      [this](int descriptor) { return names_.at(descriptor).starts_with(own_); }};
};

TEST_F(OpenConnectionsTest, EachAddressHasItsOwnLimit) {
  EXPECT_EQ(Open("ipv4:192.0.2.7", 100, 2 * kMost), kMost);
  EXPECT_EQ(Open("ipv4:192.0.2.8", 10'000, 10), 10);
  EXPECT_EQ(Open("ipv6:%5B2001:db8::1%5D", 20'000, kMost), kMost);
  EXPECT_EQ(Open("ipv6:%5B2001:db8::2%5D", 30'000, 1), 0) << "connections are counted per network";
}

TEST_F(OpenConnectionsTest, TheOwnMachineHasNoLimit) {
  EXPECT_EQ(Open("ipv4:127.0.0.1", 100, 2 * kMost), 2 * kMost);
  EXPECT_EQ(Open("ipv4:192.0.2.1", 10'000, 2 * kMost), 2 * kMost)
      << "at another address of this machine";
}

TEST_F(OpenConnectionsTest, ClosedConnectionsMakeRoomWithinASecond) {
  ASSERT_EQ(Open("ipv4:192.0.2.7", 100, kMost + 1), kMost);
  for (int descriptor = 100; descriptor < 110; ++descriptor) names_.erase(descriptor);
  EXPECT_EQ(Open("ipv4:192.0.2.7", 10'000, 1), 0) << "the descriptors were checked a moment ago";
  clock_.Advance(OpenConnections::kLookIntervalNs);
  EXPECT_EQ(Open("ipv4:192.0.2.7", 10'000, 20), 10);
}

TEST_F(OpenConnectionsTest, AReusedDescriptorIsNotCountedForItsFormerConnection) {
  ASSERT_EQ(Open("ipv4:192.0.2.7", 100, kMost), kMost);
  EXPECT_EQ(Open("ipv4:192.0.2.8", 100, 1), 1);
  EXPECT_EQ(Open("ipv4:192.0.2.7", 10'000, 2), 1);
}

// Keeps the descriptors that it receives.
class KeptConnections final : public grpc::experimental::ExternalConnectionAcceptor {
 public:
  ~KeptConnections() override {
    for (const int descriptor : descriptors_) close(descriptor);
  }
  void HandleNewConnection(NewConnectionParameters* connection) override {
    descriptors_.push_back(connection->fd);
    if (descriptors_.size() == 1) first_.set_value();
  }
  std::future<void> first() { return first_.get_future(); }

 private:
  std::vector<int> descriptors_;
  std::promise<void> first_;
};

TEST(ConnectionListenerTest, ClosesAndLogsOneConnectionTooManyOfAnAddress) {
  RpcOptions options;
  options.max_streams_per_address = 1;
  sessions::ManualClock clock;
  OpenConnections connections(
      options, clock, [](int descriptor) { return "ipv4:192.0.2.7:" + std::to_string(descriptor); },
      [](int) { return false; });
  for (uint32_t i = 0; i < OpenConnections::kSpare; ++i)
    ASSERT_TRUE(connections.Add(static_cast<int>(1'000'000 + i)).ok());
  std::ostringstream text;
  spdlog::logger log("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text));
  RefusalLog refusals(clock, log);
  std::atomic<uint64_t> ended = 0;
  auto kept = std::make_unique<KeptConnections>();
  std::future<void> first = kept->first();
  auto listener = std::make_unique<ConnectionListener>(std::move(kept),
                                                       std::make_shared<ConnectionCalls>(1, ended),
                                                       std::move(connections), refusals);
  ASSERT_TRUE(listener->Listen("127.0.0.1:0").ok());
  const test_support::HttpSocket last(listener->port());
  first.wait();
  test_support::HttpSocket beyond(listener->port());
  EXPECT_EQ(beyond.ReadAll(), "") << "the connection ends";
  listener.reset();  // also ends the thread that writes the log
  EXPECT_THAT(text.str(), ::testing::HasSubstr("this address has 1001 open connections"));
}

}  // namespace
}  // namespace sweepstake::rpc
