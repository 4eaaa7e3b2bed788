// Tests the cost of streams without a session: streams that never send Hello, and streams whose
// client gave up while the store was busy.
#include <vector>

#include "server/auth/failure_limit.h"
#include "server/rpc/common/refusal_log.h"
#include "server/rpc/open_connections.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

// Counts the reads of the store that Hellos cause.
class CountingStore final : public storage::ForwardingStore {
 public:
  explicit CountingStore(std::atomic<uint64_t>& load_count) : load_count_(load_count) {}

  absl::StatusOr<std::vector<priors::SceneSource>> LoadSources(
      const priors::SceneKey& scene) override {
    ++load_count_;
    return ForwardingStore::LoadSources(scene);
  }

 private:
  std::atomic<uint64_t>& load_count_;
};

// A base class, so that the counter exists before the store that uses it.
class LoadCount {
 protected:
  std::atomic<uint64_t> load_count_{0};
};

class StreamBoundsTest : public LoadCount, public RpcTest {
 protected:
  StreamBoundsTest() : RpcTest(std::make_unique<CountingStore>(load_count_)) {
    options_.max_sessions = 1;
    options_.max_streams_per_connection = 2'000;
  }
  [[nodiscard]] bool StreamsOpen(uint64_t count) {
    return Eventually([&] { return server_->counters().open_stream_count == count; });
  }
  // Keeps the store's thread busy until `release` is set.
  void Block(std::promise<void>& release) {
    thread_.Submit([&](priors::PriorStore&) { release.get_future().wait(); });
  }
};

// Other tests shorten times and lower limits; these are the defaults that users get.
TEST(AttackBoundsTest, DefaultsMatchTheListOfAttacks) {
  const RpcOptions options;
  EXPECT_EQ(options.handshake_patience, std::chrono::seconds(10));
  EXPECT_EQ(options.connection_idle_patience, std::chrono::minutes(1));
  EXPECT_EQ(options.watcher_patience_ns, 20 * kSecondNs);
  EXPECT_EQ(options.transfer_patience_ns, 1'800 * kSecondNs);
  EXPECT_EQ(RefusalLog::kIntervalNs, 10 * kSecondNs);
  EXPECT_EQ(options.max_streams_per_connection, 100u);
  EXPECT_EQ(options.max_projects, 100u);
  EXPECT_EQ(options.max_scenes, 1'000u);
  EXPECT_EQ(options.memory_quota_bytes, uint64_t{64} << 20);
  EXPECT_EQ(kMaxMessageBytes, 256u * 1024);
  EXPECT_EQ(kMaxBatchFrames, 240u);
  EXPECT_EQ(kMaxImportRecords, 200'000u);
  EXPECT_EQ(kMaxStreamsWithoutSession, 1'000u);
  EXPECT_EQ(OpenConnections::kSpare, 1'000u);
  EXPECT_EQ(auth::FailureLimit::kMaxFailures, 10u);
  EXPECT_EQ(auth::FailureLimit::kIntervalNs, 60 * kSecondNs);
}

TEST_F(StreamBoundsTest, NothingIsReadForHellosOfClientsThatLeft) {
  std::promise<void> release;
  Block(release);
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  for (size_t count = 1; count <= 100; ++count) {
    clients.push_back(std::make_unique<TelemetryClient>(channel_));
    clients.back()->Send(Request(HelloMessage()));
    ASSERT_TRUE(Eventually([&] { return store_.submit_count() == count; }));
  }
  clients.clear();
  ASSERT_TRUE(StreamsOpen(0));
  release.set_value();
  Flush();
  EXPECT_EQ(load_count_, 0u);
}

TEST_F(StreamBoundsTest, StreamsWithoutASessionAreCountedToo) {
  std::promise<void> release;
  Block(release);
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  const auto begin_stream = [&] {
    clients.push_back(std::make_unique<TelemetryClient>(channel_));
    clients.back()->Send(Request(HelloMessage()));
  };
  const uint64_t max_count = options_.max_sessions + kMaxStreamsWithoutSession;
  while (clients.size() < max_count) begin_stream();
  ASSERT_TRUE(StreamsOpen(max_count));
  EXPECT_EQ(ReasonOf(TelemetryClient(channel_).Finish()), v1::ERROR_REASON_TOO_MANY_STREAMS);
  clients.pop_back();
  ASSERT_TRUE(StreamsOpen(max_count - 1));
  begin_stream();
  EXPECT_TRUE(StreamsOpen(max_count));
  release.set_value();
}

}  // namespace
}  // namespace sweepstake::rpc
