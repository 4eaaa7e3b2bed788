// Posteriors and priors are listed, watched, exported and imported.
#include "engine_client/decider/policy/scene_diagnosis.h"
#include "engine_client/decider/session/policy_registry.h"
#include "tests/server/rpc/rpc_test_fixture.h"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/health_check_service_interface.h>
#include <spdlog/sinks/ringbuffer_sink.h>

#include <limits>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "server/sessions/common/unix_time.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

priors::SourceUpdate Evidence(const std::string& source, const std::string& scene,
                              const std::string& arm = "Grid") {
  priors::KeyedEvidence increment;
  increment.key.project = "game";
  increment.key.scene = scene;
  increment.key.arm = arm;
  increment.evidence = {.alpha = 0.75, .beta = 0.25, .window_count = 1, .bail_out_count = 0};
  priors::SourceUpdate update;
  update.progress.source_id = source;
  update.progress.commit_sequence = 1;
  update.increments.push_back(increment);
  return update;
}

// The long names make the event of each decision about a kilobyte.
v1::Hello ManyArmsHello() {
  v1::Hello hello = HelloMessage();
  hello.clear_arms();
  for (int i = 0; i < 32; ++i) {
    hello.add_arms()->set_name(std::to_string(i) + std::string(120, 'x'));
    hello.mutable_arms()->rbegin()->set_backend_version(1);
  }
  return hello;
}

class PosteriorsTest : public RpcTest {
 protected:
  void SetUp() override {
    log_.sinks().push_back(log_lines_);
    RpcTest::SetUp();
    posteriors_ = v1::PosteriorsService::NewStub(channel_);
    priors_ = v1::PriorsService::NewStub(channel_);
  }
  void Store(const priors::SourceUpdate& update) {
    std::promise<void> done;
    thread_.Commit(update, [&](const absl::Status&) { done.set_value(); });
    done.get_future().wait();
  }
  std::vector<v1::PriorRecord> Export() {
    grpc::ClientContext context;
    const auto reader = priors_->ExportPriors(&context, {});
    std::vector<v1::PriorRecord> records;
    v1::ExportPriorsResponse part;
    while (reader->Read(&part))
      records.insert(records.end(), part.records().begin(), part.records().end());
    EXPECT_TRUE(reader->Finish().ok());
    return records;
  }
  grpc::Status Import(const std::vector<v1::PriorRecord>& records,
                      v1::ImportPriorsResponse& response) {
    grpc::ClientContext context;
    const auto writer = priors_->ImportPriors(&context, &response);
    for (const v1::PriorRecord& record : records) {
      v1::ImportPriorsRequest part;
      part.set_promote(true);
      *part.add_records() = record;
      writer->Write(part);
    }
    writer->WritesDone();
    return writer->Finish();
  }

  // Makes the event bus publish to its watchers. Each call passes the store and the loop. The
  // second call is answered after all work that may have been queued behind the first.
  void TellWatchers() {
    for (int i = 0; i < 2; ++i) {
      grpc::ClientContext context;
      v1::ListPosteriorsResponse response;
      ASSERT_TRUE(posteriors_->ListPosteriors(&context, {}, &response).ok());
    }
    clock_.Advance(events::EventBus::kIntervalNs);
  }

  void ExpectTold(const std::string& refusal) const {
    EXPECT_THAT(log_lines_->last_formatted(), ::testing::Contains(HasSubstr(refusal)));
  }

  const std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> log_lines_ =
      std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(100);
  std::unique_ptr<v1::PosteriorsService::Stub> posteriors_;
  std::unique_ptr<v1::PriorsService::Stub> priors_;
};

using WatchReader = std::unique_ptr<grpc::ClientReader<v1::WatchPosteriorsResponse>>;

// Calls the reflection service and returns the status code.
grpc::StatusCode CallReflection(const std::shared_ptr<grpc::Channel>& channel) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  const grpc::Slice empty;
  const grpc::ByteBuffer request(&empty, 1);
  grpc::ByteBuffer response;
  std::promise<grpc::StatusCode> code;
  stub.UnaryCall(&context, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", {},
                 &request, &response,
                 [&](const grpc::Status& status) { code.set_value(status.error_code()); });
  return code.get_future().get();
}

TEST_F(RpcTest, ReflectionIsOffByDefault) {
  EXPECT_EQ(CallReflection(channel_), grpc::StatusCode::UNIMPLEMENTED);
  RpcOptions options = options_;
  options.reflection = true;
  sessions::ManualClock clock;
  auto reflecting = RpcServer::Start("127.0.0.1:0", options, clock, store_, log_);
  ASSERT_TRUE(reflecting.ok());
  const auto channel = grpc::CreateChannel("127.0.0.1:" + std::to_string((*reflecting)->port()),
                                           grpc::InsecureChannelCredentials());
  EXPECT_NE(CallReflection(channel), grpc::StatusCode::UNIMPLEMENTED);
}

TEST_F(PosteriorsTest, AreListedInPages) {
  for (const char* scene : {"b", "c", "a"}) Store(Evidence(std::string("source ") + scene, scene));
  v1::ListPosteriorsRequest request;
  request.set_page_size(2);
  v1::ListPosteriorsResponse first;
  grpc::ClientContext first_context;
  ASSERT_TRUE(posteriors_->ListPosteriors(&first_context, request, &first).ok());
  ASSERT_EQ(first.scenes_size(), 2);
  EXPECT_EQ(first.scenes(0).scene(), "a");
  request.set_page_token(first.next_page_token());
  v1::ListPosteriorsResponse second;
  grpc::ClientContext second_context;
  ASSERT_TRUE(posteriors_->ListPosteriors(&second_context, request, &second).ok());
  ASSERT_EQ(second.scenes_size(), 1);
  EXPECT_EQ(second.scenes(0).scene(), "c");
  EXPECT_TRUE(second.next_page_token().empty());
}

TEST_F(PosteriorsTest, AForeignPageTokenIsInvalid) {
  for (const char* token : {"zz", "a", "ff", "next"}) {
    v1::ListPosteriorsRequest request;
    request.set_page_token(token);
    v1::ListPosteriorsResponse response;
    grpc::ClientContext context;
    EXPECT_EQ(ReasonOf(posteriors_->ListPosteriors(&context, request, &response)),
              v1::ERROR_REASON_INVALID_MESSAGE)
        << token;
  }
}

TEST_F(PosteriorsTest, APosteriorIsBetaOneOnePlusTheEvidence) {
  Store(Evidence("a", "harbour"));
  priors::SourceUpdate timed = Evidence("b", "harbour");
  timed.unix_time_s = 1'800'000'000;
  Store(timed);
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  v1::GetPosteriorRequest request;
  request.set_project("game");
  request.set_scene("harbour");
  request.set_reward_version(
      decision::PolicyKindOf("paper", decision::ShippedPolicies()).reward_version);
  v1::GetPosteriorResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(posteriors_->GetPosterior(&context, request, &response).ok());
  ASSERT_EQ(response.scene().arms_size(), 1);
  EXPECT_EQ(response.scene().arms(0).posterior().alpha(), 2.5);
  EXPECT_EQ(response.scene().arms(0).posterior().beta(), 1.5);
  EXPECT_EQ(response.scene().arms(0).unix_last_seen_s(), 1'800'000'000);
  EXPECT_EQ(response.scene().source_count(), 2u);
  EXPECT_EQ(response.scene().active_session_count(), 1u);
}

TEST_F(PosteriorsTest, AnUnknownSceneIsNotFoundAndAnEmptyNameInvalid) {
  v1::GetPosteriorRequest request;
  v1::GetPosteriorResponse response;
  grpc::ClientContext nameless;
  EXPECT_EQ(ReasonOf(posteriors_->GetPosterior(&nameless, request, &response)),
            v1::ERROR_REASON_INVALID_MESSAGE);
  request.set_project("game");
  request.set_scene("nowhere");
  grpc::ClientContext unknown;
  EXPECT_EQ(ReasonOf(posteriors_->GetPosterior(&unknown, request, &response)),
            v1::ERROR_REASON_UNKNOWN_SCENE);
}

TEST_F(PosteriorsTest, TheFiguresOfASceneEqualThoseOfTheDeciderBitByBit) {
  for (const uint32_t reward_version : {1u, decision::kLogCostRewardVersion}) {
    SCOPED_TRACE(reward_version);
    priors::SceneEvidence evidence;
    evidence.key = {"game", "harbour", "desktop", reward_version};
    evidence.ArmOf("Grid", 1).live = {.alpha = 12.25, .beta = 7.5, .window_count = 20};
    evidence.ArmOf("Grid", 2).live = {.alpha = 31.5, .beta = 20.125, .window_count = 60};
    evidence.ArmOf("SAP", 1).live = {.alpha = 30.75, .beta = 21.5, .window_count = 50};
    v1::ScenePosterior scene;
    ToProto(evidence, scene);
    ASSERT_EQ(scene.arms_size(), 3);
    std::vector<decision::SceneArm> arms;
    for (const v1::ArmPosterior& arm : scene.arms()) {
      arms.push_back(
          {arm.arm(), arm.backend_version(), {arm.posterior().alpha(), arm.posterior().beta()}});
    }
    const decision::SceneDiagnosis expected = decision::DiagnoseScene(arms, reward_version);
    ASSERT_TRUE(expected.leader);
    EXPECT_EQ(scene.leader_arm(), arms[*expected.leader].name);
    EXPECT_EQ(scene.verdict(), static_cast<v1::Verdict>(expected.verdict));
    EXPECT_EQ(scene.expected_loss_ratio(), expected.expected_loss_ratio);
    EXPECT_EQ(scene.value_remaining_ratio(), expected.value_remaining_ratio);
    for (int i = 0; i < scene.arms_size(); ++i) {
      SCOPED_TRACE(i);
      const v1::ArmPosterior& arm = scene.arms(i);
      const decision::ArmDiagnosis& wanted = expected.arms[static_cast<size_t>(i)];
      const v1::RewardPosterior& reward = arm.posterior();
      const decision::BetaPosterior posterior = {reward.alpha(), reward.beta()};
      const decision::CredibleInterval of_95 = decision::CentralInterval(posterior, 0.95);
      const decision::CredibleInterval of_50 = decision::CentralInterval(posterior, 0.5);
      EXPECT_EQ(reward.low_95(), of_95.low);
      EXPECT_EQ(reward.low_50(), of_50.low);
      EXPECT_EQ(reward.high_50(), of_50.high);
      EXPECT_EQ(reward.high_95(), of_95.high);
      EXPECT_EQ(arm.is_outdated(), i == 0);
      ASSERT_EQ(arm.has_best_probability(), wanted.best_probability.has_value());
      EXPECT_EQ(arm.best_probability(), wanted.best_probability.value_or(0));
      ASSERT_EQ(arm.has_cost_ratio(), wanted.cost_ratio.has_value());
      const CostRatio ratio = wanted.cost_ratio.value_or(CostRatio{0, 0, 0});
      EXPECT_EQ(arm.cost_ratio().median(), ratio.median);
      EXPECT_EQ(arm.cost_ratio().low(), ratio.low);
      EXPECT_EQ(arm.cost_ratio().high(), ratio.high);
    }
  }
}

TEST_F(PosteriorsTest, AWatcherReceivesTheScenesThenDecisionsAndTheirEvidence) {
  Store(Evidence("a", "harbour", "SAP"));
  Store(Evidence("b", "desert"));
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  v1::WatchPosteriorsRequest request;
  request.set_scene("harbour");
  grpc::ClientContext context;
  const auto watcher = posteriors_->WatchPosteriors(&context, request);
  v1::WatchPosteriorsResponse event;
  ASSERT_TRUE(watcher->Read(&event));
  EXPECT_EQ(event.posterior().scene(), "harbour");
  EXPECT_EQ(event.posterior().active_session_count(), 1u);
  const v1::EventStamp first = event.stamp();
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  client.AwaitAcknowledgement(1);
  TellWatchers();
  ASSERT_TRUE(watcher->Read(&event));
  ASSERT_EQ(event.decisions_size(), 1);
  const v1::DecisionEvent& decision = event.decisions(0);
  EXPECT_EQ(decision.active_arm(), "Grid");
  EXPECT_EQ(decision.decision_id(), 1u);
  EXPECT_TRUE(decision.has_reward());
  EXPECT_EQ(decision.policy(), "paper");
  EXPECT_NE(decision.verdict(), v1::VERDICT_UNSPECIFIED);
  ASSERT_EQ(decision.best_probability_size(), 3);
  EXPECT_NEAR(
      decision.best_probability(0) + decision.best_probability(1) + decision.best_probability(2), 1,
      1e-9);
  EXPECT_GT(decision.expected_loss_ratio(), 0);
  ASSERT_EQ(decision.arms_size(), 3);
  ASSERT_EQ(decision.standings_size(), 3);
  EXPECT_EQ(decision.arms(0), "Grid");
  EXPECT_EQ(decision.standings(0).live_window_count(), 1u);
  EXPECT_EQ(decision.standings(2).best_probability(), decision.best_probability(2));
  EXPECT_EQ(event.stamp().boot(), first.boot());
  EXPECT_GT(event.stamp().sequence(), first.sequence());
  EXPECT_GE(decision.unix_ms(), first.unix_ms());
  EXPECT_LE(decision.unix_ms(), event.stamp().unix_ms());
  EXPECT_GT(event.stamp().unix_ms(), 0);
  while (event.posterior().arms_size() < 2) ASSERT_TRUE(watcher->Read(&event));
  EXPECT_EQ(event.posterior().arms(0).arm(), "Grid");
  EXPECT_EQ(event.posterior().arms(0).window_count(), 1u);
  context.TryCancel();
}

TEST_F(PosteriorsTest, OnlyAWatcherThatDoesNotReadIsDropped) {
  const v1::Hello hello = ManyArmsHello();
  const auto own_channel = SmallWindowChannel();
  grpc::ClientContext context;
  const auto idle = v1::PosteriorsService::NewStub(own_channel)->WatchPosteriors(&context, {});
  // Fills the buffers of the watcher that does not read. Only then does the passing time count
  // against it.
  for (int i = 0; i < 400; ++i)
    Store(Evidence("source " + std::to_string(i),
                   "scene " + std::to_string(i) + std::string(100, 'y'), std::string(120, 'x')));
  TelemetryClient client(channel_);
  client.Open(hello);
  for (uint64_t sequence = 1; sequence <= 600; ++sequence) {
    client.Send(Frames(sequence, 1));
    ASSERT_TRUE(Applied(sequence));
    Tick();
    client.AwaitAcknowledgement(sequence);
  }
  v1::WatchPosteriorsResponse event;
  while (idle->Read(&event)) {
  }
  EXPECT_EQ(idle->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  ExpectTold("(WATCHER_STALLED): the watcher did not read");
  client.Send(Frames(601, 30));
  ASSERT_TRUE(Applied(601));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(601), 601u);
}

TEST_F(PosteriorsTest, AHundredWatchersReadTheStoreOncePerSceneForAnyNumberOfCommits) {
  Store(Evidence("a", "harbour"));
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  v1::WatchPosteriorsResponse event;
  std::vector<grpc::ClientContext> contexts(99);
  std::vector<WatchReader> watchers;
  for (grpc::ClientContext& context : contexts) {
    watchers.push_back(posteriors_->WatchPosteriors(&context, {}));
    ASSERT_TRUE(watchers.back()->Read(&event));
  }
  const size_t before = store_.submit_count();
  for (uint64_t sequence = 1; sequence <= 50; ++sequence) {
    client.Send(Frames(sequence, 30));
    ASSERT_TRUE(Applied(sequence));
    Tick();
    client.AwaitAcknowledgement(sequence);
  }
  EXPECT_EQ(store_.submit_count(), before + 1);
  for (grpc::ClientContext& context : contexts) context.TryCancel();
}

TEST_F(PosteriorsTest, ConcurrentDecisionsAreEncodedOnceAndReachAllFastWatchers) {
  options_.max_streams_per_connection = 1'000;
  RestartServer();
  posteriors_ = v1::PosteriorsService::NewStub(channel_);
  Store(Evidence("a", "harbour"));
  constexpr size_t kSessions = 130;
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  v1::StreamTelemetryRequest manual;
  manual.set_sequence(1);
  manual.mutable_mode_change()->set_mode(v1::MODE_MANUAL);
  for (size_t i = 0; i < kSessions; ++i) {
    clients.push_back(std::make_unique<TelemetryClient>(channel_));
    clients.back()->Open(OneArmHello());
    clients.back()->Send(manual);
  }
  ASSERT_TRUE(Applied(kSessions));
  std::vector<grpc::ClientContext> contexts(3);
  std::vector<WatchReader> watchers;
  v1::WatchPosteriorsResponse event;
  for (grpc::ClientContext& context : contexts) {
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
    watchers.push_back(posteriors_->WatchPosteriors(&context, {}));
    ASSERT_TRUE(watchers.back()->Read(&event));
  }
  Tick();
  ASSERT_TRUE(Eventually([&] { return server_->counters().decision_count == kSessions; }));
  TellWatchers();
  std::set<std::string> sessions;
  std::set<uint64_t> events;
  for (const WatchReader& watcher : watchers) {
    for (const int count : {100, 30}) {
      ASSERT_TRUE(watcher->Read(&event));
      EXPECT_EQ(event.decisions_size(), count);
      for (const auto& decision : event.decisions()) sessions.insert(decision.session_id());
      events.insert(event.stamp().sequence());
    }
  }
  EXPECT_EQ(sessions.size(), kSessions);
  EXPECT_EQ(events.size(), 2u) << "events of all three watchers";
  for (grpc::ClientContext& context : contexts) context.TryCancel();
}

TEST_F(PosteriorsTest, ASlowWatcherMissesDecisionsButNoScenesAndReadsTheStoreOnce) {
  options_.watcher_patience_ns = 1'000'000 * kSecondNs;
  RestartServer();
  posteriors_ = v1::PosteriorsService::NewStub(channel_);
  Store(Evidence("a", "harbour"));
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  for (int i = 0; i < 30; ++i) {
    v1::Hello hello = ManyArmsHello();
    hello.set_scene(i == 0 ? "harbour" : "elsewhere");
    if (i == 0) hello.mutable_arms()->RemoveLast();  // the scene has an arm, and may have 32
    clients.push_back(std::make_unique<TelemetryClient>(channel_));
    clients.back()->Open(hello);
  }
  const auto own_channel = SmallWindowChannel();
  grpc::ClientContext context;
  const WatchReader watcher =
      v1::PosteriorsService::NewStub(own_channel)->WatchPosteriors(&context, {});
  v1::WatchPosteriorsResponse event;
  ASSERT_TRUE(watcher->Read(&event));
  const size_t before = store_.submit_count();
  constexpr uint64_t kTicks = 200;
  for (uint64_t sequence = 1; sequence <= kTicks; ++sequence) {
    clients[0]->Send(Frames(sequence, 30));
    ASSERT_TRUE(Applied(sequence));
    Tick();
    clients[0]->AwaitAcknowledgement(sequence);
  }
  EXPECT_EQ(store_.submit_count(), before + 1);
  TellWatchers();
  size_t decisions = 0;
  while (event.posterior().arms_size() == 0 || event.posterior().arms(0).window_count() < kTicks) {
    ASSERT_TRUE(watcher->Read(&event));
    decisions += static_cast<size_t>(event.decisions_size());
  }
  EXPECT_LT(decisions, kTicks * clients.size());
  context.TryCancel();
}

// Advances the clock until the call has ended, and returns its status.
template <typename Call>
grpc::Status EndOfStalled(sessions::ManualClock& clock, Call& call) {
  std::future<grpc::Status> end = std::async(std::launch::async, [&] { return call.Finish(); });
  while (end.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready)
    clock.Advance(kSecondNs);
  return end.get();
}

TEST_F(PosteriorsTest, AnImportThatStopsHalfwayEndsAndImportsNothing) {
  Store(Evidence("a", "harbour"));
  v1::ImportPriorsRequest part;
  *part.add_records() = Export()[0];
  part.mutable_records(0)->set_source_id("b");
  grpc::ClientContext context;
  v1::ImportPriorsResponse response;
  const auto writer = priors_->ImportPriors(&context, &response);
  writer->Write(part);
  const int64_t start_ns = clock_.NowNs();
  EXPECT_EQ(EndOfStalled(clock_, *writer).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_GE(clock_.NowNs() - start_ns, options_.watcher_patience_ns);
  ExpectTold("(CALL_STALLED): the records did not arrive");
  EXPECT_EQ(Stored().source_count, 1u);
}

TEST_F(PosteriorsTest, AnExportThatIsNotReadEnds) {
  for (int i = 0; i < 4000; ++i) {
    Store(Evidence("source " + std::to_string(i) + std::string(100, 'x'), "harbour"));
  }
  const auto own_channel = SmallWindowChannel();
  grpc::ClientContext context;
  const auto reader = v1::PriorsService::NewStub(own_channel)->ExportPriors(&context, {});
  ASSERT_TRUE(Eventually([&] {
    clock_.Advance(kSecondNs);
    return server_->counters().error_counts.at(v1::ERROR_REASON_CALL_STALLED) == 1;
  }));
  v1::ExportPriorsResponse part;
  while (reader->Read(&part)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  ExpectTold("(CALL_STALLED): the client did not read");
}

TEST_F(PosteriorsTest, ExportedPriorsGiveAnotherDaemonTheSamePosteriors) {
  for (int i = 0; i < 450; ++i) Store(Evidence("source " + std::to_string(i), "harbour"));
  const std::vector<v1::PriorRecord> records = Export();
  ASSERT_EQ(records.size(), 450u);
  const priors::SceneEvidence before = Stored();
  for (int i = 0; i < 450; ++i)
    thread_.Submit([i](priors::PriorStore& store) {
      store.Revoke({.id = "source " + std::to_string(i)}, false).IgnoreError();
    });
  ASSERT_TRUE(Stored().arms.empty());
  std::vector<v1::PriorRecord> renamed = records;
  for (v1::PriorRecord& record : renamed) record.set_source_id("elsewhere " + record.source_id());
  v1::ImportPriorsResponse response;
  ASSERT_TRUE(Import(renamed, response).ok());
  EXPECT_EQ(response.applied_count(), 450u);
  EXPECT_EQ(Stored().arms[0].live, before.arms[0].live);
  ASSERT_TRUE(Import(renamed, response).ok());
  EXPECT_EQ(response.applied_count(), 0u);
  EXPECT_EQ(response.unchanged_count(), 450u);
  EXPECT_EQ(Stored().arms[0].live, before.arms[0].live);
}

TEST_F(PosteriorsTest, AnImportWithOneWrongRecordImportsNothingAndNamesIt) {
  Store(Evidence("a", "harbour"));
  std::vector<v1::PriorRecord> records = Export();
  records[0].set_source_id("b");
  records.push_back(records[0]);
  records[1].set_beta_increment(-1);
  v1::ImportPriorsResponse response;
  const grpc::Status status = Import(records, response);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_INVALID_MESSAGE);
  EXPECT_THAT(status.error_message(), HasSubstr("record 1"));
  EXPECT_EQ(Stored().source_count, 1u);
}

TEST_F(PosteriorsTest, AnImportedSourceIsNotSeenInTheFuture) {
  Store(Evidence("a", "harbour"));
  std::vector<v1::PriorRecord> records = Export();
  records[0].set_source_id("b");
  records[0].set_unix_last_seen_s(std::numeric_limits<int64_t>::max());
  v1::ImportPriorsResponse response;
  ASSERT_TRUE(Import(records, response).ok());
  records = Export();
  ASSERT_EQ(records.size(), 2u);
  for (const v1::PriorRecord& record : records) {
    EXPECT_LE(record.unix_last_seen_s(), priors::UnixNowS()) << record.source_id();
  }
}

TEST_F(PosteriorsTest, EvidenceAboveTheLimitOfASessionIsScaledDownProportionally) {
  const v1::Hello hello = OneArmHello();
  v1::PriorRecord record;
  record.set_project(hello.project());
  record.set_scene(hello.scene());
  record.set_arm(hello.arms(0).name());
  record.set_backend_version(hello.arms(0).backend_version());
  record.set_machine_class(hello.machine_class());
  record.set_reward_version(1);
  record.set_source_sequence(1);
  record.set_alpha_increment(9e14);
  record.set_beta_increment(3e14);
  std::vector<v1::PriorRecord> records(2, record);
  records[0].set_source_id("a");
  records[1].set_source_id("b");
  v1::ImportPriorsResponse response;
  ASSERT_TRUE(Import(records, response).ok());
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(hello);
  ASSERT_EQ(welcome.priors_size(), 1);
  EXPECT_NEAR(welcome.priors(0).alpha() / welcome.priors(0).beta(), 3, 1e-9);
}

TEST_F(PosteriorsTest, AnInterruptedImportImportsNothing) {
  Store(Evidence("a", "harbour"));
  v1::PriorRecord record = Export()[0];
  record.set_source_id("b");
  {
    grpc::ClientContext context;
    v1::ImportPriorsResponse response;
    const auto writer = priors_->ImportPriors(&context, &response);
    v1::ImportPriorsRequest part;
    *part.add_records() = record;
    writer->Write(part);
    context.TryCancel();
    EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  server_->Drain(std::chrono::seconds(30));
  EXPECT_EQ(Stored().source_count, 1u);
}

}  // namespace
}  // namespace sweepstake::rpc
