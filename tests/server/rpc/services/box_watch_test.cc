// Tests operators who watch the boxes of a session: who may do so, which request the game receives,
// and that nothing is stored.
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>

#include "sweepstake/v1/audit.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using Response = v1::StreamTelemetryResponse;

// An operator that watches a session's boxes.
class Look {
 public:
  Look(const std::shared_ptr<grpc::Channel>& channel, const std::string& session_id,
       const std::string& token = "all-token")
      : stub_(v1::SessionsService::NewStub(channel)) {
    context_.AddMetadata("authorization", "Bearer " + token);
    v1::WatchBoxesRequest request;
    request.set_session_id(session_id);
    reader_ = stub_->WatchBoxes(&context_, request);
  }
  ~Look() { context_.TryCancel(); }

  v1::WatchBoxesResponse Next() {
    v1::WatchBoxesResponse response;
    EXPECT_TRUE(reader_->Read(&response)) << "the stream ended";
    return response;
  }
  grpc::Status Finish() {
    v1::WatchBoxesResponse response;
    while (reader_->Read(&response)) {
    }
    return reader_->Finish();
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<v1::SessionsService::Stub> stub_;
  std::unique_ptr<grpc::ClientReader<v1::WatchBoxesResponse>> reader_;
};

v1::StreamTelemetryRequest View(uint64_t frame) {
  v1::StreamTelemetryRequest request;
  v1::BoxView& view = *request.mutable_box_view();
  view.set_frame_index(frame);
  view.set_object_count(1);
  view.set_stride(1);
  for (const float bound : {0.F, 0.F, 0.F, 1.F, 1.F, 1.F}) view.add_bounds(bound);
  view.set_boxes(std::string(12, '\x7f'));
  return request;
}

class BoxWatchTest : public RpcTest {
 protected:
  BoxWatchTest() {
    options_.tokens = &tokens_;
    tokens_.Add("all", auth::Role::kAdmin);
    tokens_.Add("reader", auth::Role::kWatch);
    tokens_.Add("other", auth::Role::kOperator, {"other"});
  }

  static v1::Hello Hello(bool shows) {
    v1::Hello hello = OneArmHello();
    if (shows) hello.add_capabilities(v1::CAPABILITY_BOX_VIEW);
    return hello;
  }
  static v1::BoxRequest Asked(TelemetryClient& game) {
    return game.Await(&Response::has_box_request).box_request();
  }

  ScriptedTokens tokens_;
};

TEST_F(BoxWatchTest, TheGameIsAskedWhileThereAreViewersAndItsViewsArePassedOn) {
  TelemetryClient game(channel_, "all-token");
  const v1::Welcome welcome = game.Open(Hello(true));
  ASSERT_EQ(welcome.capabilities_size(), 1);
  EXPECT_EQ(welcome.capabilities(0), v1::CAPABILITY_BOX_VIEW);
  {
    Look look(channel_, welcome.session_id());
    const v1::BoxRequest asked = Asked(game);
    EXPECT_EQ(asked.interval_ms(), 250u);
    EXPECT_EQ(asked.max_bytes(), 65'536u);
    game.Send(View(5));
    const v1::WatchBoxesResponse shown = look.Next();
    EXPECT_EQ(shown.view().SerializeAsString(), View(5).box_view().SerializeAsString());
    EXPECT_GT(shown.stamp().sequence(), 0u);
    clock_.Advance(asked.until_ms() * int64_t{1'000'000} / 2);
    EXPECT_EQ(Asked(game).interval_ms(), 250u) << "the request is renewed before it expires";
  }
  EXPECT_EQ(Asked(game).interval_ms(), 0u) << "there are no viewers left";
}

// A sink that takes a snapshot only after the first view. Used on the server's loop.
class LateSink final : public events::Sink {
 public:
  void Begin(std::unique_ptr<events::Subscriber> subscriber) override {
    subscriber_ = std::move(subscriber);
  }
  // The first call is made when the subscription begins, the second call for the view.
  void Wake() override {
    if (++wake_count_ != 2) return;
    snapshot_count = subscriber_->TakeSnapshot()->events.size();
    later_count = subscriber_->Take(10).size();
    has_taken = true;
  }
  void OnEnd(const absl::Status& /*status*/) override {
    subscriber_.reset();
    has_ended = true;
  }

  std::atomic<size_t> snapshot_count = 0;
  std::atomic<size_t> later_count = 0;
  std::atomic<bool> has_taken = false;
  std::atomic<bool> has_ended = false;

 private:
  std::unique_ptr<events::Subscriber> subscriber_;
  int wake_count_ = 0;
};

TEST_F(BoxWatchTest, AViewThatIsInTheSnapshotIsNotSentAgain) {
  TelemetryClient game(channel_, "all-token");
  v1::WatchBoxesRequest request;
  request.set_session_id(game.Open(Hello(true)).session_id());
  const auto sink = std::make_shared<LateSink>();
  ASSERT_TRUE(server_->WatchOverHttp(request, "ipv4:127.0.0.1:1", "all-token", sink));
  Asked(game);
  game.Send(View(5));
  EXPECT_TRUE(Eventually([&] { return sink->has_taken.load(); }));
  EXPECT_EQ(sink->snapshot_count, 1u);
  EXPECT_EQ(sink->later_count, 0u);
  server_->Drain(std::chrono::milliseconds(0));
  ASSERT_TRUE(Eventually([&] { return sink->has_ended.load(); }));
}

TEST_F(BoxWatchTest, AViewIsNeitherEvidenceNorLogged) {
  TelemetryClient game(channel_, "all-token");
  const v1::Welcome welcome = game.Open(Hello(true));
  Look look(channel_, welcome.session_id());
  Asked(game);
  game.Send(View(5));
  look.Next();
  EXPECT_EQ(server_->counters().applied_message_count, 0u);
  EXPECT_EQ(server_->counters().replayed_message_count, 0u);
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer all-token");
  // Rows come from the session's start, its decisions and its events. Here at most the row of the
  // start exists.
  v1::ListAuditSegmentsResponse listed;
  const auto reader = v1::AuditService::NewStub(channel_)->ListAuditSegments(&context, {});
  uint64_t rows = 0;
  while (reader->Read(&listed)) {
    for (const v1::AuditSegment& segment : listed.segments()) rows += segment.row_count();
  }
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_LE(rows, 1u);
}

TEST_F(BoxWatchTest, IsRestrictedToOperatorsOfTheProject) {
  TelemetryClient game(channel_, "all-token");
  const std::string id = game.Open(Hello(true)).session_id();
  EXPECT_EQ(Look(channel_, id, "reader-token").Finish().error_code(),
            grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(Look(channel_, id, "other-token").Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Look(channel_, "no such").Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(BoxWatchTest, AGameThatDoesNotShowItsBoxesIsNotAsked) {
  TelemetryClient game(channel_, "all-token");
  const v1::Welcome welcome = game.Open(Hello(false));
  EXPECT_EQ(welcome.capabilities_size(), 0);
  const grpc::Status refused = Look(channel_, welcome.session_id()).Finish();
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(refused.error_message(), ::testing::HasSubstr("allow_box_view"));
}

TEST_F(BoxWatchTest, ASessionHasAtMostTwoViewers) {
  TelemetryClient game(channel_, "all-token");
  const std::string id = game.Open(Hello(true)).session_id();
  Look first(channel_, id);
  Look second(channel_, id);
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 2; }));
  EXPECT_EQ(Look(channel_, id).Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  game.Send(View(1));
  EXPECT_EQ(first.Next().view().frame_index(), 1u);
  EXPECT_EQ(second.Next().view().frame_index(), 1u);
}

TEST_F(BoxWatchTest, ContinuesWhenTheGameReconnectsAndEndsWithTheSession) {
  auto game = std::make_unique<TelemetryClient>(channel_, "all-token");
  const v1::Welcome welcome = game->Open(Hello(true));
  Look look(channel_, welcome.session_id());
  Asked(*game);
  game.reset();
  TelemetryClient back(channel_, "all-token");
  v1::Hello hello = Hello(true);
  Resume(hello, welcome);
  ASSERT_TRUE(back.Open(hello).resumed());
  EXPECT_EQ(Asked(back).interval_ms(), 250u);
  back.Send(View(9));
  EXPECT_EQ(look.Next().view().frame_index(), 9u);
  back.Send(Goodbye());
  EXPECT_TRUE(look.Finish().ok());
}

TEST_F(BoxWatchTest, AnInvalidViewEndsTheStream) {
  const auto refusal_of = [&](const std::function<void(v1::BoxView&)>& change) {
    TelemetryClient game(channel_, "all-token");
    game.Open(Hello(true));
    v1::StreamTelemetryRequest view = View(1);
    change(*view.mutable_box_view());
    game.Send(view);
    return game.Finish().error_code();
  };
  constexpr auto kInvalid = grpc::StatusCode::INVALID_ARGUMENT;
  EXPECT_EQ(refusal_of([](v1::BoxView& view) { view.set_boxes(std::string(13, 'x')); }), kInvalid);
  EXPECT_EQ(refusal_of([](v1::BoxView& view) { view.set_pairs("abc"); }), kInvalid);
  EXPECT_EQ(refusal_of([](v1::BoxView& view) { view.clear_bounds(); }), kInvalid);
  EXPECT_EQ(refusal_of([](v1::BoxView& view) { view.set_bounds(2, INFINITY); }), kInvalid);
  EXPECT_EQ(refusal_of([](v1::BoxView& view) { view.set_pairs(std::string(65'536, 'x')); }),
            kInvalid);
}

}  // namespace
}  // namespace sweepstake::rpc
