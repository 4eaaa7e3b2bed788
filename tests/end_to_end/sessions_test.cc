// A real daemon kicks a game's session; the game may return only if the kick allows it.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/end_to_end/scripted_game.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

bool Kick(const DaemonProcess& daemon, const std::string& session_id, bool may_return) {
  v1::KickSessionRequest request;
  request.set_session_id(session_id);
  request.set_may_return(may_return);
  const auto channel = grpc::CreateChannel(daemon.address(), grpc::InsecureChannelCredentials());
  grpc::ClientContext context;
  v1::KickSessionResponse response;
  return v1::SessionsService::NewStub(channel)->KickSession(&context, request, &response).ok();
}

TEST(Sessions, AKickedGameReturnsOnlyIfAllowed) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  ScriptedGame game(daemon.address(), FastOptions());
  ASSERT_TRUE(game.RunUntil([](const auto& stats) { return stats.acknowledged_sequence > 0; }));
  const std::string id = game.stats().session_id;
  ASSERT_TRUE(Kick(daemon, id, /*may_return=*/true));
  ASSERT_TRUE(game.RunUntil([](const auto& stats) { return stats.resumed_count == 1; }));
  EXPECT_EQ(game.stats().session_id, id);
  ASSERT_TRUE(Kick(daemon, id, /*may_return=*/false));
  ASSERT_TRUE(game.RunUntil([](const auto& stats) { return !stats.last_error.empty(); }));
  EXPECT_THAT(game.stats().last_error, EndsWith("(SESSION_KICKED)"))
      << "the game must not try again";
  game.RunFrames(100);
  EXPECT_EQ(game.stats().state, ConnectionState::kOffline);
  EXPECT_THAT(daemon.log(), HasSubstr("kicked session " + id));
  game.Stop();
  EXPECT_EQ(daemon.Terminate(), 0);
}

}  // namespace
}  // namespace sweepstake::test_support
