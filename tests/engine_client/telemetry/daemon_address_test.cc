#include "engine_client/telemetry/validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sweepstake {
namespace {

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
