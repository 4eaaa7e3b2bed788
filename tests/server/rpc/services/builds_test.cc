// What builds were made from: who says it, what is refused, and who sees it.
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class BuildsTest : public RpcTest {
 protected:
  BuildsTest() {
    options_.tokens = &tokens_;
    tokens_.Add("all", auth::Role::kOperator);
    tokens_.Add("mine", auth::Role::kOperator, {"game"});
    tokens_.Add("reader", auth::Role::kWatch);
  }

  static v1::Build Build(const std::string& name, const std::vector<std::string>& parents,
                         const std::string& project = "game") {
    v1::Build build;
    build.set_project(project);
    build.set_name(name);
    build.mutable_parents()->Assign(parents.begin(), parents.end());
    return build;
  }
  grpc::Status Describe(const std::vector<v1::Build>& builds, const std::string& name = "all",
                        bool forget = false) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + name + "-token");
    v1::DescribeBuildsRequest request;
    request.mutable_builds()->Assign(builds.begin(), builds.end());
    request.set_forget(forget);
    v1::DescribeBuildsResponse response;
    return v1::PriorsService::NewStub(channel_)->DescribeBuilds(&context, request, &response);
  }
  std::vector<std::string> Listed(const std::string& project = "",
                                  const std::string& name = "all") {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + name + "-token");
    v1::ListBuildsRequest request;
    request.set_project(project);
    const auto reader = v1::PriorsService::NewStub(channel_)->ListBuilds(&context, request);
    std::vector<std::string> builds;
    for (v1::ListBuildsResponse part; reader->Read(&part);) {
      for (const v1::Build& build : part.builds()) {
        std::string text = build.project() + " " + build.name() + ":";
        for (const std::string& parent : build.parents()) text += " " + parent;
        builds.push_back(text);
      }
    }
    status_ = reader->Finish();
    return builds;
  }

  ScriptedTokens tokens_;
  grpc::Status status_;
};

TEST_F(BuildsTest, AreListedAsWasSaidOfThemEachParentOnce) {
  ASSERT_TRUE(Describe({Build("1.1", {"1.0", "fix", "1.0"}), Build("1.0", {}, "other")}).ok());
  EXPECT_THAT(Listed(), ElementsAre("game 1.1: 1.0 fix", "other 1.0:"));
  EXPECT_THAT(Listed("other"), ElementsAre("other 1.0:"));
  EXPECT_THAT(Listed("", "mine"), ElementsAre("game 1.1: 1.0 fix"));
  EXPECT_TRUE(status_.ok());
  EXPECT_THAT(Listed("other", "mine"), IsEmpty());
  EXPECT_EQ(ReasonOf(status_), v1::ERROR_REASON_NOT_ALLOWED);
}

TEST_F(BuildsTest, MoreThanAMessageHoldsComeInSeveral) {
  std::vector<v1::Build> builds(16);
  for (int i = 0; i < 208; ++i) {
    builds[static_cast<size_t>(i % 16)] = Build("a" + std::to_string(i), {});
    if (i % 16 < 15) continue;
    ASSERT_TRUE(Describe(builds).ok());
  }
  ASSERT_TRUE(Describe({Build("b", {"a1"})}).ok());
  const auto listed = Listed();
  ASSERT_EQ(listed.size(), 209u);
  EXPECT_EQ(listed.back(), "game b: a1");
}

TEST_F(BuildsTest, WhatARequestSaysIsOneRowOfTheLog) {
  ASSERT_TRUE(Describe({Build("1.1", {"1.0", "a, b"}), Build("1.0", {})}).ok());
  ASSERT_TRUE(Eventually([&] { return !AdminRows().empty(); }));
  ASSERT_TRUE(Describe({Build("1.1", {})}, "all", /*forget=*/true).ok());
  ASSERT_TRUE(Eventually([&] { return AdminRows().size() > 1; }));
  const std::vector<std::string> rows = AdminRows();
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_THAT(rows[0], HasSubstr("action=describe-builds {"));
  EXPECT_THAT(rows[0], HasSubstr("a\\, b"));
  EXPECT_THAT(rows[0], HasSubstr("1.0"));
  EXPECT_THAT(rows[1], HasSubstr("forget"));
}

TEST_F(BuildsTest, WhatIsForgottenIsNotListed) {
  ASSERT_TRUE(Describe({Build("1.1", {"1.0"}), Build("1.O", {})}).ok());
  ASSERT_TRUE(Describe({Build("1.O", {})}, "all", /*forget=*/true).ok());
  EXPECT_THAT(Listed(), ElementsAre("game 1.1: 1.0"));
  EXPECT_EQ(ReasonOf(Describe({Build("1.1", {})}, "reader", /*forget=*/true)),
            v1::ERROR_REASON_NOT_ALLOWED);
}

TEST_F(BuildsTest, OnlyAnOperatorOfTheProjectSaysIt) {
  EXPECT_EQ(ReasonOf(Describe({Build("1.1", {})}, "reader")), v1::ERROR_REASON_NOT_ALLOWED);
  EXPECT_EQ(ReasonOf(Describe({Build("1.1", {}), Build("1.1", {}, "theirs")}, "mine")),
            v1::ERROR_REASON_NOT_ALLOWED);
  EXPECT_THAT(Listed(), IsEmpty());
}

TEST_F(BuildsTest, WhatIsNoBuildIsNamedAndChangesNothing) {
  v1::Build far = Build("1.1", {});
  far.set_unix_made_s(1'760'000'000'000);  // in milliseconds
  const std::pair<v1::Build, const char*> cases[] = {
      {Build("", {}), "name"},
      {Build("1.1", {}, ""), "project"},
      {Build("1.1", {std::string(129, 'a')}), "parents"},
      {Build("1.1", {"1.1"}), "its own parent"},
      {far, "before the year 10000"},
      {Build("1.1", {"1", "2", "3", "4", "5", "6", "7", "8", "9"}), "at most 8"}};
  for (const auto& [build, said] : cases) {
    const grpc::Status status = Describe({Build("1.0", {}), build});
    EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_INVALID_MESSAGE);
    EXPECT_THAT(status.error_message(), HasSubstr("build 2 of 2: "));
    EXPECT_THAT(status.error_message(), HasSubstr(said));
  }
  EXPECT_EQ(ReasonOf(Describe(std::vector<v1::Build>(17, Build("1.0", {})))),
            v1::ERROR_REASON_INVALID_MESSAGE);
  EXPECT_THAT(Listed(), IsEmpty());
}

}  // namespace
}  // namespace sweepstake::rpc
