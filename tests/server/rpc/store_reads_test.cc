// Tests reads concurrent with commits: only the resumption of a session waits for a commit, and no
// older state replaces a newer one.
#include "server/storage/backup/automatic_backup.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/storage/forwarding_store.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::rpc {
namespace {

// A base class, so that its members exist before the store and its threads.
class WithOpenedStore {
 protected:
  const test_support::TemporaryDirectory directory_;
  storage::OpenedStore opened_ = *storage::OpenStoreOrBackup(directory_.path() / "priors.db");
};

class StoreReadsTest : public WithOpenedStore, public RpcTest {
 protected:
  StoreReadsTest() : RpcTest(std::move(opened_.store), std::move(opened_.reads)) {
    options_.max_sessions = 1;
  }
  // Blocks commits until `release_` is set.
  void HoldCommits() {
    thread_.Submit([this](priors::PriorStore&) { release_.get_future().wait(); });
    ASSERT_TRUE(Eventually([&] { return thread_.queued_count() == 0; }));
  }
  [[nodiscard]] bool Gone() {
    return Eventually([&] { return server_->counters().open_stream_count == 0; });
  }

  std::promise<void> release_;
};

TEST_F(StoreReadsTest, ANewSessionAListAndAnExportAreAnsweredWhileCommitsWait) {
  {
    TelemetryClient client(channel_);
    LearnOneWindow(client, HelloMessage());
  }
  ASSERT_TRUE(Gone());
  HoldCommits();
  const v1::Welcome welcome = TelemetryClient(channel_).Open(HelloMessage());
  EXPECT_FALSE(welcome.priors_unavailable());
  EXPECT_EQ(welcome.prior_source_count(), 1u);
  v1::ListPosteriorsResponse list;
  grpc::ClientContext list_context;
  EXPECT_TRUE(
      v1::PosteriorsService::NewStub(channel_)->ListPosteriors(&list_context, {}, &list).ok());
  EXPECT_EQ(list.scenes_size(), 1);
  grpc::ClientContext export_context;
  const auto records = v1::PriorsService::NewStub(channel_)->ExportPriors(&export_context, {});
  v1::ExportPriorsResponse page;
  EXPECT_TRUE(records->Read(&page));
  EXPECT_EQ(page.records_size(), 1);
  EXPECT_FALSE(records->Read(&page));
  release_.set_value();
}

TEST_F(StoreReadsTest, AResumedSessionWaitsForItsCommitEvenIfItHasLeftMemory) {
  v1::Hello hello = OneArmHello();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
    client.Send(Frames(2, 30));
    ASSERT_TRUE(Applied(2));
    HoldCommits();
    Tick();
    ASSERT_TRUE(Eventually([&] { return thread_.queued_count() == 1; }));
  }
  ASSERT_TRUE(Gone());
  TelemetryClient(channel_).Open(OneArmHello());  // displaces the session in memory
  ASSERT_TRUE(Gone());
  TelemetryClient client(channel_);
  client.Send(Request(hello));
  ASSERT_TRUE(Eventually([&] { return thread_.queued_count() == 2; }));
  release_.set_value();
  const v1::Welcome welcome = client.Await(&v1::StreamTelemetryResponse::has_welcome).welcome();
  EXPECT_TRUE(welcome.resumed());
  EXPECT_EQ(welcome.session_id(), hello.session_id());
  EXPECT_EQ(welcome.acknowledged_sequence(), 2u);
}

priors::SourceUpdate OneWindowOf(const std::string& source) {
  priors::SourceUpdate update;
  update.progress.source_id = source;
  update.progress.commit_sequence = 1;
  priors::KeyedEvidence increment;
  increment.key.project = "game";
  increment.key.scene = "harbour";
  increment.key.arm = "Grid";
  increment.evidence = {.alpha = 0.5, .beta = 0.5, .window_count = 1, .bail_out_count = 0};
  update.increments.push_back(increment);
  return update;
}

// A reader that holds back the results of a list until the test releases them.
class LateReader final : public storage::ForwardingStore {
 public:
  absl::StatusOr<std::vector<priors::SceneEvidence>> List(
      const priors::SceneFilter& filter, const std::optional<priors::SceneKey>& after,
      uint32_t limit) override {
    auto page = ForwardingStore::List(filter, after, limit);
    asked.set_value();
    release.get_future().wait();
    return page;
  }

  std::promise<void> asked;
  std::promise<void> release;
};

class LateReads final : public storage::ReadConnection {
 public:
  explicit LateReads(priors::PriorReader& reader) : reader_(reader) {}
  priors::PriorReader& Begin() override { return reader_; }
  void End() override {}

 private:
  priors::PriorReader& reader_;
};

// A base class, so that its members exist before the store and its threads.
template <typename Reader>
class WithReader {
 protected:
  Reader reader_;
};

// Reads come from `reader_`, which is another store than the store for commits.
template <typename Reader>
class OtherReaderTest : public WithReader<Reader>, public RpcTest {
 protected:
  OtherReaderTest()
      : RpcTest(*storage::OpenMemoryPriorStore(), std::make_unique<LateReads>(this->reader_)) {}
};

using LatePageTest = OtherReaderTest<LateReader>;

TEST_F(LatePageTest, DoesNotReplaceNewerStateOfAWatcher) {
  const auto old = OneWindowOf("a");
  ASSERT_TRUE(reader_.Commit({&old, 1}).ok());
  std::promise<void> stored;
  thread_.Commit(old, [&](const absl::Status&) { stored.set_value(); });
  stored.get_future().wait();
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  grpc::ClientContext context;
  const auto posteriors = v1::PosteriorsService::NewStub(channel_);
  const auto watcher = posteriors->WatchPosteriors(&context, {});
  reader_.asked.get_future().wait();
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  client.AwaitAcknowledgement(1);
  // The event bus reads the scene on the thread that writes. The loop has the result after the
  // second message.
  Flush();
  for (uint64_t sequence = 2; sequence <= 5; ++sequence) {
    client.Send(Frames(sequence, 1));
    ASSERT_TRUE(Applied(sequence));
    if (sequence == 3) clock_.Advance(events::EventBus::kIntervalNs);
  }
  reader_.release.set_value();
  v1::WatchPosteriorsResponse event;
  while (!event.has_posterior()) ASSERT_TRUE(watcher->Read(&event));
  EXPECT_EQ(event.posterior().arms(0).window_count(), 2u);
  context.TryCancel();
}

// Exports a first page of records that is far larger than gRPC's buffers for a client that does not
// read. It holds back the next page until the test releases it.
class LongExport final : public storage::ForwardingStore {
 public:
  absl::StatusOr<priors::ExportPage> Export(const priors::SceneFilter& /*filter*/,
                                            const priors::ExportPlace& after,
                                            uint32_t limit) override {
    if (after.source_number == 0)
      return priors::ExportPage{.records = {size_t{10} * limit, LongRecord()}, .next = {{}, 1}};
    asked.set_value();
    release.get_future().wait();
    return priors::ExportPage{};
  }

  std::promise<void> asked;
  std::promise<void> release;

 private:
  static priors::PriorRecord LongRecord() {
    const std::string name(128, 'x');
    priors::PriorRecord record;
    record.key = {name, name, "", name, 1, name, 1};
    record.source_id = record.build = name;
    record.source_sequence = 1;
    return record;
  }
};

class PageAheadTest : public OtherReaderTest<LongExport> {
 protected:
  // Begins an export that is not read, and whose next page has been requested.
  std::unique_ptr<grpc::ClientReader<v1::ExportPriorsResponse>> Begin() {
    auto records = v1::PriorsService::NewStub(SmallWindowChannel())->ExportPriors(&context_, {});
    const auto asked = reader_.asked.get_future();
    EXPECT_TRUE(Eventually(
        [&] { return asked.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }));
    return records;
  }

  grpc::ClientContext context_;
};

TEST_F(PageAheadTest, APageIsReadWhileThePreviousOneIsSent) {
  const auto records = Begin();
  v1::ExportPriorsResponse page;
  EXPECT_TRUE(records->Read(&page));
  reader_.release.set_value();
  EXPECT_FALSE(records->Read(&page));
  EXPECT_TRUE(records->Finish().ok());
}

TEST_F(PageAheadTest, APageThatArrivesAfterItsClientLeftIsDropped) {
  const auto records = Begin();
  context_.TryCancel();
  EXPECT_EQ(records->Finish().error_code(), grpc::StatusCode::CANCELLED);
  reader_.release.set_value();
  // The welcome shows that the page was dropped: the same thread handles the Hello after the page.
  EXPECT_FALSE(TelemetryClient(channel_).Open(HelloMessage()).session_id().empty());
}

}  // namespace
}  // namespace sweepstake::rpc
