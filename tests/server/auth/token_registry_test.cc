#include "server/auth/token_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>

#include "server/auth/ticket.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::auth {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class TokenRegistryTest : public ::testing::Test {
 protected:
  TokenRegistryTest() : writer_(TokenStore::Open(path_).value()) {}

  std::string Make(const std::string& name, std::optional<int64_t> expires_unix_s = std::nullopt,
                   Role role = Role::kIngest) {
    return writer_
        .Create({.name = name,
                 .role = role,
                 .projects = {"arcade"},
                 .expires_unix_s = expires_unix_s,
                 .made_by = "ann"},
                1)
        .value();
  }
  std::unique_ptr<TokenRegistry> Open() {
    TokenRegistryOptions options;
    options.interval = std::chrono::milliseconds(1);
    options.use_interval = use_interval_;
    options.unix_now_s = [this] { return now_s_.load(); };
    options.on_change = [this](const std::string& text) {
      const std::lock_guard lock(mutex_);
      changes_.push_back(text);
      changed_.notify_all();
    };
    options.on_problem = [this](const absl::Status& status) {
      const std::lock_guard lock(mutex_);
      problems_.emplace_back(status.message());
      changed_.notify_all();
    };
    return TokenRegistry::Open(path_, std::move(options)).value();
  }
  // Waits until the registry has reported `count` changes, and returns them.
  std::vector<std::string> AwaitChanges(size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return changes_.size() >= count; });
    return changes_;
  }

  std::vector<std::string> AwaitProblems(size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return problems_.size() >= count; });
    return problems_;
  }
  // Returns a copy of the current file, for a later restore.
  std::filesystem::path Copy() const {
    const std::filesystem::path copy = directory_.path() / "copy.db";
    std::filesystem::copy_file(path_, copy, std::filesystem::copy_options::overwrite_existing);
    return copy;
  }
  void TearDown() override {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(problems_.size(), expected_problem_count_);
  }

  test_support::TemporaryDirectory directory_;
  const std::filesystem::path path_ = directory_.path() / "tokens.db";
  TokenStore writer_;
  std::chrono::milliseconds use_interval_{60'000};
  std::atomic<int64_t> now_s_ = 1'000;
  size_t expected_problem_count_ = 0;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::vector<std::string> changes_;
  std::vector<std::string> problems_;
};

TEST_F(TokenRegistryTest, FindsTheHolderOfAValidTokenOnly) {
  EXPECT_TRUE(Open()->empty());
  Make("other");
  const std::string token = Make("game");
  const auto registry = Open();
  EXPECT_FALSE(registry->empty());
  const auto holder = registry->Find(token);
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->name, "game");
  EXPECT_EQ(holder->role, Role::kIngest);
  EXPECT_THAT(holder->projects, ElementsAre("arcade"));
  EXPECT_TRUE(registry->IsValid(*holder));
  Principal other = *holder;
  ++other.token_id;
  EXPECT_FALSE(registry->IsValid(other));
  EXPECT_FALSE(registry->Find(""));
  EXPECT_FALSE(registry->Find(token + "a"));
  EXPECT_FALSE(registry->Find(token.substr(1)));
  EXPECT_FALSE(registry->Find(DigestOf(token)));
}

TEST_F(TokenRegistryTest, ATicketNamesAPlayerOfItsToken) {
  const std::string token = Make("game", std::nullopt, Role::kTicket);
  const auto registry = Open();
  const auto holder = registry->Find(SignTicket(token, "alice", 2'000));
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->player, "alice");
  EXPECT_EQ(holder->role, Role::kPlayer);
  EXPECT_EQ(holder->token_id, registry->Find(token)->token_id);
  EXPECT_EQ(registry->Find(token)->player, "");
  EXPECT_THAT(holder->projects, ElementsAre("arcade"));
  EXPECT_TRUE(registry->IsValid(*holder));
  EXPECT_FALSE(registry->Find(SignTicket("sweepstake_unknown", "alice", 2'000)));
  EXPECT_FALSE(registry->Find(SignTicket(token, "alice", now_s_)));
  EXPECT_FALSE(registry->Find(SignTicket(token, "alice", now_s_ + kMaxTicketLifeS + 1)));
  EXPECT_TRUE(writer_.Revoke("game", "bob", 2'000).ok());
  while (registry->Find(SignTicket(token, "alice", 2'000))) std::this_thread::yield();
  EXPECT_FALSE(registry->IsValid(*holder));
}

TEST_F(TokenRegistryTest, OnlyTokensForTicketsSignThem) {
  for (const Role role :
       {Role::kPlayer, Role::kIngest, Role::kWatch, Role::kOperator, Role::kAdmin}) {
    const std::string token = Make(std::string(NameOf(role)), std::nullopt, role);
    EXPECT_FALSE(Open()->Find(SignTicket(token, "alice", 2'000)));
  }
}

TEST_F(TokenRegistryTest, ATokenEndsWhenItExpires) {
  const std::string token = Make("game", 1'500);
  const auto registry = Open();
  const auto holder = registry->Find(token);
  ASSERT_TRUE(holder);
  now_s_ = 1'500;
  EXPECT_FALSE(registry->Find(token));
  EXPECT_FALSE(registry->IsValid(*holder));
  EXPECT_FALSE(registry->empty()) << "calls still need a token";
}

TEST_F(TokenRegistryTest, DetectsAndReportsChangesByTheTokenCommand) {
  const auto registry = Open();
  const std::string token = Make("game");
  EXPECT_THAT(AwaitChanges(1), ElementsAre(HasSubstr("game was created by ann, role ingest")));
  // A change is reported just before it takes effect.
  while (!registry->Find(token)) std::this_thread::yield();
  const Principal holder = registry->Find(token).value();
  EXPECT_TRUE(writer_.Revoke("game", "bob", 2'000).ok());
  EXPECT_THAT(AwaitChanges(2)[1], HasSubstr("game was revoked by bob"));
  while (registry->Find(token)) std::this_thread::yield();
  EXPECT_FALSE(registry->IsValid(holder));
  EXPECT_FALSE(registry->empty());
}

TEST_F(TokenRegistryTest, DetectsARevocationInACopyThatReplacedTheFile) {
  const std::string token = Make("game");
  const auto registry = Open();
  std::filesystem::rename(Copy(), path_);
  EXPECT_TRUE(TokenStore::Open(path_)->Revoke("game", "bob", 2'000).ok());
  EXPECT_THAT(AwaitChanges(1), ElementsAre(HasSubstr("game was revoked by bob")));
  while (registry->Find(token)) std::this_thread::yield();
}

TEST_F(TokenRegistryTest, AMissingFileIsReportedOnceAndItsTokensStayValid) {
  expected_problem_count_ = 1;
  const std::string token = Make("game");
  const auto registry = Open();
  const std::filesystem::path copy = Copy();
  std::filesystem::remove(path_);
  EXPECT_THAT(AwaitProblems(1), ElementsAre(HasSubstr("restore a copy of the file")));
  EXPECT_TRUE(registry->Find(token));
  std::filesystem::rename(copy, path_);
  EXPECT_TRUE(TokenStore::Open(path_)->Revoke("game", "bob", 2'000).ok());
  while (registry->Find(token)) std::this_thread::yield();
}

TEST_F(TokenRegistryTest, ATokenWithTheSameIdInAnotherFileIsAnotherToken) {
  const std::string token = Make("game");
  const auto registry = Open();
  const Principal holder = registry->Find(token).value();
  test_support::TemporaryDirectory elsewhere;
  const auto other = elsewhere.path() / "tokens.db";
  TokenRequest request;
  request.name = "game";
  request.made_by = "eve";
  const std::string new_token = TokenStore::Open(other)->Create(request, 1).value();
  std::filesystem::rename(other, path_);
  EXPECT_THAT(AwaitChanges(2), ElementsAre(HasSubstr("game was removed from the file"),
                                           HasSubstr("game was created by eve")));
  while (!registry->Find(new_token)) std::this_thread::yield();
  EXPECT_FALSE(registry->Find(token));
  EXPECT_FALSE(registry->IsValid(holder)) << "this ends its streams";
}

TEST_F(TokenRegistryTest, ReplacingTheFileByOneWithoutTokensGrantsNoAccess) {
  expected_problem_count_ = 1;
  const std::string token = Make("game");
  const auto registry = Open();
  std::filesystem::remove(directory_.path() / "tokens-made");
  test_support::TemporaryDirectory elsewhere;
  const auto other = elsewhere.path() / "tokens.db";
  ASSERT_TRUE(TokenStore::Open(other).ok());
  std::filesystem::rename(other, path_);
  EXPECT_THAT(AwaitProblems(1), ElementsAre(HasSubstr("contains no tokens, but")));
  EXPECT_FALSE(registry->empty());
  EXPECT_TRUE(registry->Find(token));
}

TEST_F(TokenRegistryTest, StoresTheLastUseAtShutdownAndEarlierUsesPeriodically) {
  const std::string token = Make("game");
  {
    const auto registry = Open();
    EXPECT_TRUE(registry->Find(token));
  }
  EXPECT_EQ(writer_.Load().value()[0].last_used_unix_s, 1'000);
  now_s_ = 2'000;
  use_interval_ = std::chrono::milliseconds(0);
  const auto registry = Open();
  EXPECT_TRUE(registry->Find(token));
  while (writer_.Load().value()[0].last_used_unix_s != 2'000) std::this_thread::yield();
}

TEST_F(TokenRegistryTest, AnEmptyFileThatReplacedOneWithTokensIsRefused) {
  Make("game");
  std::filesystem::remove(path_);
  EXPECT_TRUE(TokenStore::Open(path_, TokenStore::IfLost::kReplace).ok());
  const auto refused = TokenRegistry::Open(path_, {});
  EXPECT_TRUE(absl::IsFailedPrecondition(refused.status())) << refused.status();
}

TEST_F(TokenRegistryTest, FindsEachOfManyTokens) {
  std::vector<std::string> tokens;
  for (int i = 0; i < 100; ++i) tokens.push_back(Make("game " + std::to_string(i)));
  const auto registry = Open();
  for (size_t i = 0; i < tokens.size(); ++i) {
    const auto holder = registry->Find(tokens[i]);
    ASSERT_TRUE(holder);
    EXPECT_EQ(holder->name, "game " + std::to_string(i));
  }
}

}  // namespace
}  // namespace sweepstake::auth
