#include "engine_client/telemetry/validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace sweepstake {
namespace {

TEST(SessionOptions, DefaultsAreValid) {
  EXPECT_TRUE(ValidateSessionOptions(SessionOptions()).ok());
}

TEST(SessionOptions, NamesTheOptionThatIsWrong) {
  const auto complaint = [](auto change) {
    SessionOptions options;
    change(options);
    const Status status = ValidateSessionOptions(options);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message().substr(0, status.message().find(' '));
  };
  EXPECT_EQ(complaint([](auto& o) { o.project.clear(); }), "project");
  EXPECT_EQ(complaint([](auto& o) { o.scene = std::string(129, 'x'); }), "scene");
  EXPECT_EQ(complaint([](auto& o) { o.build = "a\nb"; }), "build");
  EXPECT_EQ(complaint([](auto& o) { o.time_scale = 0.5; }), "time_scale");
  EXPECT_EQ(complaint([](auto& o) { o.time_scale = std::numeric_limits<double>::quiet_NaN(); }),
            "time_scale");
  EXPECT_EQ(complaint([](auto& o) { o.queue_frames = 1000; }), "queue_frames");
  EXPECT_EQ(complaint([](auto& o) { o.queue_frames = 0; }), "queue_frames");
  EXPECT_EQ(complaint([](auto& o) { o.batch_frames = 241; }), "batch_frames");
  EXPECT_EQ(complaint([](auto& o) { o.batch_bytes = 1; }), "batch_bytes");
  EXPECT_EQ(complaint([](auto& o) { o.batch_interval_ms = 0; }), "batch_interval_ms");
  EXPECT_EQ(complaint([](auto& o) { o.unacknowledged_messages = 0; }), "unacknowledged_messages");
  EXPECT_EQ(complaint([](auto& o) { o.backoff_max_ms = 1; }), "backoff_min_ms");
}

TEST(Names, TakePrintableUtf8UpToTheLimit) {
  EXPECT_TRUE(IsName("Hurricane <3> \"x\"; DROP TABLE"));
  EXPECT_TRUE(IsName("\xC3\xA4\xE2\x82\xAC\xF0\x9F\x8C\x80"));
  EXPECT_TRUE(IsName(std::string(128, 'x')));
  EXPECT_FALSE(IsName(std::string(129, 'x')));
}

TEST(Names, RejectControlCharactersAndBrokenUtf8) {
  using namespace std::string_view_literals;
  for (const std::string_view broken :
       {"a\0b"sv, "\x1F"sv, "\x7F"sv, "\xC2\x85"sv, "\x80"sv, "\xC3"sv, "\xC0\xAF"sv,
        "\xE0\x80\xAF"sv, "\xED\xA0\x80"sv, "\xF4\x90\x80\x80"sv, "\xF5\x80\x80\x80"sv,
        "\xE2\x28\xA1"sv}) {
    EXPECT_FALSE(IsName(broken)) << ::testing::PrintToString(broken);
  }
}

TEST(DaemonAddress, TakesHostNamesAndBothKindsOfIpAddresses) {
  for (const char* address :
       {"localhost:1", "127.0.0.1:65535", "[::1]:7411", "daemon-1.studio.example:7411"}) {
    EXPECT_TRUE(ValidateDaemonAddress(address).ok()) << address;
  }
}

TEST(DaemonAddress, SaysHowToWriteOne) {
  for (const char* address :
       {"", ":", "host", "host:", ":80", "host:0", "host:65536", "host:-1", "host:8x", "::1:80",
        "[]:80", "ho st:80", "unix:/tmp/x", "dns://x/host:80"}) {
    const Status status = ValidateDaemonAddress(address);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << address;
    EXPECT_THAT(status.message(), ::testing::HasSubstr("HOST:PORT"));
  }
}

}  // namespace
}  // namespace sweepstake
