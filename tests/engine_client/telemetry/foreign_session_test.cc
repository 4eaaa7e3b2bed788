// Tests a client whose session the daemon refuses to resume, because it belongs to another client.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "sweepstake/session.h"
#include "sweepstake/v1/errors.pb.h"
#include "tests/support/fake_daemon.h"

namespace sweepstake {
namespace {

using test_support::FakeDaemon;

// Returns the status that refuses to resume a session of another client.
grpc::Status ForeignSession() {
  v1::ErrorInfo info;
  info.set_reason("FOREIGN_SESSION");
  info.set_domain("sweepstake");
  v1::StatusDetails details;
  details.set_code(grpc::StatusCode::PERMISSION_DENIED);
  details.set_message("not yours");
  google::protobuf::Any& detail = *details.add_details();
  detail.set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  detail.set_value(info.SerializeAsString());
  return {grpc::StatusCode::PERMISSION_DENIED, "not yours", details.SerializeAsString()};
}

TEST(ForeignSessionTest, IsNotResumedAgainAndANewSessionBegins) {
  FakeDaemon daemon;
  daemon.Start();
  SessionOptions options;
  options.batch_interval_ms = 1;
  options.backoff_min_ms = 1;
  options.backoff_max_ms = 1;
  const auto session = std::move(*MakeDaemonSession(daemon.address(), options));
  const auto adaptive =
      std::move(*AdaptiveBroadPhase::Create({.arms = {"BruteForce", "Grid"}}, &session->sink()));
  ASSERT_TRUE(session->Start(*adaptive).ok());
  daemon.WaitUntil([](const FakeDaemon& now) { return now.hellos.size() == 1; });
  while (session->stats().session_id.empty())
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const int port = daemon.port();
  daemon.Kill();
  // The client may open another stream after the aborted one, before the port closes.
  const size_t before = daemon.hellos.size();
  daemon.SetScript([](auto& script) { script.refusal = ForeignSession(); });
  daemon.Start(port);
  daemon.WaitUntil([=](const FakeDaemon& now) { return now.hellos.size() >= before + 2; });
  session->Stop(0);
  daemon.Kill();
  EXPECT_EQ(daemon.hellos[before].session_id(), "session-1");
  EXPECT_EQ(daemon.hellos[before + 1].session_id(), "");
}

}  // namespace
}  // namespace sweepstake
