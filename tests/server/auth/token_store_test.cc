#include "server/auth/token_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>

#include "tests/server/storage/without_links.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::auth {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace fs = std::filesystem;

class TokenStoreTest : public ::testing::Test {
 protected:
  TokenStore Open() {
    auto store = TokenStore::Open(path_);
    EXPECT_TRUE(store.ok()) << store.status();
    return *std::move(store);
  }
  std::string FileText() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  test_support::TemporaryDirectory directory_;
  const fs::path path_ = directory_.path() / "tokens.db";
};

TokenRequest Named(const std::string& name) {
  return {
      .name = name, .role = Role::kIngest, .projects = {}, .expires_unix_s = {}, .made_by = "me"};
}

TEST(RoleTest, AnAdminMayDoEverythingAndAnOperatorMayWatch) {
  for (const Role needed : {Role::kIngest, Role::kWatch, Role::kOperator, Role::kAdmin}) {
    EXPECT_TRUE(Includes(Role::kAdmin, needed));
    EXPECT_EQ(Includes(Role::kIngest, needed), needed == Role::kIngest);
    EXPECT_EQ(Includes(Role::kWatch, needed), needed == Role::kWatch);
    EXPECT_EQ(Includes(Role::kOperator, needed),
              needed == Role::kOperator || needed == Role::kWatch);
  }
}

TEST(PrincipalTest, ATokenWithoutProjectsMayUseAllProjects) {
  EXPECT_TRUE(Principal{}.MayUse("any"));
  const Principal scoped{.token_id = 1, .name = "a", .role = Role::kAdmin, .projects = {"x", "y"}};
  EXPECT_TRUE(scoped.MayUse("y"));
  EXPECT_FALSE(scoped.MayUse("z"));
  EXPECT_FALSE(scoped.MayUse(""));
}

TEST_F(TokenStoreTest, TheFirstTokenCanBeCreatedWithoutHardLinks) {
  const auto made = storage::WithoutLinks([&] { return Open().Create(Named("game"), 1'000).ok(); });
  if (!made) GTEST_SKIP() << "this kernel cannot disable hard links for a process";
  EXPECT_TRUE(*made);
  EXPECT_EQ(Open().Load()->size(), 1u);
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_.path()), {}), 2) << "and tokens-made";
}

TEST_F(TokenStoreTest, TheFileContainsTheDigestAndNotTheToken) {
  const auto token = Open().Create(Named("game"), 1'000);
  ASSERT_TRUE(token.ok()) << token.status();
  EXPECT_EQ(token->size(), std::string("sweepstake_").size() + 43);
  EXPECT_THAT(FileText(), HasSubstr(DigestOf(*token)));
  EXPECT_EQ(FileText().find(token->substr(11)), std::string::npos);
  EXPECT_EQ(fs::status(path_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(TokenStoreTest, EveryTokenIsDifferent) {
  TokenStore store = Open();
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i)
    tokens.insert(store.Create(Named(std::to_string(i)), 1'000).value());
  EXPECT_EQ(tokens.size(), 100u);
}

TEST_F(TokenStoreTest, LoadReturnsTheArgumentsOfCreate) {
  const TokenRequest request = {.name = "arcade",
                                .role = Role::kOperator,
                                .projects = {"arcade", "arcade 2"},
                                .expires_unix_s = 5'000,
                                .made_by = "ann"};
  const auto token = Open().Create(request, 1'000);
  const auto stored = Open().Load();
  ASSERT_EQ(stored.value().size(), 1u);
  const StoredToken& only = stored->front();
  EXPECT_EQ(only.digest, DigestOf(*token));
  EXPECT_EQ(only.request.name, "arcade");
  EXPECT_EQ(only.request.role, Role::kOperator);
  EXPECT_THAT(only.request.projects, ElementsAre("arcade", "arcade 2"));
  EXPECT_EQ(only.request.made_by, "ann");
  EXPECT_EQ(only.created_unix_s, 1'000);
  EXPECT_FALSE(only.last_used_unix_s);
  EXPECT_TRUE(only.IsValidAt(4'999));
  EXPECT_FALSE(only.IsValidAt(5'000));
}

TEST_F(TokenStoreTest, ATokenWithoutProjectsOrExpiryIsValidForAllAndForever) {
  Open().Create(Named("game"), 1'000).value();
  const StoredToken token = Open().Load().value().front();
  EXPECT_THAT(token.request.projects, IsEmpty());
  EXPECT_TRUE(token.IsValidAt(INT64_MAX));
}

TEST_F(TokenStoreTest, ARevokedTokenStaysInTheFileAndItsNameCannotBeReused) {
  TokenStore store = Open();
  store.Create(Named("game"), 1'000).value();
  EXPECT_TRUE(store.Revoke("game", "bob", 2'000).ok());
  const StoredToken token = store.Load().value().front();
  EXPECT_EQ(token.revoked_unix_s, 2'000);
  EXPECT_EQ(token.revoked_by, "bob");
  EXPECT_FALSE(token.IsValidAt(1'500));
  EXPECT_TRUE(absl::IsFailedPrecondition(store.Revoke("game", "eve", 3'000)));
  EXPECT_EQ(store.Load().value().front().revoked_by, "bob");
  EXPECT_TRUE(absl::IsAlreadyExists(store.Create(Named("game"), 4'000).status()));
  EXPECT_TRUE(absl::IsNotFound(store.Revoke("gane", "bob", 2'000)));
}

TEST_F(TokenStoreTest, InvalidNamesAndPastExpiryTimesAreRefused) {
  TokenStore store = Open();
  TokenRequest request = Named("");
  EXPECT_TRUE(absl::IsInvalidArgument(store.Create(request, 1).status()));
  request = Named("game");
  request.projects = {"two\nlines"};
  EXPECT_TRUE(absl::IsInvalidArgument(store.Create(request, 1).status()));
  request.projects = {"*"};
  EXPECT_TRUE(absl::IsInvalidArgument(store.Create(request, 1).status()));
  request.projects = {};
  request.expires_unix_s = 10;
  EXPECT_TRUE(absl::IsInvalidArgument(store.Create(request, 10).status()));
  EXPECT_THAT(store.Load().value(), IsEmpty());
}

TEST_F(TokenStoreTest, StoresTheTimeOfTheLastUse) {
  TokenStore store = Open();
  store.Create(Named("a"), 1).value();
  store.Create(Named("b"), 1).value();
  const std::vector<std::pair<int64_t, int64_t>> uses = {{2, 77}};
  EXPECT_TRUE(store.MarkUsed(uses).ok());
  EXPECT_FALSE(store.Load().value()[0].last_used_unix_s);
  EXPECT_EQ(store.Load().value()[1].last_used_unix_s, 77);
}

TEST_F(TokenStoreTest, TheVersionChangesWithWritesOfAnotherConnection) {
  TokenStore reader = Open();
  TokenStore writer = Open();
  const int64_t before = reader.Version().value();
  EXPECT_EQ(reader.Version().value(), before);
  writer.Create(Named("game"), 1).value();
  EXPECT_NE(reader.Version().value(), before);
}

TEST_F(TokenStoreTest, RefusesAndKeepsAnEmptyDamagedOrForeignFile) {
  std::ofstream(path_).close();
  EXPECT_TRUE(absl::IsDataLoss(TokenStore::Open(path_).status()));
  EXPECT_EQ(fs::file_size(path_), 0u);
  std::ofstream(path_) << "something else";
  EXPECT_TRUE(absl::IsDataLoss(TokenStore::Open(path_).status()));
  fs::remove(path_);
  Open().Create(Named("game"), 1).value();
  fs::resize_file(path_, fs::file_size(path_) - 4096);
  EXPECT_TRUE(absl::IsDataLoss(TokenStore::Open(path_).status()));
}

TEST_F(TokenStoreTest, ALostFileIsAnError) {
  EXPECT_FALSE(Open().WereMade()) << "no token was created";
  fs::remove(path_);
  ASSERT_TRUE(Open().Create(Named("game"), 1).ok());
  EXPECT_TRUE(Open().WereMade());
  fs::remove(path_);
  const absl::Status lost = TokenStore::Open(path_).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(lost)) << lost;
  const std::string note = (directory_.path() / "tokens-made").string();
  EXPECT_EQ(
      lost.message(),
      path_.string() +
          " is missing, but tokens were created earlier: restore a copy of the file; or create new "
          "tokens with `sweepstaked token create`, which invalidates the earlier ones; to "
          "run without tokens, stop the daemon and remove " +
          note);
  EXPECT_FALSE(fs::exists(path_)) << "this is where the copy belongs";
  EXPECT_TRUE(TokenStore::Open(path_, TokenStore::IfLost::kReplace).ok());
  EXPECT_THAT(std::string(Open().Lost().message()),
              ::testing::AllOf(HasSubstr(path_.string() + " contains no tokens, but"),
                               HasSubstr("remove " + path_.string() + " and " + note)));
  fs::remove(path_);
  fs::remove(directory_.path() / "tokens-made");
  EXPECT_TRUE(TokenStore::Open(path_).ok()) << "running without tokens is possible";
}

TEST_F(TokenStoreTest, AFailedFirstTokenDoesNotCountAsALostFile) {
  TokenStore store = Open();
  {
    auto other =
        storage::SqliteDatabase::Open(path_.string(), storage::SqliteDatabase::OpenMode::kExisting);
    ASSERT_TRUE(other->Begin().ok());
    EXPECT_TRUE(absl::IsUnavailable(store.Create(Named("game"), 1).status()));
  }
  EXPECT_FALSE(store.WereMade());
  EXPECT_TRUE(store.Create(Named("game"), 1).ok());
  EXPECT_TRUE(store.WereMade());
}

TEST_F(TokenStoreTest, UnfinishedFilesOfAnotherProcessAreNotTouched) {
  for (const char* name : {"tokens.db.new", "tokens.db.new-1"})
    std::ofstream(directory_.path() / name) << "half";
  Open();
  for (const char* name : {"tokens.db.new", "tokens.db.new-1"})
    EXPECT_TRUE(fs::exists(directory_.path() / name)) << name;
}

}  // namespace
}  // namespace sweepstake::auth
