#include "server/net/http2_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/server/rpc/http2_frames.h"

namespace sweepstake::net {
namespace {

using test_support::Http2Type;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::string_view kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
constexpr int64_t kSecond = 1'000'000'000;
// Flags of RFC 9113.
constexpr uint8_t kEndStream = 1, kEndHeaders = 4, kPadded = 8;

std::string Number(uint64_t value, int byte_count) {
  std::string bytes;
  for (int shift = 8 * (byte_count - 1); shift >= 0; shift -= 8)
    bytes.push_back(static_cast<char>(value >> shift));
  return bytes;
}

std::string Frame(Http2Type type, uint8_t flags, uint32_t stream, const std::string& payload = {}) {
  return test_support::Http2Frame(type, static_cast<char>(flags), stream, payload);
}

std::string Message(size_t length, char fill = 'm') {
  return Number(0, 1) + Number(length, 4) + std::string(length, fill);
}

std::string Open(uint32_t stream) {
  return Frame(Http2Type::kHeaders, kEndHeaders, stream, "headers");
}
std::string ToServerReset(uint32_t stream) {
  return Frame(Http2Type::kResetStream, 0, stream, Number(8, 4));
}
std::string GoAway(uint32_t last_stream) {
  return Frame(Http2Type::kGoAway, 0, 0, Number(last_stream, 4) + Number(0, 4));
}
std::string Literal(const std::string& text) { return Number(text.size(), 1) + text; }
// The answer to a refused call. `is_first`: gRPC has sent no headers for the call.
std::string Refusal(uint32_t stream, bool is_first = true) {
  std::string block = Number(0, 1) + Literal("grpc-status") + Literal("8");
  const std::string first =
      "\x88" + Number(0, 1) + Literal("content-type") + Literal("application/grpc");
  if (is_first) block = first + block;
  return Frame(Http2Type::kHeaders, kEndHeaders | kEndStream, stream, block) +
         Frame(Http2Type::kResetStream, 0, stream, Number(0, 4));
}

Http2Guard::Headers Unexpected(Http2Refusal why) {
  ADD_FAILURE() << static_cast<int>(why);
  return {};
}

class Http2GuardTest : public ::testing::Test {
 protected:
  Http2GuardTest() { EXPECT_EQ(Send(std::string(kPreface)), kPreface); }

  // Returns what gRPC reads.
  std::string Send(const std::string& bytes) {
    std::string to_server;
    is_open_ = is_open_ && guard_.FromClient(bytes, now_ns_, to_server);
    guard_.TakeAnswers(to_client_);
    return to_server;
  }
  // Returns what the client has read since the last call.
  std::string Answer(const std::string& bytes = {}) {
    guard_.FromServer(bytes, to_client_);
    return std::exchange(to_client_, {});
  }

  const Http2Limits limits_ = {.max_message_bytes = 100,
                               .of_connection = {.calls = 4, .bytes = 250},
                               .of_all = {.calls = 6, .bytes = 300},
                               .max_resets_per_s = 2};
  const std::shared_ptr<Http2Use> all_ = std::make_shared<Http2Use>();
  std::vector<Http2Refusal> refusals_;
  Http2Guard guard_{limits_, all_, [this](Http2Refusal why) {
                      refusals_.push_back(why);
                      return Http2Guard::Headers{{"grpc-status", "8"}};
                    }};
  int64_t now_ns_ = 0;
  bool is_open_ = true;
  std::string to_client_;
};

TEST_F(Http2GuardTest, ForwardsEveryByteInAnySlices) {
  const std::string bytes = Frame(Http2Type::kSettings, 0, 0) + Open(1) +
                            Frame(Http2Type::kData, 0, 1, Message(100)) +
                            Frame(Http2Type::kData, kEndStream, 1, Message(3) + Message(0));
  for (size_t slice = 1; slice < bytes.size(); slice += 7) {
    Http2Guard guard(limits_, all_, &Unexpected);
    std::string to_server, to_client;
    EXPECT_TRUE(guard.FromClient(kPreface, 0, to_server));
    for (size_t at = 0; at < bytes.size(); at += slice) {
      EXPECT_TRUE(guard.FromClient(bytes.substr(at, slice), 0, to_server));
      guard.FromServer(bytes.substr(at, slice), to_client);
    }
    EXPECT_EQ(to_server, std::string(kPreface) + bytes);
    EXPECT_EQ(to_client, bytes);
    EXPECT_EQ(guard.waiting_call_count(), 0u);
  }
}

TEST_F(Http2GuardTest, EndsACallAtTheAnnouncedLength) {
  const std::string prefix = Frame(Http2Type::kData, 0, 1, Number(0, 1) + Number(101, 4));
  EXPECT_EQ(Send(Open(1) + prefix), Open(1) + prefix + ToServerReset(1));
  EXPECT_EQ(Answer(), Refusal(1));
  EXPECT_THAT(refusals_, ElementsAre(Http2Refusal::kLongMessage));
  const std::string rest = Frame(Http2Type::kData, 0, 1, std::string(101, 'x'));
  EXPECT_EQ(Send(rest + Open(3)), rest + Open(3)) << "gRPC ignores data of a call that has ended";
  EXPECT_TRUE(is_open_);
  EXPECT_EQ(guard_.open_call_count(), 1u);
}

TEST_F(Http2GuardTest, FindsAPrefixInSeveralFrames) {
  const std::string prefix = Number(0, 1) + Number(101, 4);
  Send(Open(1) + Frame(Http2Type::kData, 0, 1, Message(7) + prefix.substr(0, 2)));
  EXPECT_THAT(refusals_, IsEmpty());
  Send(Frame(Http2Type::kData, kPadded, 1, std::string(1, 3) + prefix.substr(2) + "pad"));
  EXPECT_THAT(refusals_, ElementsAre(Http2Refusal::kLongMessage));
}

TEST_F(Http2GuardTest, EndsACallWithACompressedMessage) {
  Send(Open(1) + Frame(Http2Type::kData, 0, 1, Number(1, 1)));
  EXPECT_THAT(refusals_, ElementsAre(Http2Refusal::kCompressedMessage));
  EXPECT_EQ(Answer(), Refusal(1));
}

TEST_F(Http2GuardTest, AnswersACallThatGrpcHasAnsweredWithTrailers) {
  const std::string answer = Frame(Http2Type::kHeaders, kEndHeaders, 1, "answer");
  Send(Open(1));
  EXPECT_EQ(Answer(answer), answer);
  Send(Frame(Http2Type::kData, 0, 1, Number(1, 1)));
  EXPECT_EQ(Answer(), Refusal(1, /*is_first=*/false));
}

TEST_F(Http2GuardTest, WritesLongHeaders) {
  const std::string message(127 + 200, 'm');
  Http2Guard guard(limits_, all_, [&](Http2Refusal) {
    return Http2Guard::Headers{{"grpc-message", message}};
  });
  std::string to_server, to_client;
  guard.FromClient(std::string(kPreface) + Open(1) + Frame(Http2Type::kData, 0, 1, Number(1, 1)), 0,
                   to_server);
  guard.TakeAnswers(to_client);
  EXPECT_NE(to_client.find("grpc-message\x7F\xC8\x01" + message), std::string::npos);
}

TEST_F(Http2GuardTest, LimitsTheBytesOfIncompleteMessagesOfAConnection) {
  const std::string part = Message(100).substr(0, 10);
  Send(Open(1) + Frame(Http2Type::kData, 0, 1, part) + Open(3) +
       Frame(Http2Type::kData, 0, 3, part));
  EXPECT_THAT(refusals_, IsEmpty());
  Send(Open(5) + Frame(Http2Type::kData, 0, 5, part));
  EXPECT_THAT(refusals_, ElementsAre(Http2Refusal::kWaitingBytes));
  Send(Frame(Http2Type::kData, 0, 1, std::string(95, 'm')) + Open(7) +
       Frame(Http2Type::kData, 0, 7, part));
  EXPECT_EQ(refusals_.size(), 1u) << "a complete message does not count";
}

TEST_F(Http2GuardTest, EndsCallsWhoseFirstMessageIsLate) {
  Send(Open(1));
  now_ns_ = 5 * kSecond;
  Send(Open(3) + Open(5) + Frame(Http2Type::kData, 0, 5, Message(1)));
  EXPECT_EQ(guard_.waiting_call_count(), 2u);
  std::string to_server;
  guard_.EndLateCalls(10 * kSecond - 1, to_server);
  EXPECT_THAT(refusals_, IsEmpty());
  guard_.EndLateCalls(10 * kSecond, to_server);
  EXPECT_EQ(to_server, ToServerReset(1));
  guard_.EndLateCalls(100 * kSecond, to_server);
  EXPECT_EQ(to_server, ToServerReset(1) + ToServerReset(3));
  EXPECT_EQ(guard_.waiting_call_count(), 0u);
  EXPECT_EQ(guard_.open_call_count(), 1u) << "the call with a message stays";
}

TEST_F(Http2GuardTest, LimitsTheCallsWithoutAMessage) {
  for (uint32_t stream = 1; stream < 9; stream += 2) Send(Open(stream));
  Answer(Frame(Http2Type::kHeaders, kEndHeaders | kEndStream, 1, "trailers") + ToServerReset(3));
  Send(Open(9) + Open(11));
  EXPECT_THAT(refusals_, IsEmpty()) << "calls that gRPC has ended do not count";
  const std::string more = Open(13) + Frame(Http2Type::kData, 0, 13, Message(1));
  EXPECT_EQ(Send(more + more), "");
  EXPECT_THAT(refusals_, ElementsAre(Http2Refusal::kWaitingCalls));
  const std::string window = Frame(Http2Type::kWindowUpdate, 0, 0, Number(6, 4));
  EXPECT_EQ(Answer(), GoAway(11) + window + window);
}

TEST_F(Http2GuardTest, AfterAGoAwayTheAcceptedCallsGoOn) {
  for (uint32_t stream = 1; stream < 11; stream += 2) Send(Open(stream));
  EXPECT_EQ(Answer(), GoAway(7));
  const std::string data = Frame(Http2Type::kData, kEndStream, 1, Message(3));
  EXPECT_EQ(Send(data + Frame(Http2Type::kPing, 0, 0, "12345678")),
            data + Frame(Http2Type::kPing, 0, 0, "12345678"));
  EXPECT_EQ(Send(Open(11)), "") << "although fewer calls wait";
  EXPECT_TRUE(is_open_);
  EXPECT_EQ(Answer(GoAway(0x7FFFFFFF)), "") << "gRPC's own would allow further calls";
  for (uint32_t stream = 1; stream < 9; stream += 2) {
    EXPECT_FALSE(guard_.is_done());
    Answer(Frame(Http2Type::kHeaders, kEndHeaders | kEndStream, stream, "trailers"));
  }
  EXPECT_TRUE(guard_.is_done());
}

TEST_F(Http2GuardTest, AConnectionMayHaveOneCallIfAllHaveTooMany) {
  std::string to_server;
  std::vector<std::unique_ptr<Http2Guard>> others;
  for (int i = 0; i < 8; ++i) {
    others.push_back(std::make_unique<Http2Guard>(limits_, all_, &Unexpected));
    EXPECT_TRUE(others.back()->FromClient(std::string(kPreface) + Open(1), 0, to_server));
  }
  Send(Open(1));
  EXPECT_THAT(refusals_, IsEmpty());
  Send(Open(3));
  EXPECT_THAT(refusals_, ElementsAre(Http2Refusal::kWaitingCalls));
  others.clear();
  EXPECT_EQ(all_->calls, 1u);
}

TEST_F(Http2GuardTest, AResetDoesNotDivideAHeaderBlock) {
  Send(Open(1));
  const std::string begin = Frame(Http2Type::kHeaders, 0, 3, "head");
  const std::string end = Frame(Http2Type::kContinuation, kEndHeaders, 3, "ers");
  EXPECT_EQ(Send(begin), begin);
  std::string to_server;
  guard_.EndLateCalls(10 * kSecond, to_server);
  EXPECT_EQ(to_server, "");
  EXPECT_EQ(Send(end), end + ToServerReset(1) + ToServerReset(3));

  const std::string server_frame = Frame(Http2Type::kData, 0, 5, "data");
  EXPECT_EQ(Answer(server_frame.substr(0, 11)),
            Refusal(1) + Refusal(3) + server_frame.substr(0, 11));
  Send(Open(7) + Frame(Http2Type::kData, 0, 7, Number(1, 1)));
  EXPECT_EQ(Answer(server_frame.substr(11)), server_frame.substr(11) + Refusal(7));
}

TEST_F(Http2GuardTest, AConnectionThatResetsTooManyCallsMakesNoMore) {
  for (uint32_t stream = 1; stream < 1'000; stream += 2)
    Send(Open(stream) + Frame(Http2Type::kResetStream, 0, stream, Number(8, 4)));
  EXPECT_THAT(refusals_, ElementsAre(Http2Refusal::kResets));
  EXPECT_TRUE(guard_.is_done());
}

TEST_F(Http2GuardTest, AConnectionWithTooManyRefusedCallsMakesNoMore) {
  for (uint32_t stream = 1; stream < 1'000; stream += 2)
    Send(Open(stream) + Frame(Http2Type::kData, 0, stream, Number(1, 1)));
  EXPECT_EQ(refusals_.back(), Http2Refusal::kRefusals);
  EXPECT_EQ(refusals_.size(), limits_.max_refusals + 2u);
}

TEST_F(Http2GuardTest, AllowsResetsThatAreSpreadOverTime) {
  for (uint32_t stream = 1; stream < 1'000; stream += 2, now_ns_ += kSecond)
    Send(Open(stream) + Frame(Http2Type::kResetStream, 0, stream, Number(8, 4)));
  EXPECT_TRUE(is_open_);
}

TEST(Http2GuardBytes, ClosesWhatIsNotHttp2) {
  const std::vector<std::string> samples = {
      "GET / HTTP/1.1\r\n",
      std::string(kPreface) + Number(16'385, 3) + std::string(6, 0),
      std::string(kPreface) + Frame(Http2Type::kContinuation, kEndHeaders, 1),
      std::string(kPreface) + Frame(Http2Type::kHeaders, 0, 1) + Frame(Http2Type::kData, 0, 1),
      std::string(kPreface) + Open(2),
      std::string(kPreface) + Open(1) + Frame(Http2Type::kData, kPadded, 1),
      std::string(kPreface) + Open(1) + Frame(Http2Type::kData, kPadded, 1, std::string(3, 3)),
  };
  for (const std::string& bytes : samples) {
    std::vector<Http2Refusal> refusals;
    Http2Guard guard({}, std::make_shared<Http2Use>(), [&](Http2Refusal why) {
      refusals.push_back(why);
      return Http2Guard::Headers();
    });
    std::string to_server;
    EXPECT_FALSE(guard.FromClient(bytes, 0, to_server)) << bytes;
    EXPECT_THAT(refusals, ElementsAre(Http2Refusal::kNotHttp2)) << bytes;
    std::string to_client;
    guard.TakeAnswers(to_client);
    EXPECT_EQ(to_client.starts_with("HTTP/1.1 400"), bytes.starts_with("GET")) << bytes;
  }
}

}  // namespace
}  // namespace sweepstake::net
