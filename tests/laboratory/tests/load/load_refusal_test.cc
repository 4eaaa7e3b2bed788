// Tests the errors of a load run on a daemon that refuses its games. Each test scripts the daemon.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <string>

#include "sweepstake/v1/errors.pb.h"
#include "tests/laboratory/load/load_run.h"
#include "tests/support/fake_daemon.h"

namespace sweepstake::cli {
namespace {

using test_support::FakeDaemon;
using testing::HasSubstr;

// Returns the status with which a daemon refuses a call.
grpc::Status RefusalOf(grpc::StatusCode code, const std::string& reason) {
  v1::ErrorInfo info;
  info.set_reason(reason);
  info.set_domain("sweepstake");
  v1::StatusDetails details;
  details.set_code(code);
  details.set_message("no");
  google::protobuf::Any& detail = *details.add_details();
  detail.set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  detail.set_value(info.SerializeAsString());
  return {code, "no", details.SerializeAsString()};
}

Result<LoadResult> Load(const FakeDaemon& daemon, const std::function<bool()>& stop) {
  const LoadPlan plan{.daemon = {daemon.address()},
                      .stream_count = 1,
                      .batches_per_second = 100,
                      .duration_ns = 120'000'000'000};
  return RunLoad(plan, stop, [](const std::string&) {});
}

TEST(LoadRefusal, TheFirstReasonIsToldAndNotThatThereWereManyOfIt) {
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) {
    script.refusal_of_evidence = RefusalOf(grpc::StatusCode::UNAUTHENTICATED, "TOKEN_REFUSED");
  });
  daemon.Start();
  std::atomic<bool> stop{false};
  auto result =
      std::async(std::launch::async, [&] { return Load(daemon, [&] { return stop.load(); }); });
  daemon.WaitUntil([](const FakeDaemon& now) { return !now.evidence.empty(); });
  daemon.SetScript([](auto& script) {
    script.refusal = RefusalOf(grpc::StatusCode::RESOURCE_EXHAUSTED, "TOO_MANY_FAILURES");
  });
  // Waits until at least one hello has arrived. Each later hello follows a refusal.
  size_t hello_count = 0;
  daemon.WaitUntil([&](const FakeDaemon& now) { return (hello_count = now.hellos.size()) > 0; });
  daemon.WaitUntil([&](const FakeDaemon& now) { return now.hellos.size() >= hello_count + 3; });
  stop = true;
  const auto ended = result.get();
  ASSERT_TRUE(ended.ok()) << ended.status().message();
  EXPECT_THAT(ended->shortfall.message(), HasSubstr("(TOKEN_REFUSED)"));
}

TEST(LoadRefusal, OfEveryGameIsTheErrorOfADaemonThatDoesNotServe) {
  FakeDaemon daemon;
  daemon.SetScript([](auto& script) {
    script.refusal = RefusalOf(grpc::StatusCode::PERMISSION_DENIED, "NOT_ALLOWED");
  });
  daemon.Start();
  const Status status = Load(daemon, [] { return false; }).status();
  EXPECT_EQ(status.code(), StatusCode::kUnavailable);
  EXPECT_THAT(status.message(), HasSubstr("(NOT_ALLOWED)"));
  daemon.SetScript([](auto& script) {
    script.refusal = RefusalOf(grpc::StatusCode::INVALID_ARGUMENT, "INVALID_MESSAGE");
  });
  EXPECT_EQ(Load(daemon, [] { return false; }).status().code(), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace sweepstake::cli
