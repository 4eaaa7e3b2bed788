// Tests tokens: which calls are allowed, which projects a token shows, and which token may resume a
// session.
#include <functional>

#include "engine_client/telemetry/daemon_channel.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/sessions/manual_clock.h"

namespace sweepstake::rpc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class AccessTest : public RpcTest {
 protected:
  AccessTest() {
    options_.tokens = &tokens_;
    tokens_.Add("game", auth::Role::kIngest, {"game"});
    tokens_.Add("other", auth::Role::kIngest, {"game"});
    tokens_.Add("all", auth::Role::kAdmin);
    tokens_.Add("mine", auth::Role::kOperator, {"game", "mine"});
  }

  // Stores evidence about one scene of each project.
  void Learn(const std::vector<std::string>& projects) {
    for (const std::string& project : projects) {
      v1::Hello hello = OneArmHello();
      hello.set_project(project);
      TelemetryClient client(channel_, "all-token");
      client.Open(hello);
      client.Send(Frames(1, 30));
      ASSERT_TRUE(Applied(++learnt_));
      Tick();
      client.AwaitAcknowledgement(1);
    }
  }
  static std::unique_ptr<grpc::ClientContext> With(const std::string& authorization) {
    auto context = std::make_unique<grpc::ClientContext>();
    context->AddMetadata("authorization", authorization);
    return context;
  }
  static std::unique_ptr<grpc::ClientContext> Mine() { return With("Bearer mine-token"); }
  grpc::Status List(const std::string& token, const std::string& project = "") {
    v1::ListPosteriorsRequest request;
    request.set_project(project);
    listed_.Clear();
    const auto context = With("Bearer " + token);
    return posteriors()->ListPosteriors(context.get(), request, &listed_);
  }
  grpc::Status Import(const std::vector<std::string>& projects) {
    const auto stub = v1::PriorsService::NewStub(channel_);
    const auto context = Mine();
    v1::ImportPriorsResponse response;
    const auto writer = stub->ImportPriors(context.get(), &response);
    writer->Write(ImportOf(projects));
    writer->WritesDone();
    return writer->Finish();
  }
  // Returns one record per project.
  static v1::ImportPriorsRequest ImportOf(const std::vector<std::string>& projects) {
    v1::ImportPriorsRequest request;
    for (const std::string& project : projects) {
      v1::PriorRecord& record = *request.add_records();
      record.set_project(project);
      record.set_scene("imported");
      record.set_arm("Grid");
      record.set_backend_version(1);
      record.set_reward_version(1);
      record.set_source_id("elsewhere");
      record.set_source_sequence(1);
      record.set_alpha_increment(1);
    }
    return request;
  }
  std::unique_ptr<v1::PosteriorsService::Stub> posteriors() {
    return v1::PosteriorsService::NewStub(channel_);
  }
  // Returns the status with which a stream ends after its Hello.
  grpc::Status Refusal(const v1::Hello& hello, const std::string& token) {
    TelemetryClient client(channel_, token);
    client.Send(Request(hello));
    return client.Finish();
  }

  ScriptedTokens tokens_;
  uint64_t learnt_ = 0;
  v1::ListPosteriorsResponse listed_;
};

template <typename Rows>
std::vector<std::string> Projects(const Rows& rows) {
  std::vector<std::string> projects;
  for (const auto& row : rows) projects.push_back(row.project());
  return projects;
}

TEST_F(AccessTest, AListingAnExportAndTheAuditLogShowTheTokensProjectsOnly) {
  Learn({"game", "mine", "theirs"});
  EXPECT_TRUE(List("all-token").ok());
  EXPECT_THAT(Projects(listed_.scenes()), ElementsAre("game", "mine", "theirs"));
  EXPECT_TRUE(List("mine-token").ok());
  EXPECT_THAT(Projects(listed_.scenes()), ElementsAre("game", "mine"));
  EXPECT_TRUE(List("mine-token", "mine").ok());
  EXPECT_THAT(Projects(listed_.scenes()), ElementsAre("mine"));

  auto context = Mine();
  const auto priors = v1::PriorsService::NewStub(channel_);
  const auto records = priors->ExportPriors(context.get(), {});
  v1::ExportPriorsResponse exported;
  ASSERT_TRUE(records->Read(&exported));
  EXPECT_THAT(Projects(exported.records()), ElementsAre("game", "mine"));

  context = Mine();
  const auto audit = v1::AuditService::NewStub(channel_);
  const auto segments = audit->ListAuditSegments(context.get(), {});
  v1::ListAuditSegmentsResponse page;
  ASSERT_TRUE(segments->Read(&page));
  EXPECT_THAT(Projects(page.segments()), ElementsAre("game", "mine"));

  const auto row_context = Mine();
  const auto rows = audit->ExportDecisions(row_context.get(), {});
  std::string text;
  for (v1::ExportDecisionsResponse part; rows->Read(&part);) {
    for (const v1::AuditRow& row : part.rows()) text += row.ShortDebugString();
  }
  v1::ListDecisionsResponse list;
  const auto list_context = Mine();
  ASSERT_TRUE(audit->ListDecisions(list_context.get(), {}, &list).ok());
  for (const std::string& read : {text, list.ShortDebugString()}) {
    EXPECT_THAT(read, HasSubstr("mine"));
    EXPECT_THAT(read, ::testing::Not(HasSubstr("theirs")));
  }
}

TEST_F(AccessTest, TheAuditLogNamesPartiesToThoseWhoMayRevokeThem) {
  tokens_.Add("ann", auth::Role::kWatch);
  Learn({"game"});
  const auto audit = v1::AuditService::NewStub(channel_);
  const auto token_of_session = [&](const std::string& reader) {
    const auto context = With("Bearer " + reader);
    const auto segments = audit->ListAuditSegments(context.get(), {});
    v1::ListAuditSegmentsResponse page;
    EXPECT_TRUE(segments->Read(&page));
    return page.segments(0).token_id();
  };
  EXPECT_GT(token_of_session("mine-token"), 0);
  EXPECT_EQ(token_of_session("ann-token"), 0);
}

// Returns the message without the project's name, which it must contain.
std::string WithoutName(std::string message, const std::string& project) {
  const size_t place = message.find(project);
  EXPECT_NE(place, std::string::npos) << message;
  return place == std::string::npos ? message : message.erase(place, project.size());
}

TEST_F(AccessTest, AnotherProjectIsDeniedWhetherItExistsOrNot) {
  Learn({"theirs"});
  std::set<std::string> answers;
  for (const char* project : {"theirs", "nobodys"}) {
    answers.insert(WithoutName(List("mine-token", project).error_message(), project));
    v1::GetPosteriorRequest request;
    request.set_project(project);
    request.set_scene("harbour");
    v1::GetPosteriorResponse response;
    const grpc::Status status = posteriors()->GetPosterior(Mine().get(), request, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
    EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_NOT_ALLOWED);
    answers.insert(WithoutName(status.error_message(), project));
    v1::Hello hello = OneArmHello();
    hello.set_project(project);
    const grpc::Status refusal = Refusal(hello, "game-token");
    EXPECT_EQ(refusal.error_code(), grpc::StatusCode::PERMISSION_DENIED);
    answers.insert(WithoutName(refusal.error_message(), project));
    v1::WatchPosteriorsRequest watch;
    watch.set_project(project);
    answers.insert(WithoutName(
        posteriors()->WatchPosteriors(Mine().get(), watch)->Finish().error_message(), project));
  }
  EXPECT_EQ(answers.size(), 1u) << ::testing::PrintToString(answers);
}

TEST_F(AccessTest, RefusalsForAnotherProjectAreLoggedForEveryCall) {
  const auto audit = v1::AuditService::NewStub(channel_);
  const auto priors = v1::PriorsService::NewStub(channel_);
  const auto sessions = v1::SessionsService::NewStub(channel_);
  const auto ask = [&](auto request, auto call) {
    if constexpr (requires { request.mutable_filter(); }) {
      request.mutable_filter()->set_project("theirs");
    } else {
      request.set_project("theirs");
    }
    return call(Mine().get(), request);
  };
  const std::function<grpc::Status()> calls[] = {
      [&] { return List("mine-token", "theirs"); },
      [&] {
        return ask(v1::GetPosteriorRequest(), [&](auto* context, const auto& request) {
          v1::GetPosteriorResponse response;
          return posteriors()->GetPosterior(context, request, &response);
        });
      },
      [&] {
        return ask(v1::ListSessionsRequest(), [&](auto* context, const auto& request) {
          v1::ListSessionsResponse response;
          return sessions->ListSessions(context, request, &response);
        });
      },
      [&] {
        return ask(v1::ListDecisionsRequest(), [&](auto* context, const auto& request) {
          v1::ListDecisionsResponse response;
          return audit->ListDecisions(context, request, &response);
        });
      },
      [&] {
        return ask(v1::ExportDecisionsRequest(), [&](auto* context, const auto& request) {
          return audit->ExportDecisions(context, request)->Finish();
        });
      },
      [&] {
        return ask(v1::ListAuditSegmentsRequest(), [&](auto* context, const auto& request) {
          return audit->ListAuditSegments(context, request)->Finish();
        });
      },
      [&] {
        return ask(v1::ExportPriorsRequest(), [&](auto* context, const auto& request) {
          return priors->ExportPriors(context, request)->Finish();
        });
      },
      [&] {
        return ask(v1::CompareBuildsRequest(), [&](auto* context, const auto& request) {
          return priors->CompareBuilds(context, request)->Finish();
        });
      },
      [&] { return Import({"theirs"}); },
      [&] {
        v1::RevokePriorsRequest request;
        request.mutable_sources()->set_build("1.0");
        request.mutable_sources()->set_project("theirs");
        v1::RevokePriorsResponse response;
        return priors->RevokePriors(Mine().get(), request, &response);
      },
      [&] {
        v1::PromotePriorsRequest request;
        request.mutable_sources()->set_project("theirs");
        v1::PromotePriorsResponse response;
        return priors->PromotePriors(Mine().get(), request, &response);
      },
  };
  for (const auto& call : calls) {
    logged_->Clear();
    EXPECT_EQ(ReasonOf(call()), v1::ERROR_REASON_NOT_ALLOWED);
    EXPECT_THAT(logged_->text(),
                HasSubstr("(NOT_ALLOWED): this token is not valid for the project theirs"))
        << "call " << &call - calls;
    clock_.Advance(RefusalLog::kIntervalNs);
  }
}

TEST_F(AccessTest, AWatcherReceivesTheTokensProjectsOnly) {
  Learn({"theirs", "mine"});
  const auto context = Mine();
  const auto stub = posteriors();
  const auto watch = stub->WatchPosteriors(context.get(), {});
  v1::WatchPosteriorsResponse event;
  ASSERT_TRUE(watch->Read(&event));
  EXPECT_EQ(event.posterior().project(), "mine");
  Learn({"theirs", "mine"});
  clock_.Advance(events::EventBus::kIntervalNs);
  while (watch->Read(&event) && event.decisions().empty()) continue;
  ASSERT_EQ(event.decisions_size(), 1);
  EXPECT_EQ(event.decisions(0).project(), "mine");
  context->TryCancel();
}

TEST_F(AccessTest, AnImportForAnotherProjectImportsNothing) {
  EXPECT_EQ(Import({"mine", "theirs"}).error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_TRUE(List("all-token").ok());
  EXPECT_THAT(Projects(listed_.scenes()), IsEmpty());
}

TEST_F(AccessTest, TheLogNamesTheImporter) {
  EXPECT_TRUE(Import({"mine", "game"}).ok());
  EXPECT_THAT(logged_->text(), HasSubstr("token mine imported 2 records, 2 of them new or newer"));
}

TEST_F(AccessTest, ARefusedCallIsLogged) {
  EXPECT_FALSE(List("unknown").ok());
  EXPECT_FALSE(List("game-token").ok());
  grpc::ClientContext none;
  v1::ListPosteriorsResponse response;
  EXPECT_THAT(posteriors()->ListPosteriors(&none, {}, &response).error_message(),
              HasSubstr("--token-file"));
  for (const char* reason : {"TOKEN_REFUSED", "NOT_ALLOWED", "TOKEN_MISSING"})
    EXPECT_THAT(logged_->text(), HasSubstr(reason));
  EXPECT_THAT(logged_->text(), HasSubstr("refused ipv4:127.0.0.1:"));
}

TEST_F(AccessTest, OnlyTheTokenThatBeganASessionCanResumeIt) {
  v1::Hello hello = OneArmHello();
  v1::Welcome first;
  {
    TelemetryClient client(channel_, "game-token");
    first = LearnOneWindow(client, hello);
  }
  Resume(hello, first);
  for (int round = 0; round < 2; ++round) {
    const grpc::Status stolen = Refusal(hello, "other-token");
    EXPECT_EQ(stolen.error_code(), grpc::StatusCode::PERMISSION_DENIED);
    EXPECT_EQ(ReasonOf(stolen), v1::ERROR_REASON_FOREIGN_SESSION);
    {
      TelemetryClient client(channel_, "game-token");
      const v1::Welcome again = client.Open(hello);
      EXPECT_TRUE(again.resumed());
      EXPECT_EQ(again.session_id(), first.session_id());
    }
    RestartServer();  // then the session is loaded from the store
  }
}

TEST_F(AccessTest, AnIdWithoutItsResumeTokenRevealsNothingAboutItsSession) {
  v1::Hello hello = OneArmHello();
  TelemetryClient owner(channel_, "game-token");
  Resume(hello, owner.Open(hello));
  std::string& token = *hello.mutable_resume_token();
  const std::string suffix = token.substr(32);
  ASSERT_EQ(suffix, "/1");
  for (const std::string& forged :
       {std::string(), std::string(32, 'x'), std::string(32, 'x') + "/2", token.substr(0, 32),
        token.substr(0, 32) + "/2", token + "x", token.substr(0, 32) + "1"}) {
    hello.set_resume_token(forged);
    TelemetryClient thief(channel_, "other-token");
    EXPECT_FALSE(thief.Open(hello).resumed()) << "a new session, as for an unknown id";
  }
}

TEST_F(AccessTest, TheStreamsOfARevokedTokenEnd) {
  TelemetryClient client(channel_, "game-token");
  client.Open(OneArmHello());
  TelemetryClient other(channel_, "other-token");
  other.Open(OneArmHello());
  const auto context = Mine();
  const auto stub = posteriors();
  const auto watch = stub->WatchPosteriors(context.get(), {});
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 1; }));
  tokens_.Revoke("game");
  tokens_.Revoke("mine");
  clock_.Advance(kSecondNs);
  EXPECT_EQ(ReasonOf(client.Finish()), v1::ERROR_REASON_TOKEN_REFUSED);
  v1::WatchPosteriorsResponse event;
  while (watch->Read(&event)) continue;
  EXPECT_EQ(watch->Finish().error_code(), grpc::StatusCode::UNAUTHENTICATED);
  other.Send(Goodbye());
  EXPECT_TRUE(other.Finish().ok()) << "the stream of another token";
}

TEST_F(AccessTest, AnImportWhoseTokenIsRevokedMeanwhileImportsNothing) {
  const auto stub = v1::PriorsService::NewStub(channel_);
  const auto context = Mine();
  v1::ImportPriorsResponse response;
  const auto writer = stub->ImportPriors(context.get(), &response);
  writer->Write(ImportOf({"mine"}));
  tokens_.Revoke("mine");
  writer->WritesDone();
  EXPECT_EQ(ReasonOf(writer->Finish()), v1::ERROR_REASON_TOKEN_REFUSED);
  ASSERT_TRUE(List("all-token").ok());
  EXPECT_EQ(listed_.scenes_size(), 0);
}

TEST_F(AccessTest, AnImportWhoseTokenIsRevokedAfterItsLastMessageIsRefused) {
  const auto stub = v1::PriorsService::NewStub(channel_);
  const auto context = Mine();
  v1::ImportPriorsResponse response;
  const auto writer = stub->ImportPriors(context.get(), &response);
  ASSERT_TRUE(Eventually([&] { return tokens_.CheckCount("mine") == 1; }))
      << "the import waits for a message or its end";
  tokens_.Revoke("mine");
  writer->WritesDone();
  EXPECT_EQ(ReasonOf(writer->Finish()), v1::ERROR_REASON_TOKEN_REFUSED);
}

TEST_F(AccessTest, AnImportWhoseTokenIsRevokedEndsEvenIfItsClientContinues) {
  const auto stub = v1::PriorsService::NewStub(channel_);
  const auto context = Mine();
  v1::ImportPriorsResponse response;
  const auto writer = stub->ImportPriors(context.get(), &response);
  writer->Write(ImportOf({"mine"}));
  tokens_.Revoke("mine");
  writer->Write(ImportOf({"game"}));
  EXPECT_EQ(ReasonOf(writer->Finish()), v1::ERROR_REASON_TOKEN_REFUSED);
}

TEST_F(AccessTest, AnExportWhoseTokenIsRevokedMeanwhileSendsNoFurtherPage) {
  std::vector<priors::PriorRecord> records(3 * kRecordsPerMessage);
  for (size_t i = 0; i < records.size(); ++i) {
    records[i].key.project = "mine";
    records[i].key.scene = "harbour";
    records[i].key.arm = "Grid";
    records[i].source_id = "source " + std::to_string(i);
    records[i].source_sequence = 1;
    records[i].evidence.alpha = 1;
  }
  Put(records);
  std::promise<void> release;
  thread_.Submit([&](priors::PriorStore&) { release.get_future().wait(); });
  const size_t before = store_.submit_count();
  const auto context = Mine();
  const auto stub = v1::PriorsService::NewStub(channel_);
  const auto reader = stub->ExportPriors(context.get(), {});
  EXPECT_TRUE(Eventually([&] { return store_.submit_count() == before + 1; }));
  tokens_.Revoke("mine");
  release.set_value();
  size_t count = 0;
  for (v1::ExportPriorsResponse part; reader->Read(&part);)
    count += static_cast<size_t>(part.records_size());
  EXPECT_EQ(ReasonOf(reader->Finish()), v1::ERROR_REASON_TOKEN_REFUSED);
  EXPECT_EQ(count, 0u) << "not even the page that was being read is sent";
}

class SessionQuotaTest : public AccessTest {
 protected:
  SessionQuotaTest() { options_.max_sessions_per_party = 2; }
};

TEST_F(SessionQuotaTest, ATokenHasLimitedSessionsAndALostOneMakesRoom) {
  TelemetryClient first(channel_, "game-token");
  first.Open(OneArmHello());
  auto second = std::make_unique<TelemetryClient>(channel_, "game-token");
  second->Open(OneArmHello());
  const grpc::Status status = Refusal(OneArmHello(), "game-token");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_TOO_MANY_SESSIONS);
  TelemetryClient other(channel_, "other-token");
  other.Open(OneArmHello());
  second.reset();
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_stream_count == 2; }));
  TelemetryClient third(channel_, "game-token");
  third.Open(OneArmHello());
}

// The memory of a session grows with its arms.
TEST_F(SessionQuotaTest, ASessionCountsOncePerEightArms) {
  v1::Hello hello = OneArmHello();
  while (hello.arms_size() < 9) {
    *hello.add_arms() = hello.arms(0);
    hello.mutable_arms(hello.arms_size() - 1)->set_name("arm " + std::to_string(hello.arms_size()));
  }
  TelemetryClient large(channel_, "game-token");
  large.Open(hello);
  EXPECT_EQ(ReasonOf(Refusal(OneArmHello(), "game-token")), v1::ERROR_REASON_TOO_MANY_SESSIONS);
  EXPECT_EQ(server_->counters().session_count, 1u);
  hello.mutable_arms()->DeleteSubrange(0, 1);
  TelemetryClient other(channel_, "other-token");
  other.Open(hello);
  TelemetryClient second(channel_, "other-token");
  second.Open(hello);
}

TEST_F(AccessTest, GuessingTokensIsSlowedDownAndValidTokensAreAccepted) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(ReasonOf(List("guess-" + std::to_string(i))), v1::ERROR_REASON_TOKEN_REFUSED);
  }
  for (int i = 0; i < 10; ++i) {
    const grpc::Status status = List("guess-" + std::to_string(i));
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_TOO_MANY_FAILURES);
  }
  EXPECT_TRUE(List("all-token").ok()) << "from the same address";
  clock_.Advance(auth::FailureLimit::kIntervalNs);
  EXPECT_EQ(ReasonOf(List("guess")), v1::ERROR_REASON_TOKEN_REFUSED);
}

TEST_F(AccessTest, ExactlyOneBearerTokenIsAccepted) {
  v1::ListPosteriorsResponse response;
  for (const char* wrong : {"", "Bearer", "Bearer ", "Basic all-token", "all-token"}) {
    const auto context = With(wrong);
    EXPECT_EQ(posteriors()->ListPosteriors(context.get(), {}, &response).error_code(),
              grpc::StatusCode::UNAUTHENTICATED)
        << wrong;
  }
  const auto twice = With("Bearer all-token");
  twice->AddMetadata("authorization", "Bearer all-token");
  EXPECT_EQ(ReasonOf(posteriors()->ListPosteriors(twice.get(), {}, &response)),
            v1::ERROR_REASON_TOKEN_MISSING);
  const auto lower = With("bearer all-token");
  EXPECT_TRUE(posteriors()->ListPosteriors(lower.get(), {}, &response).ok());
}

TEST_F(AccessTest, EveryCallNeedsATokenOnceATokenExists) {
  StopServer();
  ScriptedTokens tokens;
  options_.tokens = &tokens;
  StartServer();
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  v1::ListPosteriorsResponse response;
  grpc::ClientContext before;
  EXPECT_TRUE(posteriors()->ListPosteriors(&before, {}, &response).ok());
  tokens.Add("first", auth::Role::kAdmin);
  clock_.Advance(kSecondNs);
  EXPECT_EQ(client.Finish().error_code(), grpc::StatusCode::UNAUTHENTICATED);
  grpc::ClientContext after;
  EXPECT_EQ(posteriors()->ListPosteriors(&after, {}, &response).error_code(),
            grpc::StatusCode::UNAUTHENTICATED);
  StopServer();
}

TEST_F(AccessTest, FailuresOverHttpAreCountedForTheAddressOfTheBrowser) {
  const auto list = [this](const std::string& peer) {
    absl::Status end;
    EXPECT_TRUE(server_->CallOverHttp({.request = std::make_shared<v1::ListPosteriorsRequest>(),
                                       .peer = peer,
                                       .on_response = {},
                                       .on_end = [&end](const auto& status) { end = status; }},
                                      "guess"));
    return ReasonOfRefusal(end);
  };
  for (uint32_t i = 0; i < auth::FailureLimit::kMaxFailures; ++i)
    EXPECT_EQ(list("ipv4:192.0.2.7:1"), v1::ERROR_REASON_TOKEN_REFUSED);
  EXPECT_EQ(list("ipv4:192.0.2.7:2"), v1::ERROR_REASON_TOO_MANY_FAILURES);
  EXPECT_EQ(list("ipv4:192.0.2.8:1"), v1::ERROR_REASON_TOKEN_REFUSED)
      << "other addresses have their own count";
}

class ProxyTest : public RpcTest {
 protected:
  ProxyTest() { options_.trusts_proxy = true; }
};

TEST_F(ProxyTest, AClientBehindAProxyHasItsOwnAddress) {
  const auto sessions_of = [&](const std::string& address) {
    grpc::ClientContext context;
    context.AddMetadata("x-forwarded-for", address);
    v1::KickSessionRequest request;
    request.set_session_id("none");
    v1::KickSessionResponse response;
    return v1::SessionsService::NewStub(channel_)->KickSession(&context, request, &response);
  };
  EXPECT_EQ(sessions_of("127.0.0.1").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(sessions_of("203.0.113.7").error_code(), grpc::StatusCode::PERMISSION_DENIED)
      << "another machine without a token";
  EXPECT_EQ(sessions_of("127.0.0.1, 203.0.113.7").error_code(),
            grpc::StatusCode::PERMISSION_DENIED);
}

TEST_F(AccessTest, WithoutATrustedProxyTheHeaderIsIgnored) {
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer all-token");
  context.AddMetadata("x-forwarded-for", "203.0.113.7");
  TelemetryClient client(channel_, "all-token");
  client.Open(OneArmHello());
  v1::ListSessionsResponse response;
  ASSERT_TRUE(v1::SessionsService::NewStub(channel_)->ListSessions(&context, {}, &response).ok());
  EXPECT_THAT(response.sessions(0).client_address(), HasSubstr("127.0.0.1"));
}

// Addresses of other machines cannot occur in a test's connection.
TEST(AccessWithoutTokensTest, OtherMachinesMayPlayAndReadButNotOperate) {
  const RpcOptions options;
  const sessions::ManualClock clock;
  spdlog::logger log("test");
  AccessControl access(options, clock, log);
  for (const Rpc& rpc : kRoleTable) {
    const bool operates = rpc.role == auth::Role::kOperator;
    for (const char* own : {"ipv4:127.0.0.1:9", "ipv6:[::1]:9", "unix:/run/s"})
      EXPECT_TRUE(access.AuthorizeOverHttp(own, std::nullopt, rpc).ok()) << rpc.name;
    const auto other = access.AuthorizeOverHttp("ipv4:192.0.2.7:9", std::nullopt, rpc);
    EXPECT_EQ(other.ok(), !operates) << rpc.name;
    if (operates) {
      EXPECT_TRUE(absl::IsPermissionDenied(other.status()));
      EXPECT_THAT(std::string(other.status().message()), HasSubstr("sweepstaked token create"));
    }
  }
}

}  // namespace
}  // namespace sweepstake::rpc
