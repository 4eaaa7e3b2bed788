// Tests limits on the streams per address and their rate, on the messages of a stream, and on its
// read-ahead.
#include <spdlog/sinks/ostream_sink.h>

#include <memory>
#include <sstream>
#include <vector>

#include "server/rpc/common/error_reasons.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/rpc/services/prompt_daemon.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

v1::ErrorReason EndOf(const PromptStream& stream) {
  return stream.end() ? ReasonOfRefusal(*stream.end()) : v1::ERROR_REASON_UNSPECIFIED;
}

TEST(ReadAheadTest, OneMessageIsReadWhileAnotherIsAppliedAndNoneDuringALoad) {
  PromptDaemon daemon;
  PromptStream stream(daemon);
  EXPECT_EQ(stream.pending_reads(), 1u);
  daemon.store.HoldReads();
  ASSERT_TRUE(stream.Send(Request(OneArmHello())));
  EXPECT_EQ(stream.pending_reads(), 0u);
  daemon.store.EndReads();
  daemon.Advance(0);
  ASSERT_TRUE(stream.welcomed());
  EXPECT_EQ(stream.pending_reads(), 2u);
  ASSERT_TRUE(stream.Send(Frames(1, 30)));
  EXPECT_EQ(stream.pending_reads(), 2u);
  PromptStream again(daemon);
  v1::Hello hello = OneArmHello();
  Resume(hello, stream.written().front().welcome());
  ASSERT_TRUE(again.Send(Request(hello)));
  EXPECT_EQ(again.pending_reads(), 2u);
}

class AddressQuotaTest : public ::testing::Test {
 protected:
  AddressQuotaTest() { daemon_.options.max_streams_per_address = 3; }
  void Open(const std::string& peer, int count) {
    for (int i = 0; i < count; ++i)
      streams_.push_back(
          std::make_unique<PromptStream>(daemon_, peer + ":" + std::to_string(1'000 + i)));
  }

  PromptDaemon daemon_;
  std::vector<std::unique_ptr<PromptStream>> streams_;
};

TEST_F(AddressQuotaTest, AnAddressHasLimitedStreamsAndOneThatEndsMakesRoom) {
  Open("ipv4:192.0.2.7", 3);
  EXPECT_EQ(daemon_.streams.all.size(), 3u);
  PromptStream fourth(daemon_, "ipv4:192.0.2.7:9");
  ASSERT_TRUE(fourth.end());
  EXPECT_TRUE(absl::IsResourceExhausted(*fourth.end()));
  EXPECT_EQ(EndOf(fourth), v1::ERROR_REASON_TOO_MANY_STREAMS);
  EXPECT_THAT(std::string(fourth.end()->message()), HasSubstr("max_streams_per_address"));
  PromptStream elsewhere(daemon_, "ipv4:192.0.2.8:9");
  EXPECT_FALSE(elsewhere.end());
  streams_.pop_back();
  PromptStream fifth(daemon_, "ipv4:192.0.2.7:10");
  EXPECT_FALSE(fifth.end());
}

TEST_F(AddressQuotaTest, OneStreamTooManyIsLogged) {
  std::ostringstream text;
  daemon_.log.sinks().push_back(std::make_shared<spdlog::sinks::ostream_sink_mt>(text));
  Open("ipv4:192.0.2.7", 5);
  EXPECT_THAT(text.str(), HasSubstr("refused ipv4:192.0.2.7:1003 (TOO_MANY_STREAMS)"));
}

TEST_F(AddressQuotaTest, Ipv6IsCountedPerNetworkAndTheOwnMachineIsNotCounted) {
  Open("ipv6:%5B2001:db8::1%5D", 2);
  Open("ipv6:%5B2001:db8::2%5D", 1);
  PromptStream fourth(daemon_, "ipv6:%5B2001:db8::3%5D:9");
  EXPECT_EQ(EndOf(fourth), v1::ERROR_REASON_TOO_MANY_STREAMS);
  streams_.clear();
  Open("ipv4:127.0.0.1", 10);
  for (const auto& stream : streams_) EXPECT_FALSE(stream->end());
}

class HelloQuotaTest : public ::testing::Test {
 protected:
  // Opens streams and drops each once it has its answer. Returns how many received a welcome
  // message.
  int OpenAndDrop(int count, const std::string& address, int64_t token_id = 0,
                  const std::string& player = "") {
    auth::Principal caller;
    caller.token_id = token_id;
    caller.player = player;
    int welcome_count = 0;
    for (int i = 0; i < count; ++i) {
      PromptStream stream(daemon_, address + ":" + std::to_string(1'000 + i), caller);
      stream.Send(Request(OneArmHello()));
      welcome_count += stream.welcomed() ? 1 : 0;
      if (stream.end()) {
        EXPECT_TRUE(absl::IsResourceExhausted(*stream.end()));
        EXPECT_EQ(EndOf(stream), v1::ERROR_REASON_TOO_MANY_HELLOS);
        EXPECT_THAT(std::string(stream.end()->message()), HasSubstr("max_hellos_per_s"));
      }
    }
    return welcome_count;
  }

  PromptDaemon daemon_;
};

TEST_F(HelloQuotaTest, OpeningAndDroppingStreamsIsLimitedPerNetwork) {
  daemon_.options.max_hellos_per_s = 2;
  EXPECT_EQ(OpenAndDrop(100, "ipv4:192.0.2.7"), 20);
  EXPECT_EQ(daemon_.counters.invalid_message_count, 0u);
  EXPECT_EQ(OpenAndDrop(20, "ipv4:192.0.2.8"), 0) << "an address of the same network";
  EXPECT_EQ(OpenAndDrop(20, "ipv4:198.51.100.8"), 20);
  daemon_.Advance(kSecondNs);
  EXPECT_EQ(OpenAndDrop(100, "ipv4:192.0.2.7"), 2);
  daemon_.options.max_hellos_per_s = 1'000;
  daemon_.Advance(kSecondNs);
  EXPECT_EQ(OpenAndDrop(100, "ipv4:192.0.2.7"), 100) << "the rate can be changed at any time";
}

TEST_F(HelloQuotaTest, AClientDoesNotUseUpTheRateOfOthersWithItsToken) {
  daemon_.options.max_hellos_per_s = 2;
  EXPECT_EQ(OpenAndDrop(100, "ipv4:192.0.2.7", 7), 20);
  EXPECT_EQ(OpenAndDrop(20, "ipv4:198.51.100.8", 7), 20);
}

TEST_F(HelloQuotaTest, APlayerWithATicketHasOneRateForAllAddresses) {
  daemon_.options.max_hellos_per_s = 2;
  int welcome_count = 0;
  for (int host = 0; host < 50; ++host)
    welcome_count += OpenAndDrop(1, "ipv4:192.0." + std::to_string(host) + ".2", 7, "mallory");
  EXPECT_EQ(welcome_count, 20);
  EXPECT_EQ(OpenAndDrop(20, "ipv4:192.0.2.7", 7, "alice"), 20);
  EXPECT_EQ(OpenAndDrop(20, "ipv4:192.0.2.7", 7), 20);
}

TEST_F(HelloQuotaTest, TheOwnMachineHasNoRateBecauseOfProxies) {
  daemon_.options.max_hellos_per_s = 2;
  EXPECT_EQ(OpenAndDrop(100, "ipv4:127.0.0.1", 7), 20) << "the limit of the token";
  EXPECT_EQ(OpenAndDrop(100, "ipv4:127.0.0.1"), 100);
  EXPECT_EQ(OpenAndDrop(100, "ipv6:%5B::1%5D"), 100);
}

TEST_F(HelloQuotaTest, TenThousandGamesOfOneAddressAndTokenReconnectAtOnce) {
  EXPECT_EQ(OpenAndDrop(10'000, "ipv4:192.0.2.7", 7), 10'000);
}

class MessageQuotaTest : public ::testing::Test {
 protected:
  MessageQuotaTest() {
    daemon_.options.max_messages_per_s = 20;
    daemon_.options.max_time_scale = 8;
  }
  // Sends messages until one ends the stream, and returns how many were accepted.
  int SendUntilTheEnd(PromptStream& stream,
                      const std::function<v1::StreamTelemetryRequest()>& next) {
    int count = 0;
    while (count < 10'000 && stream.Send(next())) ++count;
    return count;
  }
  v1::StreamTelemetryRequest NextFrames() { return Frames(++sequence_, 1); }

  PromptDaemon daemon_;
  uint64_t sequence_ = 0;
};

TEST_F(MessageQuotaTest, AFloodOfMessagesEndsTheStreamWhichMayReconnect) {
  for (const bool bail_outs : {false, true}) {
    PromptStream stream(daemon_);
    EXPECT_TRUE(stream.Send(Request(OneArmHello())));
    sequence_ = 0;
    const int sent = SendUntilTheEnd(stream, [&] {
      if (!bail_outs) return NextFrames();
      ++sequence_;
      return BailOut(sequence_, sequence_);
    });
    EXPECT_EQ(sent, 199) << "with the Hello, a burst of ten seconds";
    ASSERT_TRUE(stream.end());
    EXPECT_TRUE(absl::IsResourceExhausted(*stream.end()));
    EXPECT_EQ(EndOf(stream), v1::ERROR_REASON_TOO_MANY_MESSAGES);
    PromptStream again(daemon_);
    EXPECT_TRUE(again.Send(Request(OneArmHello())));
  }
}

TEST_F(MessageQuotaTest, AClientThatFollowsTheBatchIntervalNeverReachesTheLimit) {
  PromptStream stream(daemon_);
  ASSERT_TRUE(stream.Send(Request(OneArmHello())));
  for (int second = 0; second < 100; ++second) {
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(stream.Send(NextFrames())) << second;
    daemon_.Advance(kSecondNs);
  }
}

TEST_F(MessageQuotaTest, ATimeScaleMultipliesTheLimit) {
  v1::Hello hello = OneArmHello();
  hello.set_time_scale(8);
  PromptStream stream(daemon_);
  ASSERT_TRUE(stream.Send(Request(hello)));
  EXPECT_GE(SendUntilTheEnd(stream, [&] { return NextFrames(); }), 8 * 200 - 8);
  EXPECT_EQ(EndOf(stream), v1::ERROR_REASON_TOO_MANY_MESSAGES);
}

}  // namespace
}  // namespace sweepstake::rpc
