// Tests that attacks of unknown clients on a daemon's listeners do not disturb games.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tests/end_to_end/scripted_game.h"
#include "tests/server/rpc/http2_frames.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/daemon_process.h"
#include "tests/support/http_exchange.h"
#include "tests/support/sanitizers/active.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

class AttackTest : public ::testing::Test {
 protected:
  size_t DescriptorCount() const {
    const std::filesystem::directory_iterator files("/proc/" + std::to_string(daemon_.pid()) +
                                                    "/fd");
    return static_cast<size_t>(std::distance(begin(files), end(files)));
  }
  // Returns the largest resident size so far.
  size_t ResidentKib() const {
    std::ifstream status("/proc/" + std::to_string(daemon_.pid()) + "/status");
    std::string word;
    while (status >> word && word != "VmHWM:") {
    }
    size_t kib = 0;
    status >> kib;
    return kib;
  }
  int port() const { return std::stoi(daemon_.address().substr(daemon_.address().rfind(':') + 1)); }
  // Opens `count` connections that send nothing.
  std::vector<std::unique_ptr<HttpSocket>> Connect(int port, size_t count) {
    std::vector<std::unique_ptr<HttpSocket>> sockets;
    while (sockets.size() < count) sockets.push_back(std::make_unique<HttpSocket>(port));
    return sockets;
  }

  TemporaryDirectory data_;
  DaemonProcess daemon_{data_.path(), "127.0.0.1:0", {"--http", "127.0.0.1:0"}};
};

bool Learns(const SessionStats& stats) { return stats.acknowledged_sequence > 0; }

TEST_F(AttackTest, TextThatIsNotUtf8OnlyAddsItsRefusalToTheLog) {
  const auto channel = grpc::CreateChannel(daemon_.address(), grpc::InsecureChannelCredentials());
  v1::Hello hello = rpc::OneArmHello();
  hello.set_scene("\xff");
  rpc::TelemetryClient client(channel);
  client.Send(rpc::Request(hello));
  EXPECT_EQ(ReasonOf(client.Finish()), v1::ERROR_REASON_MALFORMED_MESSAGE);
  ASSERT_TRUE(rpc::Eventually(
      [&] { return daemon_.log().find("MALFORMED_MESSAGE") != std::string::npos; }));
  EXPECT_THAT(daemon_.log(), ::testing::Not(::testing::HasSubstr("UTF-8 data")));
}

TEST_F(AttackTest, TwoThousandHalfOpenConnectionsBlockNoGame) {
  constexpr size_t kCount = 2'000;
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_max < kCount + 500)
    GTEST_SKIP() << "the limit of descriptors is too low: " << limit.rlim_max;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  const auto strangers = Connect(port(), kCount);
  ScriptedGame game(daemon_.address(), FastOptions());
  EXPECT_TRUE(game.RunUntil(Learns));
  EXPECT_EQ(game.stats().connection_count, 1u);
}

TEST_F(AttackTest, GamesConnectOnceDescriptorsAreFreeAgain) {
#if SWEEPSTAKE_ASAN
  GTEST_SKIP() << "UBSan needs a pipe to check an object's type, and ends the daemon without one";
#endif
  constexpr size_t kLeft = 20;
  constexpr size_t kPerConnection = 3;  // a socket and a pair of local sockets
  const size_t before = DescriptorCount();
  rlimit limit{};
  prlimit(daemon_.pid(), RLIMIT_NOFILE, nullptr, &limit);
  limit.rlim_cur = before + kLeft;
  ASSERT_EQ(prlimit(daemon_.pid(), RLIMIT_NOFILE, &limit, nullptr), 0);
  auto strangers = Connect(port(), 2 * kLeft);
  ASSERT_TRUE(rpc::Eventually([&] { return DescriptorCount() + kPerConnection > limit.rlim_cur; }));
  // Until the other connections are closed, the game's waits in the system's queue or is closed.
  ScriptedGame game(daemon_.address(), FastOptions());
  strangers.clear();
  game.RunUntil([&](const SessionStats& stats) { return Learns(stats) || daemon_.ended(); },
                UINT64_MAX);
  ASSERT_FALSE(daemon_.ended()) << daemon_.log();
  EXPECT_EQ(Get(daemon_.http_port(), "/livez").status, 200);
}

// 5,000 calls, of which 50 announce 100 MB and 50 a compressed message. The others send nothing.
TEST_F(AttackTest, CallsWithoutAReadableMessageDisturbNoGame) {
  ScriptedGame game(daemon_.address(), FastOptions());
  ASSERT_TRUE(game.RunUntil(Learns));
  [[maybe_unused]] const size_t before_kib = ResidentKib();
  std::string calls = Http2Preface();
  for (uint32_t stream = 1; stream < 200; stream += 2)
    calls += Http2Call(stream, "/sweepstake.v1.TelemetryService/StreamTelemetry");
  calls += Http2Frame(Http2Type::kData, 0, 1, std::string("\0\x06\0\0\0", 5));
  calls += Http2Frame(Http2Type::kData, 0, 3, std::string("\1\0\0\0\1", 5));
  const auto strangers = Connect(port(), 50);
  for (const auto& stranger : strangers) stranger->Send(calls);

  const uint64_t acknowledged = game.stats().acknowledged_sequence;
  EXPECT_TRUE(game.RunUntil(
      [&](const SessionStats& stats) { return stats.acknowledged_sequence > acknowledged + 20; }));
  EXPECT_EQ(game.stats().connection_count, 1u);
  EXPECT_THAT(daemon_.log(), ::testing::HasSubstr("announced a message of more than"));
  EXPECT_TRUE(rpc::Eventually([&] {
    const std::string metrics = Get(daemon_.http_port(), "/metrics").body;
    return metrics.find("sweepstake_unread_calls_total 0") == std::string::npos;
  }));
#if !SWEEPSTAKE_ASAN && !SWEEPSTAKE_TSAN
  EXPECT_LT(ResidentKib(), before_kib + 32 * 1024);
#endif
}

// Without the daemon's limit each of these calls would take about 20 KiB.
TEST_F(AttackTest, StreamsResetAtOnceStayWithinTheMemoryQuota) {
#if SWEEPSTAKE_ASAN || SWEEPSTAKE_TSAN
  GTEST_SKIP() << "a sanitizer does not release freed memory";
#endif
  constexpr uint32_t kCalls = 20'000;
  constexpr size_t kQuotaKib = 64 * 1024;
  std::string calls = Http2Preface();
  for (uint32_t stream = 1; stream < 2 * kCalls; stream += 2)
    calls +=
        Http2Call(stream, "/sweepstake.v1.TelemetryService/StreamTelemetry") + Http2Reset(stream);
  const size_t before_kib = ResidentKib();
  HttpSocket stranger(port());
  stranger.Send(calls);
  ScriptedGame game(daemon_.address(), FastOptions());
  EXPECT_TRUE(game.RunUntil(Learns));
  stranger.ReadAll();  // returns when the daemon has closed the connection
  EXPECT_LT(ResidentKib(), before_kib + kQuotaKib);
}

}  // namespace
}  // namespace sweepstake::test_support
