// Tests games and the real daemon with tokens: who may connect, which errors others get, and that
// no token appears in anything that the daemon writes or sends.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <stdio.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/end_to_end/scripted_game.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/daemon_process.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Returns the output of `sweepstaked ARGUMENTS`, including errors.
std::string RunDaemonCommand(const std::string& arguments) {
  std::string text;
  FILE* output = popen((std::string(SWEEPSTAKED_PATH) + " " + arguments + " 2>&1").c_str(), "r");
  for (int c = fgetc(output); c != EOF; c = fgetc(output)) text += static_cast<char>(c);
  pclose(output);
  return text;
}

std::string Content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class TokenTest : public ::testing::Test {
 protected:
  // Creates a token and returns the file that contains it.
  std::string MakeToken(const std::string& name, const std::string& options) {
    const std::string file = (folder_.path() / (name + ".token")).string();
    RunDaemonCommand("token create " + name + " " + options + " --out " + file + Data());
    EXPECT_FALSE(Content(file).empty());
    return file;
  }
  std::string Data() const { return " --data " + data_.path().string(); }
  static SessionOptions With(const std::string& token_file) {
    SessionOptions options = FastOptions();
    options.token.file = token_file;
    return options;
  }
  static bool IsConnected(const SessionStats& stats) { return stats.acknowledged_sequence > 0; }
  static bool IsRefused(const SessionStats& stats) { return !stats.refusal.empty(); }

  TemporaryDirectory folder_;
  TemporaryDirectory data_;
};

TEST_F(TokenTest, AGameWithATokenLearnsAndOneWithoutGetsAnError) {
  const std::string file = MakeToken("game", "--role ingest");
  DaemonProcess daemon(data_.path());
  ScriptedGame game(daemon.address(), With(file));
  EXPECT_TRUE(game.RunUntil(IsConnected));
  ScriptedGame other(daemon.address(), FastOptions());
  EXPECT_TRUE(other.RunUntil(IsRefused));
  EXPECT_THAT(other.stats().refusal, HasSubstr("requires a token"));
  EXPECT_THAT(other.stats().refusal, HasSubstr("TOKEN_MISSING"));
  game.Stop();
  EXPECT_EQ(daemon.Terminate(), 0);
}

TEST_F(TokenTest, AGameWithATicketLearnsAndItsEvidenceIsRevokedByItsPlayer) {
  const std::string token = MakeToken("backend", "--role ticket");
  const std::string admin = MakeToken("admin", "--role admin");
  const std::string studio = MakeToken("studio", "--role ingest");
  const DaemonProcess daemon(data_.path());
  ScriptedGame first(daemon.address(), With(studio));
  EXPECT_TRUE(first.RunUntil(IsConnected));
  first.Stop();
  for (const std::string player : {"alice", "mallory"}) {
    const std::string file = token + "." + player;
    std::ofstream(file) << RunDaemonCommand("ticket " + player + " --token-file " + token);
    ScriptedGame game(daemon.address(), With(file));
    EXPECT_TRUE(game.RunUntil(IsConnected));
    game.Stop();
  }
  grpc::ClientContext call;
  std::ifstream admin_file(admin);
  std::string secret;
  admin_file >> secret;
  call.AddMetadata("authorization", "Bearer " + secret);
  v1::RevokePriorsRequest request;
  request.mutable_sources()->set_player("mallory");
  v1::RevokePriorsResponse response;
  const auto channel = grpc::CreateChannel(daemon.address(), grpc::InsecureChannelCredentials());
  const auto status = v1::PriorsService::NewStub(channel)->RevokePriors(&call, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.source_count(), 1u);
  EXPECT_GT(response.record_count(), 0u);
}

TEST_F(TokenTest, ATicketThatWasChangedOrIsSignedByAnotherTokenIsRefused) {
  const std::string token = MakeToken("backend", "--role ticket");
  const std::string player = MakeToken("player", "--role player");
  const DaemonProcess daemon(data_.path());
  std::string changed = RunDaemonCommand("ticket alice --token-file " + token);
  changed.replace(changed.find("alice"), 5, "carol");
  const std::string file = token + ".ticket";
  for (const std::string& ticket :
       {changed, RunDaemonCommand("ticket alice --token-file " + player)}) {
    std::ofstream(file) << ticket;
    ScriptedGame game(daemon.address(), With(file));
    EXPECT_TRUE(game.RunUntil(IsRefused));
    EXPECT_THAT(game.stats().refusal, HasSubstr("TOKEN_REFUSED"));
  }
  EXPECT_THAT(RunDaemonCommand("ticket 'a b' --token-file " + token), HasSubstr("letters, digits"));
  EXPECT_THAT(RunDaemonCommand("ticket alice --token-file /nowhere"), HasSubstr("cannot read"));
  EXPECT_THAT(RunDaemonCommand("ticket alice --token-file " + file), HasSubstr("cannot read"))
      << "a ticket is not a token";
}

TEST_F(TokenTest, ATokenOfAnotherRoleOrProjectIsRefused) {
  const std::string watch = MakeToken("watch", "--role watch");
  const std::string other = MakeToken("other", "--role ingest --project other");
  const DaemonProcess daemon(data_.path());
  for (const std::string& file : {watch, other}) {
    ScriptedGame game(daemon.address(), With(file));
    EXPECT_TRUE(game.RunUntil(IsRefused));
    EXPECT_THAT(game.stats().refusal, HasSubstr("NOT_ALLOWED"));
  }
}

TEST_F(TokenTest, AGameWithARevokedTokenGetsAnErrorAndContinuesWithItsNextToken) {
  const std::string file = MakeToken("first", "--role ingest");
  const DaemonProcess daemon(data_.path());
  ScriptedGame game(daemon.address(), With(file));
  ASSERT_TRUE(game.RunUntil(IsConnected));
  RunDaemonCommand("token revoke first" + Data());
  ASSERT_TRUE(game.RunUntil(IsRefused, UINT64_MAX));
  EXPECT_THAT(game.stats().refusal, HasSubstr("TOKEN_REFUSED"));
  const std::string session = game.stats().session_id;
  std::filesystem::rename(MakeToken("second", "--role ingest"), file);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.connection_count == 2; },
                            UINT64_MAX));
  EXPECT_NE(game.stats().session_id, session) << "the old session belongs to the first token";
}

TEST_F(TokenTest, AMissingTokenFileIsLoggedWithTheEffectOfANewOne) {
  MakeToken("game", "--role ingest");
  DaemonProcess daemon(data_.path());
  const std::filesystem::path tokens = data_.path() / "tokens.db";
  std::filesystem::remove(tokens);
  EXPECT_TRUE(rpc::Eventually([&] {
    return daemon.log().find(
               "the token file is invalid, so the tokens read before stay in effect: " +
               tokens.string() + " is missing, but tokens") != std::string::npos;
  }));
  EXPECT_THAT(daemon.log(), HasSubstr("which invalidates the earlier ones"));
  EXPECT_EQ(daemon.Terminate(), 0);
}

TEST_F(TokenTest, AnUnusableTokenIsRefusedBeforeTheFirstConnectionAndNotShown) {
  const auto error = [](const std::string& address, const ClientToken& token) {
    SessionOptions options = FastOptions();
    options.token = token;
    const auto session = MakeDaemonSession(address, options);
    EXPECT_EQ(session.status().code(), StatusCode::kInvalidArgument);
    return session.status().message();
  };
  EXPECT_THAT(error("192.0.2.1:7433", {.file = "", .text = "secret"}),
              HasSubstr("would cross the network to 192.0.2.1:7433 in plain text"));
  EXPECT_THAT(error("127.daemon.example:7433", {.file = "", .text = "secret"}),
              HasSubstr("in plain text"));
  EXPECT_THAT(error("daemon.example:7433", {.file = "", .text = "secret"}),
              Not(HasSubstr("secret")));
  EXPECT_THAT(error("127.0.0.1:1", {.file = "", .text = "two\nsecrets"}),
              Not(HasSubstr("secrets")));
  EXPECT_THAT(error("127.0.0.1:1", {.file = "nowhere", .text = ""}),
              HasSubstr("cannot read a token from nowhere"));
  EXPECT_THAT(error("127.0.0.1:1", {.file = "nowhere", .text = "secret"}), HasSubstr("not both"));
}

// Lists posteriors with the token and returns the daemon's answer as text.
std::string Say(const std::string& address, const std::string& token) {
  const auto stub = v1::PosteriorsService::NewStub(
      grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer " + token);
  v1::ListPosteriorsResponse response;
  const grpc::Status status = stub->ListPosteriors(&context, {}, &response);
  return status.error_message() + status.error_details() + response.DebugString();
}

TEST_F(TokenTest, NoTokenAppearsInTheOutputOfTheDaemon) {
  const std::string file = MakeToken("canary", "--role ingest");
  std::string token = Content(file);
  token.pop_back();  // the line break
  const std::string secret = token.substr(token.find('_') + 1);
  ASSERT_EQ(secret.size(), 43u);
  std::vector<std::pair<std::string, std::string>> said;
  setenv("SWEEPSTAKE_CLIENT_TOKEN", token.c_str(), 1);  // the daemon inherits it, too
  {
    DaemonProcess daemon(data_.path(), "127.0.0.1:0",
                         {"--log-level", "trace", "--http", "127.0.0.1:0"});
    ScriptedGame game(daemon.address(), With(file));
    ASSERT_TRUE(game.RunUntil(IsConnected));
    said.emplace_back("a refusal of its role", Say(daemon.address(), token));
    said.emplace_back("a refusal of a token like it", Say(daemon.address(), token + "x"));
    said.emplace_back("the metrics", Get(daemon.http_port(), "/metrics").body);
    const HttpAnswer page = Exchange(
        daemon.http_port(), "GET /" + token + " HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer " +
                                token + "\r\nConnection: close\r\n\r\n");
    said.emplace_back("an HTTP answer", page.head + page.body);
    said.emplace_back("the daemon's arguments",
                      Content("/proc/" + std::to_string(daemon.pid()) + "/cmdline"));
    RunDaemonCommand("token revoke canary" + Data());
    ASSERT_TRUE(game.RunUntil(IsRefused, UINT64_MAX));
    said.emplace_back("a game's status", game.stats().refusal + game.stats().last_error);
    said.emplace_back("a refusal of a revoked token", Say(daemon.address(), token));
    game.Stop();
    EXPECT_EQ(daemon.Terminate(), 0);
    EXPECT_THAT(daemon.log(), HasSubstr("token canary was revoked by"));
  }
  said.emplace_back("the configuration", RunDaemonCommand("--print-config" + Data()));
  said.emplace_back("the list", RunDaemonCommand("token list --json" + Data()));
  unsetenv("SWEEPSTAKE_CLIENT_TOKEN");
  setenv("SWEEPSTAKE_TOKEN", token.c_str(), 1);
  said.emplace_back("an error", RunDaemonCommand("--print-config"));
  EXPECT_THAT(said.back().second, HasSubstr("SWEEPSTAKE_TOKEN"));
  unsetenv("SWEEPSTAKE_TOKEN");
  for (const auto& entry : std::filesystem::directory_iterator(data_.path()))
    said.emplace_back(entry.path().string(), Content(entry.path()));
  EXPECT_GE(said.size(), 13u);
  for (const auto& [what, text] : said) {
    EXPECT_FALSE(text.empty() && what != data_.path() / "tokens-made") << what;
    EXPECT_EQ(text.find(secret), std::string::npos) << what << ":\n" << text;
  }
}

}  // namespace
}  // namespace sweepstake::test_support
