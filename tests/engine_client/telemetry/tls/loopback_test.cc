#include "engine_client/telemetry/tls/tls_files.h"

#include <gtest/gtest.h>

namespace sweepstake::tls {
namespace {

TEST(LoopbackTest, OnlyLoopbackNumbersAndLocalhostAreLoopback) {
  for (const char* own : {"127.0.0.1:7433", "127.8.9.10:0", "localhost:1", "[::1]:7433"})
    EXPECT_TRUE(IsLoopback(own)) << own;
  for (const char* other : {"0.0.0.0:7433", "[::]:7433", "192.0.2.1:1", "127.example.com:7433",
                            "127.0.0.1.example.com:7433", "localhost.example.com:1", "", ":1"})
    EXPECT_FALSE(IsLoopback(other)) << other;
}

}  // namespace
}  // namespace sweepstake::tls
