// A commit reaches the disk but its answer is lost, and the session leaves memory before it
// retries.
#include "server/events/event_bus.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::rpc {
namespace {

class LosingStore final : public storage::ForwardingStore {
 public:
  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override {
    absl::Status status = ForwardingStore::Commit(updates);
    return status.ok() ? absl::UnavailableError("the answer was lost") : status;
  }
};

class LostCommitResultTest : public RpcTest {
 protected:
  LostCommitResultTest() : RpcTest(std::make_unique<LosingStore>()) { options_.max_sessions = 1; }
};

TEST_F(LostCommitResultTest, AWatcherStillReceivesTheCommit) {
  const auto stub = v1::PosteriorsService::NewStub(channel_);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
  const auto watcher = stub->WatchPosteriors(&context, {});
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 1; }));
  {
    TelemetryClient game(channel_);
    game.Open(OneArmHello());
    game.Send(Frames(1, 30));
    ASSERT_TRUE(Applied(1));
    Tick();
    ASSERT_TRUE(Eventually([&] { return server_->counters().failed_commit_count == 1; }));
  }
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_stream_count == 0; }));
  TelemetryClient next(channel_);
  next.Open(OneArmHello());  // displaces the first session from memory
  // These calls pass the store and the loop after the event bus's read. When they have returned,
  // the bus has the result of the read.
  for (int i = 0; i < 2; ++i) {
    grpc::ClientContext call;
    v1::ListPosteriorsResponse response;
    ASSERT_TRUE(stub->ListPosteriors(&call, {}, &response).ok());
  }
  clock_.Advance(events::EventBus::kIntervalNs);
  v1::WatchPosteriorsResponse event;
  do {
    ASSERT_TRUE(watcher->Read(&event)) << "no event within a minute";
  } while (event.posterior().arms_size() == 0);
  EXPECT_EQ(event.posterior().arms(0).window_count(), 1u);
  context.TryCancel();
}

}  // namespace
}  // namespace sweepstake::rpc
