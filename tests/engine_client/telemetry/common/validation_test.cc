#include "engine_client/telemetry/common/validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

namespace sweepstake {
namespace {

TEST(SessionOptions, DefaultsAreValid) {
  EXPECT_TRUE(ValidateSessionOptions(SessionOptions()).ok());
}

TEST(SessionOptions, ErrorsNameTheInvalidOption) {
  const auto wrong_option = [](const std::function<void(SessionOptions&)>& change) {
    SessionOptions options;
    change(options);
    const Status status = ValidateSessionOptions(options);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message().substr(0, status.message().find(' '));
  };
  EXPECT_EQ(wrong_option([](auto& o) { o.project.clear(); }), "project");
  EXPECT_EQ(wrong_option([](auto& o) { o.scene = std::string(129, 'x'); }), "scene");
  EXPECT_EQ(wrong_option([](auto& o) { o.build = "a\nb"; }), "build");
  EXPECT_EQ(wrong_option([](auto& o) { o.time_scale = 0.5; }), "time_scale");
  EXPECT_EQ(wrong_option([](auto& o) { o.time_scale = std::numeric_limits<double>::quiet_NaN(); }),
            "time_scale");
  EXPECT_EQ(wrong_option([](auto& o) { o.queue_frames = 1000; }), "queue_frames");
  EXPECT_EQ(wrong_option([](auto& o) { o.queue_frames = 0; }), "queue_frames");
  EXPECT_EQ(wrong_option([](auto& o) { o.batch_frames = 241; }), "batch_frames");
  EXPECT_EQ(wrong_option([](auto& o) { o.batch_bytes = 1; }), "batch_bytes");
  EXPECT_EQ(wrong_option([](auto& o) { o.batch_interval_ms = 0; }), "batch_interval_ms");
  EXPECT_EQ(wrong_option([](auto& o) { o.unacknowledged_messages = 0; }),
            "unacknowledged_messages");
  EXPECT_EQ(wrong_option([](auto& o) { o.backoff_max_ms = 1; }), "backoff_min_ms");
  EXPECT_EQ(wrong_option([](auto& o) { o.tls.emplace().server_name = "a b"; }), "server_name");
}

TEST(TlsOptionsTest, ErrorsNameTheInvalidOption) {
  const auto message = [](auto change) {
    TlsOptions tls;
    change(tls);
    return ValidateTlsOptions(tls).message();
  };
  using ::testing::HasSubstr;
  EXPECT_EQ(message([](auto&) {}), "");
  EXPECT_EQ(message([](auto& o) { o.cert_file = o.key_file = std::string(4096, 'x'); }), "");
  EXPECT_EQ(message([](auto& o) { o.server_name = "daemon-1.studio.example"; }), "");
  EXPECT_THAT(message([](auto& o) { o.ca_file = std::string(4097, 'x'); }), HasSubstr("ca_file"));
  EXPECT_THAT(message([](auto& o) { o.ca_file = std::string("a\0b", 3); }), HasSubstr("ca_file"));
  EXPECT_THAT(message([](auto& o) { o.cert_file = "c"; }), HasSubstr("cert_file and key_file"));
  EXPECT_THAT(message([](auto& o) { o.key_file = "k"; }), HasSubstr("cert_file and key_file"));
  EXPECT_THAT(message([](auto& o) { o.server_name = "a b"; }), HasSubstr("server_name"));
  EXPECT_THAT(message([](auto& o) { o.server_name = std::string(254, 'x'); }),
              HasSubstr("server_name"));
}

TEST(TlsOptionsTest, ErrorsUseTheOptionNamesOfTheCaller) {
  const TlsNames names{"--tls", "--ca", "--cert", "--key", "--name"};
  TlsOptions tls;
  tls.server_name = "a b";
  using ::testing::StartsWith;
  EXPECT_THAT(ValidateTlsOptions(tls, names).message(), StartsWith("--name must be a host name"));
  tls.cert_file = "c";
  EXPECT_THAT(ValidateTlsOptions(tls, names).message(), StartsWith("--cert and --key must be "));
  tls.ca_file = std::string(4097, 'x');
  EXPECT_THAT(ValidateTlsOptions(tls, names).message(), StartsWith("--ca, --cert and --key must "));
}

TEST(DaemonAddress, AcceptsHostNamesAndBothVersionsOfIpAddresses) {
  for (const char* address :
       {"localhost:1", "127.0.0.1:65535", "[::1]:7411", "daemon-1.studio.example:7411"}) {
    EXPECT_TRUE(ValidateDaemonAddress(address).ok()) << address;
  }
}

TEST(DaemonAddress, ErrorsStateTheExpectedFormat) {
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
