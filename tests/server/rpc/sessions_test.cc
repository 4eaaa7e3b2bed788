// Tests SessionsService: connected clients, the ends of sessions, and how a session is kicked.
#include <map>

#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

class SessionsTest : public RpcTest {
 protected:
  void SetUp() override {
    RpcTest::SetUp();
    sessions_ = v1::SessionsService::NewStub(channel_);
  }

  v1::ListSessionsResponse List(const v1::ListSessionsRequest& request = {}) {
    grpc::ClientContext context;
    v1::ListSessionsResponse response;
    EXPECT_TRUE(sessions_->ListSessions(&context, request, &response).ok());
    return response;
  }
  grpc::Status Kick(const std::string& session_id, bool may_return) {
    v1::KickSessionRequest request;
    request.set_session_id(session_id);
    request.set_may_return(may_return);
    grpc::ClientContext context;
    v1::KickSessionResponse response;
    return sessions_->KickSession(&context, request, &response);
  }

  grpc::Status Order(const std::string& session_id, v1::Mode mode, const std::string& arm) {
    v1::OrderSessionRequest request;
    request.set_session_id(session_id);
    request.set_mode(mode);
    request.set_arm(arm);
    grpc::ClientContext context;
    v1::OrderSessionResponse response;
    return sessions_->OrderSession(&context, request, &response);
  }

  // Waits until the messages of a kicked session are on disk, and advances the clock until the
  // session leaves memory.
  [[nodiscard]] bool Leaves(uint64_t count) {
    if (!Eventually([&] { return server_->counters().stored_commit_count >= 1; })) return false;
    clock_.Advance(2 * kSecondNs);
    return Eventually([&] { return server_->counters().session_count == count; });
  }
  // Advances to the tick at which the earlier changes are published to watchers.
  void TellWatchers() {
    List();
    clock_.Advance(events::EventBus::kIntervalNs);
  }

  std::unique_ptr<v1::SessionsService::Stub> sessions_;
};

v1::StreamTelemetryRequest ModeChange(uint64_t sequence, v1::Mode mode) {
  v1::StreamTelemetryRequest request;
  request.set_sequence(sequence);
  request.mutable_mode_change()->set_mode(mode);
  return request;
}

// A watcher of sessions.
class SessionsWatch {
 public:
  SessionsWatch(v1::SessionsService::Stub& stub, const v1::WatchSessionsRequest& request = {})
      : reader_(stub.WatchSessions(&context_, request)) {}
  ~SessionsWatch() { context_.TryCancel(); }

  v1::WatchSessionsResponse Next() {
    v1::WatchSessionsResponse event;
    EXPECT_TRUE(reader_->Read(&event));
    return event;
  }
  grpc::Status Finish() {
    v1::WatchSessionsResponse event;
    while (reader_->Read(&event)) {
    }
    return reader_->Finish();
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::WatchSessionsResponse>> reader_;
};

TEST_F(SessionsTest, ListsThePropertiesOfEachSession) {
  v1::Hello hello = HelloMessage();
  hello.set_build("1.2.3");
  hello.set_machine_class("desktop");
  hello.set_active_arm(1);
  hello.set_initial_arm(2);
  hello.add_capabilities(v1::CAPABILITY_BOX_VIEW);
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(hello);
  v1::StreamTelemetryRequest frames = Frames(1, 30);
  frames.mutable_frame_batch()->set_dropped_frame_count(7);
  EXPECT_EQ(List().sessions(0).unix_last_message_ms(), 0);
  client.Send(frames);
  ASSERT_TRUE(Applied(1));
  const v1::ListSessionsResponse response = List();
  ASSERT_EQ(response.sessions_size(), 1);
  const v1::SessionInfo& session = response.sessions(0);
  EXPECT_EQ(session.session_id(), welcome.session_id());
  EXPECT_EQ(session.project(), "game");
  EXPECT_EQ(session.scene(), "harbour");
  EXPECT_EQ(session.build(), "1.2.3");
  EXPECT_THAT(session.client_address(), HasSubstr("127.0.0.1"));
  EXPECT_EQ(session.state(), v1::SESSION_STATE_CONNECTED);
  EXPECT_EQ(session.machine_class(), "desktop");
  EXPECT_EQ(session.active_arm(), "SAP");
  EXPECT_EQ(session.initial_arm(), "KDTree");
  EXPECT_FALSE(session.takes_orders());
  EXPECT_TRUE(session.shows_boxes());
  EXPECT_EQ(session.mode(), v1::MODE_AI);
  EXPECT_GT(session.unix_start_ms(), 0);
  EXPECT_GE(session.unix_last_message_ms(), session.unix_start_ms());
  EXPECT_EQ(session.dropped_frame_count(), 7u);
  EXPECT_EQ(server_->counters().session_count, 1u);
  EXPECT_EQ(response.DebugString().find(welcome.resume_token()), std::string::npos);
}

TEST_F(SessionsTest, PagesAreInOrderAndCanBeFilteredByScene) {
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  std::set<std::string> ids;
  for (int i = 0; i < 5; ++i) {
    clients.push_back(std::make_unique<TelemetryClient>(channel_));
    v1::Hello hello = HelloMessage();
    if (i == 4) hello.set_scene("elsewhere");
    const std::string id = clients.back()->Open(hello).session_id();
    if (i < 4) ids.insert(id);
  }
  v1::ListSessionsRequest request;
  request.set_scene("harbour");
  request.set_page_size(3);
  std::vector<std::string> listed;
  do {
    const v1::ListSessionsResponse page = List(request);
    for (const v1::SessionInfo& session : page.sessions()) listed.push_back(session.session_id());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(listed, std::vector<std::string>(ids.begin(), ids.end()));
}

TEST_F(SessionsTest, AKickedSessionEndsAndItsMessagesReachTheDisk) {
  v1::Hello hello = HelloMessage();
  TelemetryClient client(channel_);
  Resume(hello, client.Open(hello));
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  EXPECT_TRUE(Kick(hello.session_id(), /*may_return=*/false).ok());
  const grpc::Status status = client.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_SESSION_KICKED);
  ASSERT_TRUE(Leaves(0));
  EXPECT_EQ(List().sessions_size(), 0);
  EXPECT_GE(server_->counters().stored_commit_count, 1u);
  EXPECT_EQ(ReasonOf(Kick(hello.session_id(), false)), v1::ERROR_REASON_UNKNOWN_SESSION);
  // The store still has the session, and its client has the resume token.
  TelemetryClient second(channel_);
  second.Send(Request(hello));
  EXPECT_EQ(ReasonOf(second.Finish()), v1::ERROR_REASON_SESSION_KICKED);
  EXPECT_EQ(List().sessions_size(), 0);
}

TEST_F(SessionsTest, AKickedSessionThatMayReturnContinues) {
  v1::Hello hello = HelloMessage();
  TelemetryClient client(channel_);
  Resume(hello, client.Open(hello));
  EXPECT_TRUE(Kick(hello.session_id(), /*may_return=*/true).ok());
  const grpc::Status status = client.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_CONNECTION_KICKED);
  EXPECT_EQ(List().sessions(0).state(), v1::SESSION_STATE_LOST);
  TelemetryClient second(channel_);
  EXPECT_TRUE(second.Open(hello).resumed());
  EXPECT_EQ(List().sessions(0).state(), v1::SESSION_STATE_CONNECTED);
}

TEST_F(SessionsTest, AKickedLostSessionCannotBeResumed) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
  }
  ASSERT_TRUE(Eventually([&] { return List().sessions(0).state() == v1::SESSION_STATE_LOST; }));
  EXPECT_TRUE(Kick(hello.session_id(), /*may_return=*/false).ok());
  EXPECT_EQ(List().sessions_size(), 0);
  TelemetryClient second(channel_);
  second.Send(Request(hello));
  EXPECT_EQ(ReasonOf(second.Finish()), v1::ERROR_REASON_SESSION_KICKED);
}

TEST_F(SessionsTest, AKickIsLoggedWithTheOperator) {
  TelemetryClient client(channel_);
  const std::string id = client.Open(HelloMessage()).session_id();
  EXPECT_TRUE(Kick(id, false).ok());
  EXPECT_THAT(logged_->text(), HasSubstr("127.0.0.1"));
  EXPECT_THAT(logged_->text(), HasSubstr("kicked session " + id + " of game/harbour"));
}

TEST_F(SessionsTest, AWatcherReceivesAllSessionsAndThenTheirChanges) {
  TelemetryClient before(channel_);
  const std::string first = before.Open(HelloMessage()).session_id();
  SessionsWatch watch(*sessions_);
  const v1::WatchSessionsResponse now = watch.Next();
  ASSERT_EQ(now.sessions_size(), 1);
  EXPECT_EQ(now.sessions(0).session_id(), first);
  TelemetryClient client(channel_);
  const std::string second = client.Open(HelloMessage()).session_id();
  TellWatchers();
  const v1::WatchSessionsResponse began = watch.Next();
  ASSERT_EQ(began.sessions_size(), 1);
  EXPECT_EQ(began.sessions(0).session_id(), second);
  EXPECT_EQ(began.sessions(0).state(), v1::SESSION_STATE_CONNECTED);
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  ASSERT_TRUE(Eventually([&] { return server_->counters().session_count == 1; }));
  TellWatchers();
  const v1::WatchSessionsResponse ended = watch.Next();
  ASSERT_EQ(ended.ended_size(), 1);
  EXPECT_EQ(ended.ended(0).session_id(), second);
  EXPECT_EQ(ended.ended(0).end(), v1::SESSION_END_GOODBYE);
  EXPECT_EQ(now.stamp().boot(), ended.stamp().boot());
  EXPECT_LT(now.stamp().sequence(), began.stamp().sequence());
  EXPECT_LT(began.stamp().sequence(), ended.stamp().sequence());
  EXPECT_GT(ended.stamp().unix_ms(), 0);
}

TEST_F(SessionsTest, AWatcherReceivesEachChangeOnceAndOnlyOfItsScene) {
  v1::WatchSessionsRequest request;
  request.set_scene("harbour");
  SessionsWatch watch(*sessions_, request);
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 1; }));
  v1::Hello elsewhere = HelloMessage();
  elsewhere.set_scene("elsewhere");
  TelemetryClient other(channel_);
  other.Open(elsewhere);
  TelemetryClient client(channel_);
  const std::string id = client.Open(HelloMessage()).session_id();
  client.Send(ModeChange(1, v1::MODE_MANUAL));
  ASSERT_TRUE(Applied(1));
  TellWatchers();
  const v1::WatchSessionsResponse changed = watch.Next();
  ASSERT_EQ(changed.sessions_size(), 1);
  const v1::SessionInfo& session = changed.sessions(0);
  EXPECT_EQ(session.session_id(), id);
  EXPECT_EQ(session.mode(), v1::MODE_MANUAL);
  EXPECT_TRUE(Kick(id, false).ok());
  ASSERT_TRUE(Leaves(1));
  TellWatchers();
  EXPECT_EQ(watch.Next().sessions(0).state(), v1::SESSION_STATE_ENDING);
  const v1::WatchSessionsResponse ended = watch.Next();
  ASSERT_EQ(ended.ended_size(), 1);
  EXPECT_EQ(ended.ended(0).session_id(), id);
  EXPECT_EQ(ended.ended(0).end(), v1::SESSION_END_KICKED);
}

TEST_F(SessionsTest, WatchersReceiveTheSameBytes) {
  v1::WatchSessionsRequest scene;
  scene.set_scene("harbour");
  v1::WatchSessionsRequest other;
  other.set_scene("elsewhere");
  SessionsWatch first(*sessions_, scene);
  SessionsWatch second(*sessions_, scene);
  SessionsWatch all(*sessions_);
  SessionsWatch none(*sessions_, other);
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 4; }));
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  TellWatchers();
  const v1::WatchSessionsResponse told = first.Next();
  EXPECT_EQ(told.SerializeAsString(), second.Next().SerializeAsString());
  EXPECT_EQ(told.SerializeAsString(), all.Next().SerializeAsString()) << "of another filter too";
  v1::Hello elsewhere = HelloMessage();
  elsewhere.set_scene("elsewhere");
  TelemetryClient there(channel_);
  there.Open(elsewhere);
  TellWatchers();
  EXPECT_EQ(none.Next().sessions(0).scene(), "elsewhere") << "and nothing before it";
}

// The watcher's connection buffers at most one page of sessions, because their names are long.
TEST_F(SessionsTest, ASlowWatcherReceivesSeveralChangesOfASessionOnce) {
  constexpr size_t kSessions = 250;
  options_.max_streams_per_connection = 1'000;
  RestartServer();
  sessions_ = v1::SessionsService::NewStub(channel_);
  v1::Hello hello = HelloMessage();
  hello.set_project(std::string(128, 'p'));
  hello.set_scene(std::string(128, 's'));
  hello.set_build(std::string(128, 'b'));
  hello.mutable_arms(0)->set_name(std::string(128, 'a'));
  std::map<std::string, std::unique_ptr<TelemetryClient>> clients;
  for (size_t i = 0; i < kSessions; ++i) {
    auto client = std::make_unique<TelemetryClient>(channel_);
    const std::string id = client->Open(hello).session_id();
    clients.emplace(id, std::move(client));
  }
  const auto stub = v1::SessionsService::NewStub(SmallWindowChannel());
  SessionsWatch watch(*stub);
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 1; }));
  const auto& [id, client] = *clients.begin();
  uint64_t sequence = 0;
  for (const v1::Mode mode : {v1::MODE_MANUAL, v1::MODE_AI, v1::MODE_MANUAL}) {
    client->Send(ModeChange(++sequence, mode));
    ASSERT_TRUE(Applied(sequence));
    TellWatchers();
  }
  std::map<std::string, int> told;
  for (const int count : {100, 100, 50, 1}) {
    const v1::WatchSessionsResponse event = watch.Next();
    EXPECT_EQ(event.sessions_size(), count);
    for (const v1::SessionInfo& session : event.sessions()) ++told[session.session_id()];
    if (count == 1) {
      EXPECT_EQ(event.sessions(0).mode(), v1::MODE_MANUAL);
    }
  }
  EXPECT_EQ(told.size(), kSessions);
  EXPECT_EQ(told[id], 2) << "in the list, and one update";
}

class WatcherLimitTest : public SessionsTest {
 protected:
  WatcherLimitTest() { options_.max_watchers = 1; }
};

TEST_F(WatcherLimitTest, TheNumberOfWatchersIsLimitedAndADrainEndsThem) {
  SessionsWatch watch(*sessions_);
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 1; }));
  SessionsWatch second(*sessions_);
  EXPECT_EQ(ReasonOf(second.Finish()), v1::ERROR_REASON_TOO_MANY_WATCHERS);
  EXPECT_THAT(logged_->text(), ::testing::HasSubstr("TOO_MANY_WATCHERS"));
  server_->Drain(std::chrono::seconds(10));
  EXPECT_EQ(ReasonOf(watch.Finish()), v1::ERROR_REASON_DRAINING);
  EXPECT_THAT(logged_->text(), ::testing::Not(::testing::HasSubstr("DRAINING")))
      << "a drain is not a refusal";
  EXPECT_EQ(server_->counters().open_watcher_count, 0u);
}

TEST_F(SessionsTest, AnOrderNeedsAnExistingSessionModeAndArm) {
  TelemetryClient client(channel_);
  const std::string id = client.Open(HelloMessage()).session_id();
  using grpc::StatusCode;
  EXPECT_EQ(Order("nobody", v1::MODE_AI, "").error_code(), StatusCode::NOT_FOUND);
  EXPECT_EQ(Order(id, v1::MODE_UNSPECIFIED, "").error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Order(id, v1::MODE_AI, "SAP").error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(Order(id, v1::MODE_MANUAL, "SAB").error_message(),
              HasSubstr("unknown arm 'SAB', must be one of SAP, Grid, KDTree"));
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(Order(id, v1::MODE_AI, "").error_code(), StatusCode::NOT_FOUND);
}

TEST_F(SessionsTest, ARefusedOrderOrKickIsLoggedAsARefusal) {
  TelemetryClient client(channel_);
  const std::string id = client.Open(HelloMessage()).session_id();  // accepts no orders
  EXPECT_EQ(ReasonOf(Order(id, v1::MODE_AI, "")), v1::ERROR_REASON_ORDER_REFUSED);
  EXPECT_EQ(ReasonOf(Kick("nobody", false)), v1::ERROR_REASON_UNKNOWN_SESSION);
  EXPECT_THAT(logged_->text(), HasSubstr("(ORDER_REFUSED): this game does not accept orders"));
  EXPECT_THAT(logged_->text(), HasSubstr("(UNKNOWN_SESSION)"));
  EXPECT_THAT(logged_->text(), Not(HasSubstr("ordered")));
}

TEST_F(SessionsTest, AnExecutedOrderIsLogged) {
  v1::Hello hello = HelloMessage();
  hello.add_capabilities(v1::CAPABILITY_OPERATOR_ORDERS);
  TelemetryClient client(channel_);
  const std::string id = client.Open(hello).session_id();
  std::thread game([&] {
    std::optional<v1::StreamTelemetryResponse> response = client.Read();
    while (response && !response->has_operator_order()) response = client.Read();
    if (!response) return;
    v1::StreamTelemetryRequest answer = ModeChange(1, v1::MODE_AI);
    answer.mutable_mode_change()->set_order_id(response->operator_order().order_id());
    client.Send(answer);
  });
  EXPECT_TRUE(Order(id, v1::MODE_AI, "").ok());
  game.join();
  EXPECT_THAT(logged_->text(), HasSubstr("ordered session " + id + " to let the daemon decide\n"));
}

}  // namespace
}  // namespace sweepstake::rpc
