// Tests the reasons of statuses: each has a code, and is sent as the google.rpc.ErrorInfo that
// other programs read.
#include "server/rpc/common/error_reasons.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "engine_client/telemetry/daemon_channel.h"

namespace sweepstake::rpc {
namespace {

TEST(ErrorReasons, EachReasonIsSentWithACodeAndCounted) {
  Counters counters;
  for (int number = 1; number < v1::ErrorReason_ARRAYSIZE; ++number) {
    if (!v1::ErrorReason_IsValid(number)) continue;
    const auto reason = static_cast<v1::ErrorReason>(number);
    const grpc::Status status = ToGrpc(Refused(reason, "do something else"), counters);
    EXPECT_EQ(ReasonOf(status), reason);
    EXPECT_EQ(counters.error_counts.at(reason), 1u) << NameOf(reason);
    EXPECT_EQ(status.error_message(), "do something else");
    EXPECT_NE(status.error_code(), grpc::StatusCode::INTERNAL) << NameOf(reason);
  }
}

TEST(ErrorReasons, TheStoresErrorsKeepTheirCode) {
  Counters counters;
  const grpc::Status damaged = ToGrpc(StoreFailed(absl::DataLossError("damaged")), counters);
  EXPECT_EQ(damaged.error_code(), grpc::StatusCode::DATA_LOSS);
  EXPECT_EQ(ReasonOf(damaged), v1::ERROR_REASON_STORE_FAILED);
  const grpc::Status wrong = ToGrpc(StoreFailed(absl::InvalidArgumentError("record 3")), counters);
  EXPECT_EQ(wrong.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(ReasonOf(wrong), v1::ERROR_REASON_INVALID_MESSAGE);
}

TEST(ErrorReasons, AStatusWithoutAReasonIsCounted) {
  Counters counters;
  EXPECT_TRUE(ToGrpc(absl::OkStatus(), counters).ok());
  ToGrpc(absl::CancelledError("the connection was lost"), counters);
  EXPECT_EQ(counters.error_counts.at(v1::ERROR_REASON_UNSPECIFIED), 0u);
  EXPECT_EQ(ReasonOf(ToGrpc(absl::NotFoundError("no"), counters)), v1::ERROR_REASON_UNSPECIFIED);
  EXPECT_EQ(counters.error_counts.at(v1::ERROR_REASON_UNSPECIFIED), 1u);
}

// google.rpc.Status {code: 14, message: "m", details: [Any {type_url, value: ErrorInfo {reason,
// domain}}]} in protobuf's encoding.
TEST(ErrorReasons, TheBytesEqualThoseOfGooglesMessages) {
  Counters counters;
  const std::string url = "type.googleapis.com/google.rpc.ErrorInfo";
  const std::string info = std::string("\x0a\x08") + "DRAINING" + "\x12\x0a" + "sweepstake";
  const std::string any = "\x0a" + std::string(1, static_cast<char>(url.size())) + url + "\x12" +
                          std::string(1, static_cast<char>(info.size())) + info;
  const std::string expected =
      std::string("\x08\x0e\x12\x01m\x1a") + static_cast<char>(any.size()) + any;
  EXPECT_EQ(ToGrpc(Refused(v1::ERROR_REASON_DRAINING, "m"), counters).error_details(), expected);
}

TEST(ErrorReasons, TheClientPrintsTheReasonAfterTheMessage) {
  Counters counters;
  const grpc::Status known = ToGrpc(Refused(v1::ERROR_REASON_DRAINING, "come back"), counters);
  EXPECT_EQ(WithReason(known).error_message(), "come back (DRAINING)");
  std::string newer = known.error_details();
  newer.replace(newer.find("DRAINING"), 8, "SLEEPING");
  const grpc::Status unknown(grpc::StatusCode::UNAVAILABLE, "come back", newer);
  EXPECT_EQ(WithReason(unknown).error_message(), "come back (SLEEPING)");
  EXPECT_EQ(ReasonOf(unknown), v1::ERROR_REASON_UNSPECIFIED);
  const grpc::Status bare(grpc::StatusCode::UNAVAILABLE, "come back", "no details");
  EXPECT_EQ(WithReason(bare).error_message(), "come back");
  const grpc::Status reset(grpc::StatusCode::CANCELLED, "RST_STREAM", known.error_details());
  EXPECT_EQ(WithReason(reset).error_code(), grpc::StatusCode::UNAVAILABLE) << "a proxy's reset";
  EXPECT_EQ(WithReason(reset).error_message(), "come back (DRAINING)");
}

}  // namespace
}  // namespace sweepstake::rpc
