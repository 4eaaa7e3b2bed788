#include "server/host/grpc_log.h"

#include <gmock/gmock.h>
#include <grpc/support/log.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <memory>
#include <sstream>

namespace sweepstake::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(GrpcLogTest, LogsErrorsOfGrpcAtALimitedRate) {
  std::ostringstream text;
  {
    const GrpcLog log(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text)));
    gpr_log(GPR_INFO, "info");
    gpr_log(GPR_ERROR, "the first of %d", 2);
    gpr_log(GPR_ERROR, "the second");
  }
  gpr_log(GPR_ERROR, "later");
  EXPECT_THAT(text.str(), HasSubstr("gRPC: the first of 2 (0 lines before it were omitted)"));
  EXPECT_THAT(text.str(), Not(HasSubstr("info")));
  EXPECT_THAT(text.str(), Not(HasSubstr("second")));
  EXPECT_THAT(text.str(), Not(HasSubstr("later")));
}

}  // namespace
}  // namespace sweepstake::server
