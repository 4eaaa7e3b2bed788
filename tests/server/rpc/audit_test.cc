// Tests the audit log of sessions over the stream: every exported decision can be replayed bit by
// bit.
#include <spdlog/sinks/ringbuffer_sink.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/audit/rederive.h"
#include "engine_client/decider/policy/log_cost.h"
#include "sweepstake/v1/audit.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::ElementsAre;

class AuditTest : public RpcTest {
 protected:
  using RpcTest::RpcTest;
  std::vector<v1::AuditSegment> List(const v1::ListAuditSegmentsRequest& request = {}) {
    const auto stub = v1::AuditService::NewStub(channel_);
    grpc::ClientContext context;
    const auto reader = stub->ListAuditSegments(&context, request);
    std::vector<v1::AuditSegment> segments;
    v1::ListAuditSegmentsResponse part;
    while (reader->Read(&part))
      segments.insert(segments.end(), part.segments().begin(), part.segments().end());
    EXPECT_TRUE(reader->Finish().ok());
    return segments;
  }
  // Sends frames in messages `first` to `last`, with a tick after each, and waits for each
  // acknowledgement.
  void Play(TelemetryClient& client, uint64_t first, uint64_t last) {
    for (uint64_t message = first; message <= last; ++message) {
      client.Send(Frames(message, 30));
      ASSERT_TRUE(Applied(applied_ += 1));
      Tick();
      ASSERT_EQ(client.AwaitAcknowledgement(message), message);
    }
  }

  uint64_t applied_ = 0;  // messages since the server started
};

decision::AuditReport Derived(const std::vector<decision::AuditRow>& rows) {
  decision::AuditReport report = decision::Rederive(rows);
  EXPECT_FALSE(report.difference) << report.difference->Text();
  return report;
}

TEST_F(AuditTest, AnEmptyLogHasNoRows) {
  EXPECT_TRUE(ExportAudit().empty());
  EXPECT_TRUE(List().empty());
}

TEST_F(AuditTest, EveryExportedDecisionCanBeReplayed) {
  TelemetryClient client(channel_);
  const std::string id = client.Open(HelloMessage()).session_id();
  Play(client, 1, 5);
  client.Send(BailOut(6, 99'999));
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.decision_count, 6u);
  EXPECT_EQ(report.row_count, 7u);
  const auto segments = List();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].session_id(), id);
  EXPECT_EQ(segments[0].project(), "game");
  EXPECT_EQ(segments[0].scene(), "harbour");
  EXPECT_EQ(segments[0].row_count(), 7u);
  EXPECT_GT(segments[0].unix_start_ms(), 1'600'000'000'000);
}

TEST_F(AuditTest, TheSetupRowListsTheSourcesOfThePriorAndTheirWeights) {
  v1::Hello hello = HelloMessage();
  hello.set_policy("adaptive");
  hello.set_machine_class("desktop");
  hello.set_build("1.1");
  for (const std::string source : {"a", "b", "c"}) {
    Put({{.key = {.project = hello.project(),
                  .scene = hello.scene(),
                  .measured_by = "lane",
                  .arm = "Grid",
                  .backend_version = 1,
                  .machine_class = "desktop",
                  .reward_version = decision::kLogCostRewardVersion},
          .source_id = source,
          .source_sequence = 1,
          .evidence = {.alpha = 5'000, .beta = 5'000, .window_count = 50},
          .build = source == "c" ? "1.0" : "1.1"}});
  }
  TelemetryClient client(channel_);
  client.Open(hello);
  Play(client, 1, 1);
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  const std::vector<decision::AuditRow> rows = ExportAudit();
  EXPECT_THAT(rows.at(0).setup->origin.prior_sources,
              ElementsAre("2 sources of build 1.1 on desktop with weight 0.5",
                          "1 source of build 1.0 on desktop with weight 0.25"));
  Derived(rows);
}

class AuditOfTrials : public AuditTest, public testing::WithParamInterface<bool> {};

TEST_P(AuditOfTrials, TheSetupRowSaysWhetherTheGameStopsThem) {
  v1::Hello hello = HelloMessage();
  if (GetParam()) hello.add_capabilities(v1::CAPABILITY_STOPS_TRIALS);
  TelemetryClient client(channel_);
  client.Open(hello);
  Play(client, 1, 1);
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  const std::vector<decision::AuditRow> rows = ExportAudit();
  ASSERT_FALSE(rows.empty());
  ASSERT_TRUE(rows[0].setup);
  EXPECT_EQ(rows[0].setup->setup.stops_trials, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Capability, AuditOfTrials, testing::Bool());

TEST_F(AuditTest, BailOutsWithoutEvidenceAreReplayedAsSuch) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  for (uint64_t sequence = 1; sequence <= 20; ++sequence) client.Send(BailOut(sequence, sequence));
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(server_->counters().surplus_bail_out_count, 4u);
  EXPECT_EQ(Derived(ExportAudit()).decision_count, 20u);
}

TEST_F(AuditTest, ASessionResumedAfterARestartBeginsAnotherSegment) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
    Play(client, 1, 3);
  }
  RestartServer();
  applied_ = 0;
  TelemetryClient client(channel_);
  EXPECT_TRUE(client.Open(hello).resumed());
  Play(client, 4, 6);
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.session_count, 1u);
  EXPECT_EQ(report.segment_count, 2u);
  EXPECT_EQ(report.decision_count, 6u);
}

TEST_F(AuditTest, ASessionResumedWithinItsWindowContinuesItsSegment) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, client.Open(hello));
    Play(client, 1, 2);
  }
  TelemetryClient client(channel_);
  EXPECT_TRUE(client.Open(hello).resumed());
  Play(client, 3, 4);
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.segment_count, 1u);
  EXPECT_GE(report.decision_count, 4u);
}

TEST_F(AuditTest, IsListedAndExportedBySessionProjectAndScene) {
  v1::Hello desert = HelloMessage();
  desert.set_scene("desert");
  TelemetryClient one(channel_);
  TelemetryClient other(channel_);
  const std::string id = one.Open(HelloMessage()).session_id();
  other.Open(desert);
  Play(one, 1, 1);
  Play(other, 1, 1);
  ASSERT_EQ(List().size(), 2u);
  v1::ExportDecisionsRequest request;
  request.mutable_filter()->set_session_id(id);
  EXPECT_EQ(ExportAudit(request).at(0).session, id);
  EXPECT_EQ(Derived(ExportAudit(request)).session_count, 1u);
  request.mutable_filter()->set_scene("desert");
  EXPECT_TRUE(ExportAudit(request).empty());
  v1::ListAuditSegmentsRequest scenes;
  scenes.set_project("game");
  scenes.set_scene("desert");
  ASSERT_EQ(List(scenes).size(), 1u);
  EXPECT_EQ(List(scenes)[0].scene(), "desert");
}

class ListTest : public AuditTest {
 protected:
  v1::ListDecisionsResponse Page(const v1::ListDecisionsRequest& request = {},
                                 grpc::StatusCode code = grpc::StatusCode::OK) {
    grpc::ClientContext context;
    v1::ListDecisionsResponse page;
    EXPECT_EQ(
        v1::AuditService::NewStub(channel_)->ListDecisions(&context, request, &page).error_code(),
        code);
    return page;
  }
  // Returns the places of the rows, as SESSION:SEGMENT.ROW, with names[id] for a session.
  std::vector<std::string> PlacesOf(const v1::ListDecisionsResponse& page) {
    std::vector<std::string> places;
    for (const v1::AuditRow& row : page.rows())
      places.push_back(absl::StrCat(names_[row.session()], row.segment(), ".", row.row()));
    return places;
  }
  // Reads all pages from the newest row on.
  std::vector<std::string> AllPlaces(v1::ListDecisionsRequest request) {
    std::vector<std::string> places;
    for (bool has_more = true; has_more;) {
      const auto page = Page(request);
      for (const std::string& place : PlacesOf(page)) places.push_back(place);
      request.set_older_than(page.older_token());
      has_more = page.has_more();
    }
    return places;
  }
  // Makes a log of three sessions: a in two segments, b in another scene, and c of a single row.
  void MakeLog() {
    v1::Hello hello = HelloMessage();
    v1::Hello desert = HelloMessage();
    desert.set_scene("desert");
    {
      TelemetryClient client(channel_);
      const v1::Welcome welcome = client.Open(hello);
      Resume(hello, welcome);
      session_ = welcome.session_id();
      names_[session_] = "a";
      Play(client, 1, 3);
    }
    {
      TelemetryClient client(channel_);
      names_[client.Open(desert).session_id()] = "b";
      Play(client, 1, 1);
      client.Send(Goodbye());
      EXPECT_TRUE(client.Finish().ok());
    }
    RestartServer();
    applied_ = 0;
    TelemetryClient client(channel_);
    EXPECT_TRUE(client.Open(hello).resumed());
    Play(client, 4, 5);
    client.Send(Goodbye());
    EXPECT_TRUE(client.Finish().ok());
  }

  std::map<std::string, std::string> names_;
  std::string session_;
};

using Places = std::vector<std::string>;

TEST_F(ListTest, RowsOfAllSessionsComeInTheOrderOfArrivalNewestFirst) {
  MakeLog();
  const Places all = {"a2.3", "a2.2", "a2.1", "b1.2", "b1.1", "a1.4", "a1.3", "a1.2", "a1.1"};
  const auto page = Page();
  EXPECT_EQ(PlacesOf(page), all);
  EXPECT_FALSE(page.has_more());
  ASSERT_EQ(page.setups_size(), 3) << "one per segment";
  EXPECT_EQ(page.setups(0).session_id(), session_);
  EXPECT_EQ(page.setups(0).segment(), 2u);
  EXPECT_EQ(page.setups(0).setup().arms_size(), HelloMessage().arms_size());
  EXPECT_EQ(page.setups(1).setup().scene(), "desert");
  for (const uint32_t size : {1, 2, 4}) {
    v1::ListDecisionsRequest request;
    request.set_page_size(size);
    EXPECT_EQ(Page(request).rows_size(), size);
    EXPECT_EQ(AllPlaces(request), all) << size;
  }
}

TEST_F(ListTest, RowsOfOneSessionComeBySegmentAndNumber) {
  MakeLog();
  v1::ListDecisionsRequest request;
  request.mutable_filter()->set_session_id(session_);
  const Places all = {"a2.3", "a2.2", "a2.1", "a1.4", "a1.3", "a1.2", "a1.1"};
  EXPECT_EQ(PlacesOf(Page(request)), all);
  for (const uint32_t size : {1, 2, 3}) {
    request.set_page_size(size);
    EXPECT_EQ(AllPlaces(request), all) << size;
  }
}

TEST_F(ListTest, NewerRowsAreReadFromAPlaceOn) {
  MakeLog();
  for (const std::string& session : {std::string(), session_}) {
    v1::ListDecisionsRequest request;
    request.mutable_filter()->set_session_id(session);
    request.set_page_size(2);
    const auto newest = Page(request);
    request.set_newer_than(newest.newer_token());
    const auto tail = Page(request);
    EXPECT_EQ(tail.rows_size(), 0) << "nothing is newer";
    EXPECT_FALSE(tail.has_more());
    EXPECT_EQ(tail.newer_token(), newest.newer_token());
    request.clear_newer_than();
    request.set_older_than(newest.older_token());
    const auto older = Page(request);
    request.clear_older_than();
    request.set_newer_than(older.newer_token());
    EXPECT_EQ(PlacesOf(Page(request)), PlacesOf(newest)) << "back on the first page";
    EXPECT_FALSE(Page(request).has_more());
    request.set_older_than("1.1");
    Page(request, grpc::StatusCode::INVALID_ARGUMENT);
  }
}

TEST_F(ListTest, ATailBeginsInAnEmptyLog) {
  v1::ListDecisionsRequest request;
  const auto empty = Page(request);
  EXPECT_FALSE(empty.has_more());
  MakeLog();
  request.set_newer_than(empty.newer_token());
  request.set_page_size(4);
  const auto page = Page(request);
  EXPECT_EQ(PlacesOf(page), (Places{"a1.4", "a1.3", "a1.2", "a1.1"})) << "the oldest rows first";
  EXPECT_TRUE(page.has_more());
}

TEST_F(ListTest, RowsAreSelectedByTheirContent) {
  MakeLog();
  const auto count = [&](auto change) {
    int counts[2];
    for (const bool one : {false, true}) {
      v1::ListDecisionsRequest request;
      if (one) request.mutable_filter()->set_session_id(session_);
      change(*request.mutable_filter());
      counts[one] = Page(request).rows_size();
    }
    return std::pair(counts[0], counts[1]);
  };
  using Counts = std::pair<int, int>;
  using Filter = v1::DecisionFilter;
  EXPECT_EQ(count([](Filter& f) { f.add_kinds(v1::AUDIT_KIND_SETUP); }), Counts(3, 2));
  EXPECT_EQ(count([](Filter& f) {
              f.add_kinds(v1::AUDIT_KIND_SETUP);
              f.add_kinds(v1::AUDIT_KIND_TICK);
            }),
            Counts(9, 7));
  EXPECT_EQ(count([](Filter& f) { f.add_outcomes(v1::DECISION_OUTCOME_REJECTED); }), Counts(0, 0));
  EXPECT_EQ(count([](Filter& f) { f.set_scene("desert"); }), Counts(2, 0));
  EXPECT_EQ(count([](Filter& f) { f.set_arm("nothing"); }), Counts(0, 0));
  const v1::AuditRow tick = Page().rows(0);
  EXPECT_GT(count([&](Filter& f) { f.set_arm(tick.decision().active_arm()); }).second, 0);
  EXPECT_GT(count([&](Filter& f) { f.add_outcomes(tick.decision().outcome()); }).second, 0);
}

TEST_F(ListTest, RowsAreSelectedByTime) {
  MakeLog();
  v1::ListDecisionsRequest request;
  request.mutable_filter()->set_session_id(session_);
  const auto all = Page(request);
  const v1::AuditSetup& setup = all.setups(1).setup();
  const auto ms = [&](const v1::AuditRow& row) {
    return setup.unix_start_ms() + (row.time_ns() - setup.start_ns()) / kNsPerMs;
  };
  // The rows 1.2 and 1.3. The second segment began later on the wall clock.
  for (const std::string& session : {std::string(), session_}) {
    request.mutable_filter()->set_session_id(session);
    request.mutable_filter()->set_scene("harbour");
    request.mutable_filter()->set_unix_from_ms(ms(all.rows(5)));
    request.mutable_filter()->set_unix_until_ms(ms(all.rows(3)));
    const Places found = PlacesOf(Page(request));
    EXPECT_THAT(found, testing::IsSupersetOf({"a1.3", "a1.2"}));
    EXPECT_THAT(found, testing::Not(testing::Contains("a1.4")));
    EXPECT_THAT(found, testing::Not(testing::Contains("a1.1")));
  }
  request.mutable_filter()->set_unix_from_ms(ms(all.rows(3)) + 86'400'000);
  request.mutable_filter()->clear_unix_until_ms();
  EXPECT_EQ(Page(request).rows_size(), 0);
}

TEST_F(ListTest, OneRowIsReadByItsPlaceOrItsDecision) {
  MakeLog();
  v1::ListDecisionsRequest request;
  request.mutable_filter()->set_session_id(session_);
  request.set_segment(1);
  request.set_row(3);
  EXPECT_EQ(PlacesOf(Page(request)), Places{"a1.3"});
  request.set_row(9);
  EXPECT_EQ(Page(request).rows_size(), 0);
  request.set_row(0);
  Page(request, grpc::StatusCode::INVALID_ARGUMENT);
  request.set_segment(0);
  for (const uint64_t id : {1, 3, 4, 5}) {
    request.set_decision_id(id);
    const auto page = Page(request);
    ASSERT_EQ(page.rows_size(), 1) << id;
    EXPECT_EQ(page.rows(0).decision().id(), id);
  }
  request.set_decision_id(6);
  EXPECT_EQ(Page(request).rows_size(), 0);
  request.mutable_filter()->clear_session_id();
  Page(request, grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(ListTest, AnInvalidTokenIsRefused) {
  for (const std::string token : {"x", "-1", "1.2", "0", "99999999999999999999"}) {
    v1::ListDecisionsRequest request;
    request.set_older_than(token);
    Page(request, grpc::StatusCode::INVALID_ARGUMENT);
  }
  for (const std::string token : {"1", "x.1", "1.0", "1.", "1.2.3", ".1"}) {
    v1::ListDecisionsRequest request;
    request.mutable_filter()->set_session_id("a");
    request.set_older_than(token);
    Page(request, grpc::StatusCode::INVALID_ARGUMENT);
  }
}

TEST_F(ListTest, ACallReadsALimitedPartOfTheLog) {
  priors::SourceUpdate update;
  update.progress.source_id = "long";
  update.progress.commit_sequence = 1;
  update.audit = {.segment = 1, .project = "game", .scene = "harbour", .rows = {}};
  v1::AuditRow row;
  row.set_session("long");
  row.set_segment(1);
  const uint64_t row_count = 2 * kRowsPerList + 10;
  for (uint64_t number = 1; number <= row_count; ++number) {
    row.set_row(number);
    row.set_kind(number == 1 ? v1::AUDIT_KIND_REFUSAL : v1::AUDIT_KIND_SWITCH);
    update.audit.rows.push_back({.number = number, .bytes = row.SerializeAsString()});
  }
  thread_.Submit([update = std::move(update)](priors::PriorStore& store) {
    EXPECT_TRUE(store.Commit({&update, 1}).ok());
  });
  for (const std::string session : {"", "long"}) {
    v1::ListDecisionsRequest request;
    request.mutable_filter()->set_session_id(session);
    request.mutable_filter()->add_kinds(v1::AUDIT_KIND_REFUSAL);
    const auto first = Page(request);
    EXPECT_EQ(first.rows_size(), 0);
    EXPECT_TRUE(first.has_more());
    int calls = 1;
    v1::ListDecisionsResponse page = first;
    for (; page.has_more() && page.rows_size() == 0; ++calls) {
      request.set_older_than(page.older_token());
      page = Page(request);
    }
    ASSERT_EQ(page.rows_size(), 1);
    EXPECT_EQ(page.rows(0).row(), 1u);
    EXPECT_EQ(calls, 3);
    request.clear_older_than();
    request.set_newer_than(first.newer_token());
    EXPECT_EQ(Page(request).has_more(), false) << "the tail continues after the newest row";
  }
}

TEST_F(ListTest, AnExportHasOnlyTheSelectedRowsAndTheSetupsOfTheirSegments) {
  MakeLog();
  v1::ExportDecisionsRequest request;
  request.mutable_filter()->add_kinds(v1::AUDIT_KIND_TICK);
  request.mutable_filter()->set_scene("harbour");
  grpc::ClientContext context;
  const auto reader = v1::AuditService::NewStub(channel_)->ExportDecisions(&context, request);
  std::vector<v1::SegmentSetup> setups;
  Places places;
  for (v1::ExportDecisionsResponse part; reader->Read(&part);) {
    setups.insert(setups.end(), part.setups().begin(), part.setups().end());
    for (const v1::AuditRow& row : part.rows())
      places.push_back(absl::StrCat(row.segment(), ".", row.row()));
  }
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(places, (Places{"1.2", "1.3", "1.4", "2.2", "2.3"}));
  ASSERT_EQ(setups.size(), 2u);
  EXPECT_EQ(setups[1].segment(), 2u);
  EXPECT_GT(setups[1].setup().unix_start_ms(), 0);
}

TEST_F(AuditTest, ManyRowsAreSentInSeveralMessages) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  Play(client, 1, 1'000);
  const std::vector<decision::AuditRow> rows = ExportAudit();
  size_t bytes = 0;
  for (const decision::AuditRow& row : rows) bytes += EncodeAuditRow(row).size();
  EXPECT_GT(bytes, 2 * kAuditBytesPerMessage);
  EXPECT_EQ(Derived(rows).decision_count, 1'000u);
}

TEST_F(AuditTest, RowsAreLostIfTheDiskIsTooSlowAndTheLogContinuesAfterThem) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  Play(client, 1, 2);
  store_.Hold();
  uint64_t message = 2;
  while (server_->counters().lost_audit_row_count < 3) {
    const uint64_t decisions = server_->counters().decision_count;
    client.Send(Frames(++message, 30));
    ASSERT_TRUE(Applied(++applied_));
    Tick();
    ASSERT_TRUE(Eventually([&] { return server_->counters().decision_count > decisions; }));
  }
  store_.Release();
  ASSERT_EQ(client.AwaitAcknowledgement(message), message);
  Play(client, message + 1, message + 5);
  EXPECT_EQ(server_->counters().waiting_audit_bytes, 0u);
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.incomplete_segment_count, 1u);
  EXPECT_GT(report.decision_count, 10u);
  EXPECT_GE(report.underived_decision_count, 5u);
  const auto segments = List();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].first_row(), 1u);
  EXPECT_EQ(segments[0].lost_row_count(), server_->counters().lost_audit_row_count);
}

TEST_F(AuditTest, ATickWithoutEventsCausesNoRowAndNoCommit) {
  TelemetryClient idle(channel_);
  TelemetryClient playing(channel_);
  idle.Open(OneArmHello());
  v1::Hello desert = OneArmHello();
  desert.set_scene("desert");
  playing.Open(desert);
  Play(idle, 1, 1);
  Play(playing, 1, 1);
  Flush();
  const uint64_t commits = server_->counters().stored_commit_count;
  const uint64_t decisions = server_->counters().decision_count;
  Play(playing, 2, 20);
  EXPECT_EQ(server_->counters().stored_commit_count, commits + 19);
  EXPECT_EQ(server_->counters().decision_count, decisions + 19);
  Play(idle, 2, 2);
  EXPECT_EQ(Derived(ExportAudit()).segment_count, 2u);
}

class AuditLossTest : public AuditTest {
 protected:
  AuditLossTest() { log_.sinks().push_back(lines_); }
  // Advances one second, and waits until the daemon's log has a line that contains `text`.
  [[nodiscard]] bool Told(const std::string& text) {
    clock_.Advance(kSecondNs);
    return Eventually([&] {
      for (const std::string& line : lines_->last_formatted()) {
        if (line.find(text) != std::string::npos) return true;
      }
      return false;
    });
  }

  const std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> lines_ =
      std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(16);
};

TEST_F(AuditLossTest, LostRowsAreCountedAndLoggedOnceAMinute) {
  store_.LoseAuditRows(7);
  clock_.Advance(kSecondNs);
  EXPECT_TRUE(Told("7 rows of the audit log could not be written, 7 since the start"));
  EXPECT_EQ(server_->counters().lost_audit_row_count, 7u);
  store_.LoseAuditRows(2);
  clock_.Advance(kSecondNs);
  ASSERT_TRUE(Eventually([&] { return server_->counters().lost_audit_row_count == 9; }));
  store_.LoseAuditRows(1);
  clock_.Advance(60 * kSecondNs);
  EXPECT_TRUE(Told("3 rows of the audit log could not be written, 10 since the start"));
}

TEST_F(AuditLossTest, EvidenceThatPlayersMayNotAddIsCountedAndLogged) {
  store_.LimitPlayers(3);
  clock_.Advance(kSecondNs);
  EXPECT_TRUE(
      Told("3 records of players were not stored, or without their regime, 3 since the start "
           "(the latest: scene s)"));
  EXPECT_EQ(server_->counters().limited_player_evidence_count, 3u);
}

class SmallAuditTest : public AuditTest {
 protected:
  SmallAuditTest() : AuditTest(*storage::OpenMemoryPriorStore(kLimits)) {}
  static constexpr priors::AuditLimits kLimits{.bytes = 20'000};
};

TEST_F(SmallAuditTest, ALiveSessionLosesItsOldestRowsAndTheListingShowsIt) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  Play(client, 1, 200);
  const auto segments = List();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_GT(segments[0].first_row(), 1u);
  EXPECT_EQ(segments[0].first_row() + segments[0].row_count(), 202u) << "including the setup row";
  EXPECT_EQ(segments[0].lost_row_count(), 0u);
  const auto report = Derived(ExportAudit());
  EXPECT_EQ(report.row_count, segments[0].row_count());
  EXPECT_EQ(report.decision_count, 0u);
  EXPECT_EQ(report.underived_decision_count, segments[0].row_count());
  EXPECT_EQ(report.incomplete_segment_count, 1u);
}

class WithoutAuditTest : public AuditTest {
 protected:
  WithoutAuditTest() { options_.keeps_audit = false; }
};

TEST_F(WithoutAuditTest, NothingIsStoredIfTheAuditLogIsOff) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  Play(client, 1, 2);
  EXPECT_TRUE(List().empty());
}

}  // namespace
}  // namespace sweepstake::rpc
