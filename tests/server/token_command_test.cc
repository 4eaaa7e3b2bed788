#include "server/token_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "server/auth/token_store.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

namespace fs = std::filesystem;

class TokenCommandTest : public ::testing::Test {
 protected:
  // Returns what `sweepstaked token ARGUMENTS` prints, or the message of its error.
  std::string Run(std::vector<std::string> arguments) {
    CLI::App app;
    TokenCommand command;
    command.AddTo(app);
    arguments.insert(arguments.begin(), "token");
    std::reverse(arguments.begin(), arguments.end());  // CLI11 expects the words in reverse order
    std::ostringstream out;
    try {
      app.parse(arguments);
    } catch (const CLI::ParseError& error) {
      app.exit(error, out, out);
      return out.str();
    }
    notes_.str("");
    const absl::Status status = command.Run(data_, out, notes_);
    return status.ok() ? out.str() : std::string(status.message());
  }
  std::vector<auth::StoredToken> Stored() const {
    return auth::TokenStore::Open(data_ / "tokens.db").value().Load().value();
  }

  std::ostringstream notes_;  // messages of the latest command
  test_support::TemporaryDirectory directory_;
  const fs::path data_ = directory_.path() / "data";
  const fs::path file_ = directory_.path() / "game.token";
};

TEST_F(TokenCommandTest, OnlyCreatePrintsTheToken) {
  const std::string line = Run({"create", "game", "--role", "ingest", "--project", "arcade"});
  ASSERT_EQ(Stored().size(), 1u);
  EXPECT_THAT(notes_.str(), HasSubstr("token game is in " + (data_ / "tokens.db").string()));
  EXPECT_THAT(notes_.str(), Not(HasSubstr("sweepstake_")));
  EXPECT_EQ(auth::DigestOf(line.substr(0, line.size() - 1)), Stored()[0].digest);
  EXPECT_EQ(Stored()[0].request.projects, std::vector<std::string>{"arcade"});
  EXPECT_THAT(Run({"list"}), HasSubstr("game"));
  EXPECT_THAT(Run({"list"}), Not(HasSubstr("sweepstake_")));
  EXPECT_THAT(Run({"list", "--json"}), Not(HasSubstr("sweepstake_")));
  EXPECT_EQ(fs::status(data_).permissions(), fs::perms::owner_all);
}

TEST_F(TokenCommandTest, ListAndRevokeCreateNothingInADirectoryWithoutTokens) {
  for (const auto& arguments : {std::vector<std::string>{"list"}, {"revoke", "game"}}) {
    EXPECT_THAT(Run(arguments),
                HasSubstr("no directory " + data_.string() + "; name the daemon's"));
    EXPECT_FALSE(fs::exists(data_));
  }
  EXPECT_THAT(Run({"create", "game", "--role", "watch", "--out", file_}),
              HasSubstr("token game of " + data_.string()));
}

TEST_F(TokenCommandTest, ListAndRevokeCreateNothingInAForeignDirectory) {
  fs::create_directory(data_);
  std::ofstream(data_ / "letter.txt") << "Dear reader";
  for (const auto& arguments : {std::vector<std::string>{"list"}, {"revoke", "game"}}) {
    EXPECT_THAT(Run(arguments), HasSubstr("no tokens in " + data_.string()));
    EXPECT_EQ(std::distance(fs::directory_iterator(data_), {}), 1);
  }
  std::ofstream(data_ / "tokens-made") << "";
  EXPECT_THAT(Run({"list"}), Not(HasSubstr("no tokens in"))) << "they were lost";
  EXPECT_FALSE(fs::exists(data_ / "tokens.db"));
}

TEST_F(TokenCommandTest, FilesThatRootCreatesBelongToTheOwnerOfTheDirectory) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can create files of other users";
  fs::create_directory(data_);
  ASSERT_EQ(chown(data_.c_str(), 65534, 65534), 0);
  Run({"create", "game", "--role", "watch"});
  EXPECT_EQ(Stored().size(), 1u);
  for (const auto& entry : fs::directory_iterator(data_)) {
    struct stat made {};
    ASSERT_EQ(stat(entry.path().c_str(), &made), 0);
    EXPECT_EQ(made.st_uid, 65534u) << entry.path();
    EXPECT_EQ(made.st_gid, 65534u) << entry.path();
  }
}

TEST_F(TokenCommandTest, CreateWritesTheTokenToANewFileOfItsOwner) {
  EXPECT_THAT(Run({"create", "game", "--role", "watch", "--out", file_}),
              Not(HasSubstr("sweepstake_")));
  std::string token;
  std::ifstream(file_) >> token;
  EXPECT_EQ(auth::DigestOf(token), Stored()[0].digest);
  EXPECT_EQ(fs::status(file_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_THAT(Run({"create", "other", "--role", "watch", "--out", file_}),
              HasSubstr("cannot create " + file_.string()));
  EXPECT_EQ(Stored().size(), 1u) << "a failed command must not store a token";
}

TEST_F(TokenCommandTest, AFailedCreateLeavesNoFile) {
  Run({"create", "game", "--role", "watch"});
  EXPECT_THAT(Run({"create", "game", "--role", "watch", "--out", file_}),
              HasSubstr("choose another name"));
  EXPECT_FALSE(fs::exists(file_));
}

TEST_F(TokenCommandTest, RevokeStoresTheUserAndListShowsTheState) {
  Run({"create", "game", "--role", "admin", "--days", "30"});
  EXPECT_THAT(Run({"list"}), HasSubstr("admin     valid"));
  EXPECT_THAT(Run({"revoke", "game"}), HasSubstr("game: revoked"));
  const auth::StoredToken token = Stored()[0];
  EXPECT_TRUE(token.revoked_unix_s);
  EXPECT_EQ(token.revoked_by, token.request.made_by);
  EXPECT_FALSE(token.revoked_by.empty());
  EXPECT_EQ(*token.request.expires_unix_s - token.created_unix_s, 30 * 86'400);
  EXPECT_THAT(Run({"list", "--json"}), HasSubstr("\"state\": \"revoked\""));
  EXPECT_THAT(Run({"revoke", "gane"}), HasSubstr("there is no token with the name gane"));
}

TEST_F(TokenCommandTest, MissingAndUnknownArgumentsAreErrors) {
  EXPECT_THAT(Run({"create", "game"}), HasSubstr("--role is required"));
  EXPECT_THAT(Run({"create", "game", "--role", "king"}), HasSubstr("king not in {player"));
  EXPECT_THAT(Run({"create", "--help"}), HasSubstr("Example: sweepstaked token create"));
  EXPECT_THAT(Run({}), HasSubstr("subcommand is required"));
}

}  // namespace
}  // namespace sweepstake::server
